#pragma once

// τ by its definition: independent samples, double precision, one look-up per point.

#include <algorithm>
#include <cmath>
#include <vector>

#include <wayfare/core/gaussian.hpp>
#include <wayfare/map/likelihood_field.hpp>
#include <wayfare/sensors/point_set.hpp>

namespace wayfare {

struct NaiveDraw {
  SE2d pose;
  double log_evidence;  ///< ln of the mean of τ
};

inline NaiveDraw naive_draw(const LikelihoodField& grid, const PointSet& points,
                            const Gaussian<SE2d>& proposal, const Gaussian<SE2d>& motion, Rng& rng,
                            int samples, double independent_points) {
  std::vector<SE2d> poses;
  std::vector<double> log_tau;
  const double scale = independent_points / static_cast<double>(points.size());
  for (int i = 0; i < samples; ++i) {
    const SE2d x = sample(proposal, rng);
    double sum = 0;
    for (std::size_t k = 0; k < points.size(); ++k) {
      const Eigen::Vector2d p = x * Eigen::Vector2d(points[k].cast<double>());
      sum += grid.log_likelihood(cell_of(p, grid.resolution_m()));
    }
    poses.push_back(x);
    log_tau.push_back(scale * sum + log_density(motion, x));
  }
  const double top = *std::max_element(log_tau.begin(), log_tau.end());
  double total = 0;
  for (const double t : log_tau) total += std::exp(t - top);
  double left = rng.uniform() * total;
  std::size_t chosen = 0;
  while (chosen + 1 < log_tau.size() && (left -= std::exp(log_tau[chosen] - top)) >= 0) ++chosen;
  return {poses[chosen], top + std::log(total / samples)};
}

}  // namespace wayfare
