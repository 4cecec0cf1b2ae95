#include <wayfare/motion/radar_velocity.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>

namespace wayfare {
namespace {

/// The direction to a point, and the speed of approach.
struct Equation {
  Eigen::Vector3d direction;
  double approach_m_s = 0.0;
  std::size_t point = 0;
};

std::vector<Equation> equations_of(const RadarScan& scan, const RadarVelocityOptions& o) {
  std::vector<Equation> equations;
  for (std::size_t i = 0; i < scan.points.size(); ++i) {
    const RadarPoint& p = scan.points[i];
    const auto z = o.plane ? 0.0 : static_cast<double>(p.z_m);
    const Eigen::Vector3d at(static_cast<double>(p.x_m), static_cast<double>(p.y_m), z);
    const double range = at.norm();
    if (!(range >= o.min_range_m) || !std::isfinite(range) || !std::isfinite(p.doppler_m_s) ||
        !(static_cast<double>(p.snr_db) >= o.min_snr_db))
      continue;
    equations.push_back({at / range, -static_cast<double>(p.doppler_m_s), i});
  }
  return equations;
}

double residual(const Equation& equation, const Eigen::Vector3d& v) {
  return equation.direction.dot(v) - equation.approach_m_s;
}

/// HᵀH and Hᵀd of some equations; in the plane the third unknown is fixed at zero.
struct NormalEquations {
  explicit NormalEquations(bool plane) { A(2, 2) = plane ? 1.0 : 0.0; }
  void add(const Equation& equation) {
    A += equation.direction * equation.direction.transpose();
    b += equation.approach_m_s * equation.direction;
  }
  /// Information in the worst direction; 0: none.
  [[nodiscard]] double smallest_eigenvalue() const {
    return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(A, Eigen::EigenvaluesOnly)
        .eigenvalues()[0];
  }
  Eigen::Matrix3d A = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
};

/// A tenth of the value for three orthogonal directions.
constexpr double kMinDrawEigenvalue = 0.1, kMinEigenvalue = 1e-3;

std::optional<Eigen::Vector3d> draw(const std::vector<Equation>& equations, Rng& rng, bool plane) {
  NormalEquations normal(plane);
  const std::size_t unknowns = plane ? 2 : 3;
  std::array<std::size_t, 3> drawn{};
  for (std::size_t k = 0; k < unknowns; ++k) {
    drawn[k] = rng.below(equations.size());
    if (std::find(drawn.begin(), drawn.begin() + static_cast<long>(k), drawn[k]) !=
        drawn.begin() + static_cast<long>(k))
      return std::nullopt;
    normal.add(equations[drawn[k]]);
  }
  const double volume = std::abs(normal.A.determinant());
  if (volume < kMinDrawEigenvalue * kMinDrawEigenvalue * kMinDrawEigenvalue) return std::nullopt;
  return Eigen::Vector3d(normal.A.ldlt().solve(normal.b));
}

/// Sum of squared residuals, truncated at `limit`.
double cost(const std::vector<Equation>& equations, const Eigen::Vector3d& v, double limit) {
  double sum = 0.0;
  for (const Equation& equation : equations) {
    const double r = residual(equation, v);
    sum += std::min(r * r, limit * limit);
  }
  return sum;
}

Eigen::Vector3d best_draw(const std::vector<Equation>& equations, Rng& rng,
                          const RadarVelocityOptions& o) {
  // Zero velocity is tested first, so that a frame without motion gives exactly that.
  Eigen::Vector3d best = Eigen::Vector3d::Zero();
  double lowest = cost(equations, best, o.inlier_m_s);
  for (std::size_t i = 0; i < o.draws; ++i) {
    const auto v = draw(equations, rng, o.plane);
    if (!v) continue;
    const double candidate = cost(equations, *v, o.inlier_m_s);
    if (candidate < lowest) lowest = candidate, best = *v;
  }
  return best;
}

NormalEquations normal_of(const std::vector<Equation>& equations, const Eigen::Vector3d& v,
                          const RadarVelocityOptions& o) {
  NormalEquations normal(o.plane);
  for (const Equation& equation : equations)
    if (std::abs(residual(equation, v)) <= o.inlier_m_s) normal.add(equation);
  return normal;
}

}  // namespace

Result<RadarVelocity> radar_velocity(const RadarScan& scan, Rng rng,
                                     const RadarVelocityOptions& o) {
  const std::vector<Equation> equations = equations_of(scan, o);
  const std::size_t unknowns = o.plane ? 2 : 3;
  const auto degenerate = [&](std::string what) {
    return Error{ErrorCode::degenerate, std::move(what), "radar frame"};
  };
  if (equations.size() <= unknowns)
    return degenerate("has " + std::to_string(equations.size()) + " points, for " +
                      std::to_string(unknowns) + " unknowns and one to check");
  RadarVelocity out;
  out.time = scan.time;
  out.points = equations.size();
  out.velocity_m_s = best_draw(equations, rng, o);
  NormalEquations normal(o.plane);
  for (int i = 0; i < 3; ++i) {
    normal = normal_of(equations, out.velocity_m_s, o);
    if (normal.smallest_eigenvalue() < kMinEigenvalue)
      return degenerate("has points in too few directions to determine the velocity");
    out.velocity_m_s = normal.A.ldlt().solve(normal.b);
  }
  out.inlier.assign(scan.points.size(), false);
  double squares = 0.0;
  for (const Equation& equation : equations) {
    const double r = residual(equation, out.velocity_m_s);
    if (std::abs(r) > o.inlier_m_s) continue;
    out.inlier[equation.point] = true;
    ++out.inliers;
    squares += r * r;
  }
  if (out.inliers <= unknowns || 2 * out.inliers < equations.size())
    return degenerate("has " + std::to_string(equations.size()) + " points, of which only " +
                      std::to_string(out.inliers) + " agree");
  out.residual_m_s = std::sqrt(squares / static_cast<double>(out.inliers));
  const double variance = std::max(squares / static_cast<double>(out.inliers - unknowns),
                                   o.doppler_sigma_m_s * o.doppler_sigma_m_s);
  out.covariance = variance * normal.A.inverse();
  if (o.plane) out.covariance(2, 2) = 0.0;
  return out;
}

}  // namespace wayfare
