// Random streams of readings, ranges and fixes, with every fault of a real one: what is accepted
// has the same result as if nothing else had ever come.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/nav/gnss_ins.hpp>

#include <wayfare/testing/filter_laws.hpp>

#include "abuse/abuse.hpp"
#include "nav/gnss_ins_support.hpp"

namespace wayfare {
namespace {

using namespace tests;

/// Half a minute of driving at 20 Hz, with ranges and fixes at 2 Hz.
struct Streams {
  Drive drive{.rest_s = 1.0};
  Simulated simulated = simulate(drive, 30.0, 0.05);
  std::vector<RangeEpoch> ranges = simulate_ranges(drive, simulated, 0.5, {}, 3);
  std::vector<GnssFix> fixes;

  Streams() {
    Rng rng(4);
    for (std::size_t i = 10; i < simulated.truth.size(); i += 10) {
      const NavState& t = simulated.truth[i];
      GnssFix f;
      f.time = t.time;
      f.position = geodetic_from_ned({rng.normal(), rng.normal(), rng.normal()}, t.position);
      f.velocity_ned_mps = t.velocity_ned_mps;
      f.velocity_covariance_ned *= 0.01;
      fixes.push_back(f);
    }
  }
};

const Streams& streams() {
  static const Streams s;
  return s;
}

const LogTime kNever = LogTime() + Duration::min();

/// A filter, and a second one that only receives what the first has accepted.
class Pair {
 public:
  explicit Pair(const GnssInsOptions& options) : abused_(options), model_(options) {}

  void start(const GnssInsStart& start) {
    abused_.start(start);
    model_.start(start);
    newest_ = kNever;
  }
  template <class Measurement>
  bool add(const Measurement& m) {
    const bool used = abused_.add(m).has_value();
    if (used) {
      const auto again = model_.add(m);
      EXPECT_TRUE(again) << again.error().to_string();
    }
    return used;
  }
  /// The filter moves to another place, or to a place where one has been.
  void move(Rng& rng) {
    GnssIns elsewhere(std::move(abused_));
    if (rng.below(2) == 0) {
      abused_ = GnssIns(GnssInsOptions{});
      static_cast<void>(abused_.add(streams().simulated.imu[5]));
    }
    abused_ = std::move(elsewhere);
  }
  void check() {
    ASSERT_EQ(abused_.started(), model_.started());
    for (const GnssInsNotice& n : abused_.take_notices()) note(n.text);
    if (!abused_.started()) return;
    const GnssInsEstimate a = abused_.estimate(), b = model_.estimate();
    ASSERT_TRUE(a.nav.time == b.nav.time);
    ASSERT_EQ(a.nav.velocity_ned_mps, b.nav.velocity_ned_mps);
    ASSERT_EQ(a.nav.position.latitude.radians(), b.nav.position.latitude.radians());
    ASSERT_EQ(a.nav.q_nb.quaternion().coeffs(), b.nav.q_nb.quaternion().coeffs());
    ASSERT_EQ(a.covariance, b.covariance);
    ASSERT_TRUE(a.nav.velocity_ned_mps.allFinite());
    ASSERT_TRUE(a.nav.q_nb.quaternion().coeffs().allFinite());
    ASSERT_TRUE(std::isfinite(a.nav.position.longitude.radians()));
    ASSERT_TRUE(std::isfinite(a.nav.position.height_m));
    ASSERT_TRUE(std::isfinite(a.clock_bias_m) && std::isfinite(a.clock_drift_mps));
    const Eigen::MatrixXd symmetric = 0.5 * (a.covariance + a.covariance.transpose());
    ASSERT_TRUE(testing::is_covariance(symmetric));
    ASSERT_GE(a.nav.time, newest_) << "time went back";
    newest_ = a.nav.time;
  }
  void note(const std::string& text) {
    restarted_ = restarted_ || text.find("reinitialising") != text.npos;
    // The epoch it starts from may be older than the readings.
    if (text.find("navigation started") != text.npos) newest_ = kNever;
  }
  [[nodiscard]] const GnssIns& filter() const { return abused_; }
  [[nodiscard]] bool restarted() const { return restarted_; }

 private:
  GnssIns abused_, model_;
  LogTime newest_ = kNever;
  bool restarted_ = false;
};

/// Feeds a pair with the streams and with what should not come, and writes down what it does.
class Schedule {
 public:
  explicit Schedule(std::uint64_t seed) : rng_(seed), pair_(options()) {
    if (rng_.below(2) == 0) {
      GnssInsStart start{streams().simulated.truth.front(), 1.0, 0.1, 0.01, 0.05};
      pair_.start(start);
    }
  }
  void run(int calls) {
    for (int i = 0; i < calls && next_ + 1 < streams().simulated.imu.size(); ++i) {
      step();
      if (i % 8 == 0) pair_.check();
      if (::testing::Test::HasFatalFailure()) return;
    }
    pair_.check();
  }
  [[nodiscard]] const std::string& calls() const { return calls_; }
  [[nodiscard]] const Pair& pair() const { return pair_; }

 private:
  GnssInsOptions options() {
    GnssInsOptions o;
    o.max_imu_gap_s = 2.0;
    o.zero_velocity_updates = rng_.below(2) == 0;
    o.imu_time_offset_s = rng_.below(4) == 0 ? 0.013 : 0.0;
    return o;
  }
  template <class... Text>
  void note(const Text&... text) {
    ((calls_ += text), ...);
    calls_ += '\n';
  }

  void step() {
    const std::uint64_t what = rng_.below(100);
    if (what < 70) return reading();
    if (what < 76) return late_gnss();
    if (what < 79) return gap();
    if (what < 84) return bad_reading();
    if (what < 90) return bad_gnss();
    if (what < 95) return repeated();
    if (what < 98) return pair_.move(rng_);
    outage_ = !outage_;
    note(outage_ ? "outage" : "satellites");
  }

  const std::vector<ImuSample>& imu() const { return streams().simulated.imu; }

  void reading() {
    const ImuSample& s = imu()[next_++];
    note("imu ", std::to_string(s.time.seconds()));
    EXPECT_TRUE(pair_.add(s));
    fed_ = next_;
    while (ranges_ < streams().ranges.size() && streams().ranges[ranges_].time <= s.time) {
      const std::size_t i = ranges_++;
      if (!outage_ && rng_.below(4) != 0) gnss(i);
    }
  }
  /// Ranges or fix number i, or both.
  void gnss(std::size_t i) {
    const auto kind = rng_.below(3);
    note("gnss ", std::to_string(i), " kind ", std::to_string(kind));
    if (kind != 0) static_cast<void>(pair_.add(streams().ranges[i]));
    if (kind != 1) static_cast<void>(pair_.add(streams().fixes[i]));
  }
  void late_gnss() {
    if (ranges_ > 0) gnss(ranges_ - 1 - rng_.below(std::min<std::size_t>(ranges_, 12)));
  }
  void gap() {
    const std::size_t skipped = 1 + rng_.below(rng_.below(4) == 0 ? 60 : 15);
    note("gap ", std::to_string(skipped));
    next_ = std::min(next_ + skipped, imu().size() - 1);
  }
  void repeated() {
    if (fed_ == 0) return;
    note("old imu");
    EXPECT_FALSE(pair_.add(imu()[fed_ - 1 - rng_.below(std::min<std::size_t>(fed_, 5))]));
    if (ranges_ == 0) return;
    note("twice");
    const std::size_t i = ranges_ - 1;
    static_cast<void>(pair_.add(streams().fixes[i]));
    EXPECT_FALSE(pair_.add(streams().fixes[i])) << "a fix twice";
    static_cast<void>(pair_.add(streams().ranges[i]));
    EXPECT_FALSE(pair_.add(streams().ranges[i])) << "ranges twice";
  }
  void bad_reading() {
    ImuSample s = imu()[next_];
    const auto kind = rng_.below(4);
    note("bad imu ", std::to_string(kind));
    if (kind == 0) s.angular_rate_radps[1] = kNotFinite[rng_.below(3)];
    if (kind == 1) s.specific_force_mps2[2] = kNotFinite[rng_.below(3)];
    if (kind == 2) s.angular_rate_radps[0] = kHuge;
    if (kind == 3) s.specific_force_mps2[0] = -1e5;
    EXPECT_FALSE(pair_.add(s));
  }
  void bad_gnss() {
    const std::size_t i = std::min(ranges_, streams().ranges.size() - 1);
    const auto kind = rng_.below(12);
    note("bad gnss ", std::to_string(kind));
    const double bad = kNotFinite[rng_.below(3)], huge = rng_.below(2) == 0 ? kHuge : -kHuge;
    GnssFix fix = streams().fixes[i];
    RangeEpoch epoch = streams().ranges[i];
    fix.time += std::chrono::microseconds(rng_.below(400000));
    epoch.time = fix.time;
    if (kind == 0) fix.position.height_m = bad;
    if (kind == 1) (*fix.velocity_ned_mps)[1] = bad;
    if (kind == 2) fix.position_covariance_ned_m2.setZero();
    if (kind == 3) fix.position_covariance_ned_m2(0, 1) = 7.0;  // not a covariance
    if (kind == 4) fix.position.height_m = huge;
    if (kind == 5) fix.position_covariance_ned_m2 *= kHuge * kHuge;
    if (kind == 6) fix.time = LogTime::from_nanoseconds(rng_.below(2) == 0 ? INT64_MAX : INT64_MIN);
    if (kind == 7) epoch.satellites.clear();
    for (CorrectedRange& s : epoch.satellites) {
      if (kind == 8) s.range_m = s.range_rate_mps = bad;
      if (kind == 9) s.position_ecef_m[0] = bad;
      if (kind == 10) s.range_m = s.range_rate_mps = huge;
      if (kind == 11) s.range_sigma_m = s.range_rate_sigma_mps = rng_.below(2) == 0 ? 0.0 : bad;
    }
    if (kind == 6 && !pair_.filter().started()) {
      static_cast<void>(pair_.add(fix));  // not seen to be far off without a solution
    } else if (kind < 7) {
      EXPECT_FALSE(pair_.add(fix)) << "a bad fix";
    } else {
      EXPECT_FALSE(pair_.add(epoch)) << "bad ranges";
    }
  }

  Rng rng_;
  Pair pair_;
  std::string calls_;
  std::size_t next_ = 0, fed_ = 0, ranges_ = 0;
  bool outage_ = false;
};

class GnssInsSequences : public ::testing::TestWithParam<std::uint64_t> {};

TEST_P(GnssInsSequences, WhatIsRefusedLeavesNoTrace) {
  int started = 0, restarted = 0;
  for (std::uint64_t i = 1; i <= 60; ++i) {
    const std::uint64_t seed = 1000 * GetParam() + i;
    Schedule schedule(seed);
    schedule.run(260);
    SCOPED_TRACE("seed " + std::to_string(seed) + "\n" + schedule.calls());
    if (HasFailure()) FAIL() << "see the calls above";
    started += schedule.pair().filter().started() ? 1 : 0;
    restarted += schedule.pair().restarted() ? 1 : 0;
  }
  EXPECT_GT(started, 20);
  EXPECT_GT(restarted, 3);
}
INSTANTIATE_TEST_SUITE_P(Seeds, GnssInsSequences, ::testing::Values(0, 1, 2, 3));

}  // namespace
}  // namespace wayfare
