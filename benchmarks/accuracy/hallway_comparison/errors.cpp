#include "errors.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include <wayfare/eval/trajectory_error.hpp>

namespace wayfare::examples {
namespace {

// Of the motion over every straight segment of `length_m`.
void add_segments(const std::vector<eval::PosePair>& pairs, double length_m, Errors& errors) {
  Eigen::Vector3d squares = Eigen::Vector3d::Zero();
  double count = 0.0;
  for (std::size_t i = 0, k = 0; i < pairs.size(); i += 10) {
    const auto& from = pairs[i].reference;
    const auto far = [&](std::size_t j) {
      return (pairs[j].reference.translation() - from.translation()).norm() >= length_m;
    };
    while (k < pairs.size() && !far(k)) ++k;
    if (k == pairs.size()) break;
    const SE2d expected = from.inverse() * pairs[k].reference;
    // Without corners, where along and across would be exchanged.
    if (std::abs(expected.y()) > 0.1 || std::abs(expected.heading().radians()) > 0.1) continue;
    const SE2d estimated = pairs[i].estimate.inverse() * pairs[k].estimate;
    const SE2d error = expected.inverse() * estimated;
    squares += Eigen::Vector3d(error.x(), error.y(), error.heading().degrees()).cwiseAbs2();
    count += 1.0;
  }
  const Eigen::Vector3d rms = (squares / std::max(count, 1.0)).cwiseSqrt();
  errors.along_m = rms.x();
  errors.across_m = rms.y();
  errors.rotation_deg = rms.z();
}

}  // namespace

Errors errors_of(const Trajectory& estimate, const Trajectory& truth) {
  constexpr double kSegment_m = 5.0;
  const auto pairs = eval::associate(estimate, truth);
  Errors errors;
  for (const eval::PosePair& pair : pairs) {
    const Eigen::Vector2d d = pair.estimate.translation() - pair.reference.translation();
    const double heading_deg =
        (pair.reference.heading() - pair.estimate.heading()).wrapped().degrees();
    errors.x_m += d.x() * d.x();
    errors.y_m += d.y() * d.y();
    errors.heading_deg += heading_deg * heading_deg;
  }
  const auto n = static_cast<double>(pairs.size());
  for (double* e : {&errors.x_m, &errors.y_m, &errors.heading_deg}) *e = std::sqrt(*e / n);
  add_segments(pairs, kSegment_m, errors);
  return errors;
}

}  // namespace wayfare::examples
