// Until when the steps are known.

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>
#include <wayfare/pedestrian/parameters.hpp>
#include <wayfare/pedestrian/step_detector.hpp>

namespace wayfare {
namespace {

// Amplitudes that come and go, so that walks begin, pause, resume and hide steps: no step is
// earlier than the time until which the reports were said to be complete but one whose crest took
// half a second, and at rest that time is half a second ago.
TEST(StepDetector, NoStepIsEarlierThanSettled) {
  Rng rng(11);
  StepDetector detector(walking_step_parameters());
  EXPECT_FALSE(detector.settled());
  double amplitude = 3.0, hz = 1.8, phase = 0.0, rest_s = 0.0;
  LogTime settled;
  for (int i = 0; i < 60'000; ++i) {
    if (i % 300 == 0) amplitude = rng.below(3) == 0 ? 0.0 : rng.uniform(0.5, 5.0);
    if (i % 500 == 0) hz = rng.uniform(1.2, 2.6);
    phase += 0.01 * 2.0 * std::numbers::pi * hz;
    const bool hidden = rng.below(200) == 0;
    const double force = 9.81 + (hidden ? 0.0 : amplitude) * std::sin(phase);
    const LogTime now = LogTime::from_seconds(0.01 * i);
    detector.add(now, {0.0, 0.0, force + 0.05 * rng.normal()}, [&](const Step& step) {
      EXPECT_TRUE(step.time >= settled || to_seconds(now - step.time) > 0.5) << i;
    });
    ASSERT_TRUE(detector.settled());
    EXPECT_LE(*detector.settled(), now);
    EXPECT_GE(*detector.settled(), settled) << i;
    settled = *detector.settled();
    rest_s = amplitude == 0.0 ? rest_s + 0.01 : 0.0;
    if (rest_s > 2.0) {
      EXPECT_LT(to_seconds(now - settled), 0.51) << i;
    }
  }
  EXPECT_GT(detector.steps(), 300U);
}

}  // namespace
}  // namespace wayfare
