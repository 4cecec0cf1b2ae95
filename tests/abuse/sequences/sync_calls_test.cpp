// Random streams of stamps: sorting, clock fits and the synchroniser, each compared with brute
// force.

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>
#include <wayfare/sync/augmented_scans.hpp>
#include <wayfare/sync/clock_fit.hpp>
#include <wayfare/sync/in_order.hpp>

#include "abuse/abuse.hpp"

namespace wayfare::tests {
namespace {

struct Stamped {
  LogTime time;
  int label = 0;
};

/// By the documentation of sort_by_time, on the list as it is.
std::vector<Stamped> sorted_by_hand(std::vector<Stamped> all, Duration reach, SortReport& report) {
  const auto far = [&](std::size_t i, std::size_t k) {
    const LogTime a = std::max(all[i].time, all[k].time), b = std::min(all[i].time, all[k].time);
    return a - b > reach;
  };
  const std::size_t n = all.size();
  std::vector<Stamped> kept;
  for (std::size_t i = 0; i < n; ++i) {
    bool damaged = false;
    if (n >= 3 && i == 0) damaged = far(0, 1) && !far(1, 2);
    if (n >= 3 && i + 1 == n) damaged = far(i, i - 1) && !far(i - 1, i - 2);
    if (i > 0 && i + 1 < n) damaged = far(i, i - 1) && far(i, i + 1) && !far(i - 1, i + 1);
    if (!damaged) kept.push_back(all[i]);
  }
  report.outliers = n - kept.size();
  for (std::size_t i = 1; i < kept.size(); ++i)
    report.out_of_order += kept[i].time < kept[i - 1].time;
  std::map<LogTime, Stamped> first;  // emplace keeps the first of equal times
  for (const Stamped& s : kept) report.duplicates += first.emplace(s.time, s).second ? 0 : 1;
  std::vector<Stamped> result;
  for (const auto& [time, s] : first) result.push_back(s);
  return result;
}

TEST(InOrderCalls, AnyStampsAsByHand) {
  for (std::uint64_t seed = 0; seed < 3000; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Rng rng(seed);
    std::vector<Stamped> all(rng.below(12));
    for (std::size_t i = 0; i < all.size(); ++i) {
      std::int64_t ns = static_cast<std::int64_t>(i + rng.below(3)) * 1'000'000'000;
      if (rng.below(5) == 0) ns = static_cast<std::int64_t>(rng()) >> rng.below(40);
      all[i] = {LogTime::from_nanoseconds(ns), static_cast<int>(i)};
    }
    const Duration reach = rng.below(4) == 0
                               ? Duration(static_cast<std::int64_t>(rng.below(5'000'000'000)))
                               : Duration(std::chrono::seconds(60));
    SortReport expected;
    const std::vector<Stamped> by_hand = sorted_by_hand(all, reach, expected);
    const SortReport report = sort_by_time(all, reach);
    ASSERT_EQ(report.outliers, expected.outliers);
    ASSERT_EQ(report.out_of_order, expected.out_of_order);
    ASSERT_EQ(report.duplicates, expected.duplicates);
    ASSERT_EQ(all.size(), by_hand.size());
    for (std::size_t i = 0; i < all.size(); ++i) {
      ASSERT_EQ(all[i].time, by_hand[i].time);
      ASSERT_EQ(all[i].label, by_hand[i].label);
    }
  }
}

// Without rejection the line is that of the normal equations.
TEST(ClockFitCalls, IsTheLeastSquaresLineAndGainsNothingFromOtherLines) {
  for (std::uint64_t seed = 0; seed < 500; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Rng rng(seed);
    std::vector<ClockPair<DeviceClock>> pairs(2 + rng.below(30));
    const double rate = rng.normal(1.0, 1e-3), epoch_s = rng.uniform(-1e9, 1e9);
    for (auto& pair : pairs) {
      const double t = rng.uniform(0.0, 1000.0);
      pair.device = Time<DeviceClock>::from_seconds(t);
      pair.log = LogTime::from_seconds(epoch_s) + from_seconds(rate * t + rng.normal(0.0, 1e-3));
    }
    const auto fit = fit_clock<DeviceClock>(pairs, {.rounds = 1});
    ASSERT_TRUE(fit);
    ASSERT_EQ(fit->used, pairs.size());
    const auto cost = [&](double rate_change, double offset_s) {
      ClockFit<DeviceClock> other = *fit;
      other.rate += rate_change;
      other.log_origin += from_seconds(offset_s);
      double sum = 0.0;
      for (const auto& pair : pairs) {
        const double r = to_seconds(pair.log - other(pair.device));
        sum += r * r;
      }
      return sum;
    };
    const double least = cost(0.0, 0.0);
    for (const double change : {-1e-6, 1e-6}) ASSERT_GT(cost(change, 0.0) + 1e-10, least);
    for (const double offset : {-1e-5, 1e-5}) ASSERT_GT(cost(0.0, offset) + 1e-10, least);
    ASSERT_NEAR(fit->residual_s, std::sqrt(least / static_cast<double>(pairs.size())), 1e-7);
  }
}

double maybe(Rng& rng) {
  return rng.below(15) == 0 ? kNotFinite[rng.below(3)] : rng.uniform(-1.0, 1.0);
}

// Streams pushed in any interleaving with damaged stamps: order, sums and counts are kept.
TEST(SynchroniserCalls, NothingIsLostOrDoubledInAnyOrder) {
  for (std::uint64_t seed = 0; seed < 400; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Rng rng(seed);
    SyncParams params;
    params.scans = 1 + rng.below(5);
    params.min_scans = 1 + rng.below(3);
    RobotSynchroniser synchroniser(params);
    std::size_t refused = 0, accepted_lasers = 0, accepted_radar = 0, lasers = 0, radar = 0;
    double rolled = 0.0, delivered = 0.0;
    bool wheels_started = false;
    std::optional<LogTime> last;
    const auto take = [&] {
      while (const auto step = synchroniser.next()) {
        if (last) {
          ASSERT_GE(step->time, *last);
          ASSERT_EQ(step->since, step->time - *last);
        }
        last = step->time;
        ASSERT_TRUE(std::isfinite(step->wheels.left_m) &&
                    std::isfinite(step->gyro.turn_rate_rad_s));
        delivered += step->wheels.left_m;
        lasers += step->laser ? 1 : 0;
        radar += step->radar ? step->radar->scans : 0;
      }
    };
    double now = 0.0;
    for (int i = 0; i < 150; ++i) {
      now += rng.uniform(0.0, 0.06);
      if (rng.below(60) == 0) now += rng.below(2) == 0 ? 1.0 : 1e7;
      double s = now;
      if (rng.below(20) == 0) s -= rng.uniform(0.0, 3.0);
      const LogTime time = LogTime::from_seconds(s);
      bool accepted = false;
      switch (rng.below(5)) {
        case 0:
          accepted = synchroniser.push(LaserScan{time, {}, {}, 0.0F, 1.0F, {}});
          accepted_lasers += accepted ? 1 : 0;
          break;
        case 1:
          accepted =
              synchroniser.push(RadarScan{time, {{1, 2, 0, 0, 10}, {float(kNan), 0, 0, 0, 0}}});
          accepted_radar += accepted ? 1 : 0;
          break;
        case 2:
          accepted = synchroniser.push(GyroSample{time, maybe(rng)});
          break;
        default: {
          const double m = maybe(rng);
          const std::size_t gaps = synchroniser.statistics().refused_not_finite;
          accepted = synchroniser.push(WheelSample{time, m, m});
          if (accepted && wheels_started) rolled += m;
          if (accepted || synchroniser.statistics().refused_not_finite > gaps)
            wheels_started = true;
        }
      }
      refused += accepted ? 0 : 1;
      if (rng.below(3) == 0) take();
      if (::testing::Test::HasFatalFailure()) return;
    }
    if (rng.below(3) == 0) {
      RobotSynchroniser moved(std::move(synchroniser));
      synchroniser = std::move(moved);
    }
    // A last step beyond all samples, so that none remains between two of the time base.
    ASSERT_TRUE(
        synchroniser.push(LaserScan{LogTime::from_seconds(now + 1.0), {}, {}, 0.0F, 1.0F, {}}));
    ++accepted_lasers;
    synchroniser.finish();
    take();
    const SyncStatistics& statistics = synchroniser.statistics();
    ASSERT_EQ(statistics.refused_late + statistics.refused_not_finite, refused);
    ASSERT_EQ(lasers, accepted_lasers);
    ASSERT_EQ(radar + statistics.dropped_scans, accepted_radar);
    ASSERT_NEAR(delivered, rolled, 1e-6);
  }
}

}  // namespace
}  // namespace wayfare::tests
