// Random streams of gyro, accelerometer, magnetometer and headings with gaps, repetitions and
// nonsense: what is not used leaves no trace.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include <wayfare/core/random.hpp>
#include <wayfare/inertial/ahrs.hpp>

#include "abuse/abuse.hpp"

namespace wayfare {
namespace {

using namespace tests;
using Estimator = Ahrs<frame::Enu>;

bool same(const Estimator& a, const Estimator& b) {
  return a.ready() == b.ready() && a.heading_known() == b.heading_known() &&
         a.q_world_body().quaternion().coeffs() == b.q_world_body().quaternion().coeffs() &&
         a.world_covariance() == b.world_covariance() &&
         a.gyro_bias_radps() == b.gyro_bias_radps() &&
         a.magnetometer_delay_s() == b.magnetometer_delay_s();
}

class Schedule {
 public:
  explicit Schedule(std::uint64_t seed) : rng_(seed), abused_(parameters()), model_(parameters_) {}

  void run(int calls) {
    for (int i = 0; i < calls; ++i) {
      step();
      if (!is_sound() || !same(abused_, model_)) {
        ADD_FAILURE() << "after call " << i
                      << (is_sound() ? ": differs from its model" : ": not sound");
        return;
      }
    }
  }
  [[nodiscard]] const std::string& calls() const { return calls_; }
  [[nodiscard]] const Estimator& filter() const { return abused_; }

 private:
  AhrsParameters parameters() {
    parameters_.use_magnetometer = rng_.below(3) != 0;
    parameters_.heading_history_s = rng_.below(2) == 0 ? 0.0 : 5.0;
    return parameters_;
  }

  void step() {
    switch (const auto what = rng_.below(20)) {
      case 0:
        note("copy");
        abused_ = Estimator(abused_);
        return;
      case 1: {
        note("move");
        Estimator elsewhere(std::move(abused_));
        abused_ = std::move(elsewhere);
        return;
      }
      case 2:
        time_ += from_seconds(rng_.below(4) == 0 ? rng_.uniform(0.0, 5.0) : rng_.uniform(0.0, 0.3));
        return note("gap");
      case 3:
        time_ = time_ - from_seconds(rng_.below(20) == 0 ? rng_.uniform(0.0, 60.0) : 0.02);
        return note("back");
      case 4: {
        const HeadingFix fix{time_ - from_seconds(rng_.uniform(-0.1, 7.0)),
                             Angle::radians(number()), rng_.below(4) == 0 ? number() : 0.01};
        note("heading");
        return count([&](Estimator& e) { return e.add_heading(fix); });
      }
      case 5: {
        if (rng_.below(10) != 0) return;
        const Angle compass = Angle::radians(number());
        note("compass");
        return count([&](Estimator& e) { return e.set_compass(compass, Angle::degrees(5)); });
      }
      default:
        return reading(what);
    }
  }

  void reading(std::uint64_t what) {
    time_ += std::chrono::milliseconds(rng_.below(12));
    const Eigen::Vector3d scale = Eigen::Vector3d::Constant(1.0);
    const Eigen::Vector3d noise(rng_.normal(), rng_.normal(), rng_.normal());
    Eigen::Vector3d rate = 0.5 * noise, force = Eigen::Vector3d(0, 0, 9.81) + noise,
                    field = Eigen::Vector3d(0, 20, -43) + noise;
    if (rng_.below(6) == 0)
      (what % 3 == 0 ? rate : what % 3 == 1 ? force : field) = number() * scale;
    if (rng_.below(20) == 0) rate[1] = force[2] = field[0] = number();
    note("reading " + std::to_string(what % 3) + " at " + std::to_string(time_.seconds()));
    const LogTime time = time_;
    if (what % 3 == 0 || what > 14) count([&](Estimator& e) { return e.add_rate(time, rate); });
    if (what % 3 == 1 || what > 14) count([&](Estimator& e) { return e.add_force(time, force); });
    if (what % 3 == 2 || what > 14) count([&](Estimator& e) { return e.add_field(time, field); });
  }

  /// To the filter, and to the model unless the filter says that it is no measurement at all.
  template <class Call>
  void count(const Call& call) {
    const UpdateStatus status = call(abused_);
    // Late readings count: enough of them restart the filter. The others may wait for something.
    if (status != UpdateStatus::missing) {
      EXPECT_EQ(call(model_), status);
    }
  }

  double number() {
    switch (rng_.below(6)) {
      case 0:
        return kNotFinite[rng_.below(3)];
      case 1:
        return kExtreme[rng_.below(4)];
      case 2:
        return 0.0;
      case 3:
        return rng_.normal() * 1e9;
      default:
        return rng_.normal() * 30.0;
    }
  }

  [[nodiscard]] bool is_sound() const {
    const Eigen::Matrix3d p = abused_.world_covariance();
    if (!abused_.q_world_body().quaternion().coeffs().allFinite() || !p.allFinite()) return false;
    if (!abused_.gyro_bias_radps().allFinite() || !abused_.gyro_bias_sigma_radps().allFinite())
      return false;
    if (std::abs(abused_.q_world_body().quaternion().norm() - 1.0) > 1e-9) return false;
    const double least = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(p).eigenvalues()[0];
    return least > -1e-9 * std::max(p.trace(), 1e-9);
  }

  void note(const std::string& call) { calls_ += call + '\n'; }

  Rng rng_;
  AhrsParameters parameters_;
  Estimator abused_, model_;
  LogTime time_;
  std::string calls_;
};

TEST(AhrsSequences, WhatIsNotUsedLeavesNoTrace) {
  int ready = 0, restarted = 0;
  for (std::uint64_t seed = 1; seed <= 400; ++seed) {
    Schedule schedule(seed);
    schedule.run(600);
    SCOPED_TRACE("seed " + std::to_string(seed) + "\n" + schedule.calls());
    if (HasFailure()) FAIL() << "see the calls above";
    ready += schedule.filter().ready() ? 1 : 0;
    restarted += schedule.filter().report().restarts > 0 ? 1 : 0;
  }
  EXPECT_GT(ready, 200);
  EXPECT_GT(restarted, 100);
}

}  // namespace
}  // namespace wayfare
