// The error of an estimated trajectory. A vehicle drives 100 m straight ahead; the estimate is 1 %
// too long, and in a frame of its own.
#include <cstdio>

#include <wayfare/eval/trajectory_error.hpp>

using namespace wayfare;

int main() {
  const SE2d frame_of_estimate(5.0, -2.0, 30_deg);
  Trajectory truth, estimate;
  for (int k = 0; k <= 100; ++k) {
    const auto stamped = [k](const SE2d& pose) {
      return StampedPose{LogTime::from_seconds(k), Transform2<frame::Map, frame::Base>(pose)};
    };
    truth.push_back(stamped(SE2d(k, 0.0, 0_deg)));
    estimate.push_back(stamped(frame_of_estimate * SE2d(1.01 * k, 0.0, 0_deg)));
  }

  // After the rigid motion that fits best.
  const eval::AbsoluteError fitted = eval::absolute_error(estimate, truth);
  std::printf("rigid: %.3f m rms\n", fitted.translation_m.rmse);

  // With the first poses made equal.
  const eval::AbsoluteError started =
      eval::absolute_error(estimate, truth, {.alignment = eval::Alignment::start});
  std::printf("start: %.3f m rms, %.2f m at the end of %.0f m\n", started.translation_m.rmse,
              started.end_m, started.path_length_m);

  // Of every piece of 10 m: the drift, whatever the frame.
  const auto pairs = eval::associate(estimate, truth);
  const eval::RelativeError drift = eval::relative_error(pairs, eval::Span::metres(10.0));
  std::printf("in 10 m: %.3f m rms, %.1f degrees\n", drift.translation_m.rmse,
              drift.heading_deg.rmse);
}
