#pragma once

// Pose graphs of simulated drives through a grid of streets, of any size.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <unordered_map>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/random.hpp>
#include <wayfare/core/se2.hpp>
#include <wayfare/graph/pose_graph.hpp>

namespace wayfare::examples {

/// Size and noise of a drive.
struct StreetOptions {
  int poses = 10'000;
  double block_m = 20.0;     ///< between crossings
  double step_m = 1.0;       ///< between poses
  double sigma_m = 0.02;     ///< of an edge, each axis
  double sigma_rad = 0.002;  ///< of an edge
  double drift_rad_m = 0.0;  ///< systematic turn of the starting poses per metre
  std::uint64_t seed = 1;
};

/// A vehicle on a square grid of streets as wide as √poses / 8 blocks, that goes straight on or
/// turns at each crossing. A pose within half a step of an earlier one has an edge to it
/// (`robust`). The starting poses are the odometry's, with a drift that its information does not
/// know of.
class Streets {
 public:
  explicit Streets(const StreetOptions& options)
      : o_(options),
        rng_(options.seed),
        blocks_(std::max(4, static_cast<int>(std::sqrt(options.poses) / 8.0))) {
    const Eigen::Vector3d deviation(o_.sigma_m, o_.sigma_m, o_.sigma_rad);
    information_ = deviation.cwiseAbs2().cwiseInverse().asDiagonal();
    deviation_ = deviation;
  }

  [[nodiscard]] PoseGraph2 drive() {
    follow_streets();
    PoseGraph2 graph;
    const SE2d drift(0.0, 0.0, Angle::radians(o_.drift_rad_m * o_.step_m));
    graph.poses.push_back(truth_.front());
    for (int id = 1; id < o_.poses; ++id) {
      graph.edges.push_back(edge(id - 1, id, false));
      graph.poses.push_back(graph.poses.back() * graph.edges.back().measurement * drift);
      if (const int earlier = visited_before(id); earlier >= 0)
        graph.edges.push_back(edge(earlier, id, true));
    }
    return graph;
  }

 private:
  static std::int64_t cell(const SE2d& x, double size) {
    const auto at = [&](double v) { return static_cast<std::int64_t>(std::floor(v / size + 0.5)); };
    return at(x.x()) * (std::int64_t{1} << 32) + at(x.y());
  }

  /// An earlier pose at the same place, not one of the latest block; −1 without.
  int visited_before(int id) {
    const auto [found, is_new] =
        visited_.try_emplace(cell(truth_[static_cast<std::size_t>(id)], o_.step_m), id);
    const int earlier = found->second;
    return !is_new && id - earlier > o_.block_m / o_.step_m ? earlier : -1;
  }

  PoseEdge<SE2d> edge(int from, int to, bool robust) {
    const SE2d between =
        truth_[static_cast<std::size_t>(from)].inverse() * truth_[static_cast<std::size_t>(to)];
    const Eigen::Vector3d noise(rng_.normal(), rng_.normal(), rng_.normal());
    return {from, to, between.plus(noise.cwiseProduct(deviation_)), information_, robust};
  }

  void follow_streets() {
    const int half = blocks_ / 2;
    const double middle = half * o_.block_m;
    truth_.assign(1, SE2d(middle, middle, Angle::radians(0.0)));
    while (static_cast<int>(truth_.size()) < o_.poses)
      truth_.push_back(truth_.back() * next_step(truth_.back()));
  }

  /// A step ahead; at crossings after a turn of −90°, 0° or 90° that stays on the grid.
  SE2d next_step(const SE2d& truth) {
    const SE2d ahead(o_.step_m, 0.0, Angle::radians(0.0));
    if (++steps_ * o_.step_m < o_.block_m) return ahead;
    steps_ = 0;
    for (;;) {
      const Angle turn =
          Angle::radians(0.5 * std::numbers::pi * (static_cast<double>(rng_.below(3)) - 1.0));
      const SE2d step = ahead * SE2d(0.0, 0.0, turn);
      const Eigen::Vector2d crossing = (truth * step) * Eigen::Vector2d(o_.block_m, 0.0);
      const double edge = blocks_ * o_.block_m + 0.5 * o_.block_m;
      if (crossing.minCoeff() > -0.5 * o_.block_m && crossing.maxCoeff() < edge) return step;
    }
  }

  StreetOptions o_;
  Rng rng_;
  int blocks_, steps_ = 0;
  Eigen::Vector3d deviation_;
  Eigen::Matrix3d information_;
  std::vector<SE2d> truth_;
  std::unordered_map<std::int64_t, int> visited_;
};

}  // namespace wayfare::examples
