#pragma once

// A robot that measures distances to radio beacons at unknown places: recordings, and their graph.

#include <string>
#include <tuple>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/graph/edges.hpp>
#include <wayfare/graph/factor_graph.hpp>

namespace wayfare::examples {

struct RangeRun {
  struct Range {
    int pose;
    int beacon;  ///< index in `beacons`
    double range_m;
  };

  std::vector<SE2d> steps;    ///< pose k + 1 in the frame of pose k, by odometry
  std::vector<Range> ranges;  ///< in order of time
  std::vector<int> beacons;   ///< their numbers in the recording, in the order they are heard
};

/// Files of Djugash, Hamner and Roth, "Navigating with ranging radios: five data sets with ground
/// truth": lines `time distance heading` of increments, and `time sender receiver range`. A range
/// belongs to the first pose at or after its time. Errors: a line that is not such numbers, times
/// that go back, a range that is not positive, no line.
[[nodiscard]] Result<RangeRun> read_range_run(const std::string& odometry,
                                              const std::string& ranges);

/// Standard deviations.
struct RangeNoise {
  double forward_m = 0.01, sideways_m = 0.003, heading_rad = 0.002;  ///< of one step
  double range_m = 0.5;
  double kernel = 2.0;  ///< scale of the Cauchy kernel of ranges
};

/// What radios report is proportional to the distance: 1 + k, with k a variable.
using RangeScale = Eigen::Matrix<double, 1, 1>;

/// A range with a scale error: e = (1 + k) ‖l − x‖ − z, metres.
struct ScaledRange {
  using Variables = EdgeVariables<SE2d, Eigen::Vector2d, RangeScale>;
  static constexpr int kDim = 1;

  double range_m = 0.0;
  Eigen::Matrix<double, 1, 1> information = Eigen::Matrix<double, 1, 1>::Identity();

  [[nodiscard]] EdgeError<RangeTo<SE2d>> error(const SE2d& pose, const Eigen::Vector2d& beacon,
                                               const RangeScale& scale) const {
    const double distance = (beacon - pose.translation()).norm();
    return EdgeError<RangeTo<SE2d>>((1.0 + scale[0]) * distance - range_m);
  }
  [[nodiscard]] EdgeError<RangeTo<SE2d>> linearise(const SE2d& pose, const Eigen::Vector2d& beacon,
                                                   const RangeScale& scale,
                                                   EdgeJacobians<1, Variables>& j) const {
    JacobiansOf<RangeTo<SE2d>> by;
    const auto distance = RangeTo<SE2d>{}.linearise(pose, beacon, by);
    std::get<0>(j.by) = (1.0 + scale[0]) * std::get<0>(by.by);
    std::get<1>(j.by) = (1.0 + scale[0]) * std::get<1>(by.by);
    std::get<2>(j.by) = distance;
    return EdgeError<RangeTo<SE2d>>((1.0 + scale[0]) * distance[0] - range_m);
  }
};

using RangeGraph = FactorGraph<Variables<SE2d, Eigen::Vector2d, RangeScale>,
                               Edges<Between<SE2d>, Robust<ScaledRange>>>;

/// Poses by odometry from the origin, which is fixed; each beacon where most of the circles of its
/// first ranges meet: of the intersections of any two, that with the least robust cost. Variables
/// are the poses, the beacons and the ranges' scale, which is fixed at 1 unless it is `free_scale`.
[[nodiscard]] RangeGraph range_graph(const RangeRun& run, bool free_scale,
                                     const RangeNoise& noise = {});

}  // namespace wayfare::examples
