// FastSLAM (Montemerlo et al. 2002) by the Rao-Blackwellised particle filter: each particle is a
// trajectory with a map of its own, here one small Kalman filter for each post that it saw.
#include <cmath>
#include <cstdio>
#include <optional>

#include <wayfare/filter/ekf.hpp>
#include <wayfare/filter/rbpf.hpp>

using namespace wayfare;

struct Sighting {  // of a post, in the robot's frame; the error is in standard deviations of 0.1 m
  using Jacobians = AutomaticJacobians;
  static constexpr int kDim = 2;
  SE2d robot;
  Eigen::Vector2d seen_m;
  template <class T>
  Eigen::Matrix<T, 2, 1> error(const Eigen::Matrix<T, 2, 1>& post) const {
    return (robot.cast<T>().inverse() * post - seen_m.cast<T>()) / T(0.1);
  }
};
using Posts = std::vector<std::optional<Ekf<Eigen::Vector2d>>>;  // the map of a particle

int main() {
  const std::vector<Eigen::Vector2d> places{{3, 3}, {8, 9}, {-6, 11}, {-4, 2}, {1, 16}};
  const SE2d motion(1.0, 0.0, 9_deg);  // 40 steps are a circle
  Rbpf<Posts> particles(200, {}, Posts(places.size()), 1);
  SE2d truth, odometry;
  Rng rng(1);
  for (int k = 1; k <= 80; ++k) {
    truth = truth * motion;
    const SE2d measured = motion.plus({0.05 * rng.normal(), 0.0, 0.01 + 0.02 * rng.normal()});
    odometry = odometry * measured;
    std::vector<Eigen::Vector2d> seen;
    for (const Eigen::Vector2d& place : places)
      seen.push_back(truth.inverse() * place +
                     Eigen::Vector2d(0.1 * rng.normal(), 0.1 * rng.normal()));

    const auto step = [&](RbpfParticle<Posts>& particle, Rng& own, std::size_t) {
      const SE2d moved = measured.plus({0.05 * own.normal(), 0.0, 0.03 * own.normal()});
      particle.pose = particle.pose * moved;
      double log_weight = 0.0;
      for (std::size_t i = 0; i < seen.size(); ++i) {
        if (seen[i].norm() > 8.0) continue;  // out of the sensor's range
        if (auto& post = particle.map[i]; !post) {
          post.emplace(particle.pose * seen[i], 0.01 * Eigen::Matrix2d::Identity());
        } else {
          const auto update = post->update(Sighting{particle.pose, seen[i]});
          log_weight -= 0.5 * (update.nis + std::log(update.covariance.determinant()));
        }
      }
      return log_weight;
    };
    if (!particles.update(LogTime::from_seconds(k), step)) return 1;
    particles.resample_below(0.5);
  }
  const SE2d best = particles.trajectory(particles.best()).back().T_map_base.raw();
  const auto off = [&](const SE2d& pose) { return pose.minus(truth).head<2>().norm(); };
  std::printf("robot: %.2f m off, by odometry %.1f m\n", off(best), off(odometry));
}
