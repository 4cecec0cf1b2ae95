// Random streams of motion and scans: what is refused leaves no trace but its count.

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>
#include <wayfare/nav/corridor_ins.hpp>

#include "abuse/abuse.hpp"

namespace wayfare {
namespace {

using namespace tests;

class CorridorSchedule {
 public:
  explicit CorridorSchedule(std::uint64_t seed)
      : rng_(seed), abused_(options()), model_(options_) {}

  void run(int calls) {
    for (int i = 0; i < calls && !::testing::Test::HasFailure(); ++i) {
      step();
      EXPECT_EQ(abused_.state().minus(model_.state()), CorridorState::Tangent::Zero());
      EXPECT_EQ(abused_.covariance(), model_.covariance());
      EXPECT_EQ(abused_.report().scans_used, model_.report().scans_used);
      EXPECT_EQ(abused_.report().refused_samples, refused_);
      EXPECT_TRUE(abused_.state().minus({}).allFinite() && abused_.covariance().allFinite());
      const auto variances = abused_.covariance().diagonal();
      EXPECT_GE(variances.minCoeff(), -1e-12 * variances.maxCoeff());  // but for rounding
    }
  }
  [[nodiscard]] const std::string& calls() const { return calls_; }
  [[nodiscard]] std::size_t scans_used() const { return abused_.report().scans_used; }

 private:
  CorridorInsOptions options() {
    options_.memory = rng_.below(2) == 0 ? WallMemory::corridor : WallMemory::one_scan;
    options_.square_sigma_rad = rng_.below(2) == 0 ? 0.0 : 0.02;
    options_.start_scale = rng_.below(4) == 0 ? 0.0 : 0.005;
    return options_;
  }

  void step() {
    const auto what = rng_.below(20);
    if (what < 9) return motion();
    if (what < 13) return scan();
    if (what == 13)
      time_ += from_seconds(rng_.below(8) == 0 ? rng_.uniform(0.0, 1e6) : rng_.uniform(0.0, 3.0));
    if (what == 14) {
      CorridorIns elsewhere(std::move(abused_));
      abused_ = std::move(elsewhere);
      calls_ += "move\n";
    }
    if (what > 14) bad();
  }

  void motion() {
    time_ += std::chrono::milliseconds(100);
    if (rng_.below(30) == 0) speed_ = rng_.below(2) == 0 ? 0.0 : rng_.uniform(-3.0, 3.0);
    const double rate = rng_.below(20) == 0 ? rng_.normal() * 5.0 : rng_.normal() * 0.01;
    const double speed = rng_.below(20) == 0 ? rng_.normal() * 300.0 : speed_;
    calls_ += "motion " + std::to_string(rate) + ' ' + std::to_string(speed) + '\n';
    moved_ = true;
    EXPECT_TRUE(abused_.add_motion({time_, rate, std::clamp(speed, -999.0, 999.0)}));
    EXPECT_TRUE(model_.add_motion({time_, rate, std::clamp(speed, -999.0, 999.0)}));
  }

  LaserScan a_scan() {
    LaserScan scan{time_, Angle::degrees(-180), Angle::degrees(1), 0.05F, 12.0F, {}};
    const double heading = rng_.normal() * 0.02, left = 1.0 + 0.02 * rng_.normal();
    const auto fault = rng_.below(4);
    for (std::size_t i = 0; i < 360; ++i) {
      const double s = std::sin(scan.bearing(i).radians() + heading);
      float r = static_cast<float>(std::abs((s > 0 ? left : 1.2) / s));
      if (fault == 0 && rng_.below(3) == 0) r = std::numeric_limits<float>::quiet_NaN();
      if (fault == 1 && rng_.below(3) == 0) r = static_cast<float>(rng_.uniform(0.0, 12.0));
      if (fault == 2 && rng_.below(5) == 0) r = std::numeric_limits<float>::infinity();
      scan.ranges_m.push_back(r);
    }
    if (rng_.below(20) == 0) scan.ranges_m.clear();
    return scan;
  }

  void scan() {
    if (time_ == scan_time_) return;
    scan_time_ = time_;
    const LaserScan s = a_scan();
    const auto a = abused_.add_scan(s), b = model_.add_scan(s);
    calls_ += "scan at " + std::to_string(time_.seconds()) + '\n';
    ASSERT_TRUE(a && b);
    EXPECT_TRUE(a->outcome == b->outcome && a->tracked == b->tracked);
  }

  void bad() {
    MotionSample m{time_ + std::chrono::milliseconds(10), 0.0, 0.5};
    const auto kind = rng_.below(5);
    calls_ += "bad " + std::to_string(kind) + '\n';
    if (kind == 0) m.turn_rate_rad_s = kNotFinite[rng_.below(3)];
    if (kind == 1) m.speed_m_s = kNotFinite[rng_.below(3)];
    if (kind == 2) m.speed_m_s = rng_.below(2) == 0 ? kHuge : -1e9;
    if (kind == 3) m.turn_rate_rad_s = kHuge;
    if (kind == 4) m.time = LogTime() + Duration::min();
    if (kind < 4 || moved_) {
      EXPECT_FALSE(abused_.add_motion(m));
      ++refused_;
    }
    if (scan_time_ == LogTime()) return;
    LaserScan old = a_scan();
    old.time = scan_time_ - std::chrono::milliseconds(rng_.below(300));
    EXPECT_FALSE(abused_.add_scan(old));
  }

  Rng rng_;
  CorridorInsOptions options_;
  CorridorIns abused_, model_;
  LogTime time_, scan_time_;
  double speed_ = 0.5;
  bool moved_ = false;
  std::size_t refused_ = 0;
  std::string calls_;
};

TEST(CorridorSequences, WhatIsRefusedLeavesNoTrace) {
  std::size_t used = 0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    CorridorSchedule schedule(seed);
    schedule.run(250);
    SCOPED_TRACE("seed " + std::to_string(seed) + "\n" + schedule.calls());
    if (HasFailure()) FAIL() << "see the calls above";
    used += schedule.scans_used();
  }
  EXPECT_GT(used, 500U);
}

}  // namespace
}  // namespace wayfare
