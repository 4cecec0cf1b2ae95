#pragma once

// A drive through a grid of streets with trees, as a landmark log.

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <unordered_set>
#include <vector>

#include <wayfare/core/angle.hpp>
#include <wayfare/core/random.hpp>
#include <wayfare/core/se2.hpp>
#include <wayfare/graph/edges.hpp>
#include <wayfare/io/g2o.hpp>

namespace wayfare::bench {

class SimulatedStreets {
 public:
  explicit SimulatedStreets(std::uint64_t seed) : rng_(seed) {
    for (int i = 0; i < kTrees; ++i) {
      const double x = rng_.uniform(0.0, kExtent_m);
      const double y = rng_.uniform(0.0, kExtent_m);
      trees_.emplace_back(x, y);
    }
    // Noise of one drive: from better than the park's to worse.
    sigma_m_ = rng_.uniform(0.1, 0.7);
    sigma_step_ = Eigen::Vector3d(0.01, 0.01, rng_.uniform(0.001, 0.004));
    drive();
  }

  [[nodiscard]] const io::GraphFile<SE2d>& log() const { return log_; }

 private:
  static constexpr int kTrees = 400, kPoses = 5000;
  static constexpr double kBlock_m = 50.0, kExtent_m = 6 * kBlock_m, kStep_m = 0.6;
  static constexpr double kSeen_m = 12.0, kSighted = 0.15;

  void drive() {
    SE2d truth(0.0, 0.0, Angle::radians(0.0));
    for (int id = 0; id < kPoses; ++id) {
      log_.vertices.push_back({id, truth});
      sight(id, truth);
      const SE2d step(kStep_m, 0.0, turn_at(truth));
      if (id + 1 < kPoses)
        log_.edges.push_back({id, id + 1, step.plus(noise(sigma_step_)), information(sigma_step_)});
      truth = truth * step;
    }
  }

  /// Straight to the next crossing, there left, right or straight on, within the grid.
  Angle turn_at(const SE2d& at) {
    if (++steps_ < static_cast<int>(kBlock_m / kStep_m)) return Angle::radians(0.0);
    steps_ = 0;
    for (;;) {
      const Angle turn = Angle::degrees(90.0 * (static_cast<double>(rng_.below(3)) - 1.0));
      const Eigen::Vector2d next = at * SE2d(kStep_m, 0.0, turn) * Eigen::Vector2d(kBlock_m, 0.0);
      const Eigen::Vector2d slack(5.0, 5.0);
      if ((next + slack).minCoeff() > 0.0 && (next - slack).maxCoeff() < kExtent_m) return turn;
      if (++refused_ % 20 == 0) return Angle::degrees(180.0);
    }
  }

  void sight(std::int64_t pose_id, const SE2d& pose) {
    for (std::size_t t = 0; t < trees_.size(); ++t) {
      const Eigen::Vector2d seen = pose.inverse() * trees_[t];
      if (seen.x() < 0.0 || seen.norm() > kSeen_m || rng_.uniform(0.0, 1.0) > kSighted) continue;
      const std::int64_t id = kPoses + static_cast<std::int64_t>(t);
      const Eigen::Vector2d sigma = Eigen::Vector2d::Constant(sigma_m_);
      const Eigen::Vector2d measured = seen + noise(sigma);
      if (known_.insert(id).second) log_.landmarks.push_back({id, pose * measured});
      log_.all<LandmarkPosition<SE2d>>().push_back({{pose_id, id}, {measured, information(sigma)}});
    }
  }

  template <int N>
  Eigen::Matrix<double, N, 1> noise(const Eigen::Matrix<double, N, 1>& sigma) {
    Eigen::Matrix<double, N, 1> drawn;
    for (int i = 0; i < N; ++i) drawn[i] = rng_.normal(0.0, sigma[i]);
    return drawn;
  }
  template <int N>
  static Eigen::Matrix<double, N, N> information(const Eigen::Matrix<double, N, 1>& sigma) {
    return sigma.cwiseAbs2().cwiseInverse().asDiagonal();
  }

  Rng rng_;
  double sigma_m_ = 0.0;
  Eigen::Vector3d sigma_step_ = Eigen::Vector3d::Zero();
  int steps_ = 0, refused_ = 0;
  std::vector<Eigen::Vector2d> trees_;
  std::unordered_set<std::int64_t> known_;
  io::GraphFile<SE2d> log_;
};

}  // namespace wayfare::bench
