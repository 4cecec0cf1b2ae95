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

/// A direction towards a point, and the speed at which that comes nearer.
struct Row {
  Eigen::Vector3d towards;
  double nearing_m_s = 0.0;
  std::size_t point = 0;
};

std::vector<Row> rows_of(const RadarScan& scan, const RadarVelocityOptions& o) {
  std::vector<Row> rows;
  for (std::size_t i = 0; i < scan.points.size(); ++i) {
    const RadarPoint& p = scan.points[i];
    const auto z = o.plane ? 0.0 : static_cast<double>(p.z_m);
    const Eigen::Vector3d at(static_cast<double>(p.x_m), static_cast<double>(p.y_m), z);
    const double range = at.norm();
    if (!(range >= o.min_range_m) || !std::isfinite(range) || !std::isfinite(p.doppler_m_s) ||
        !(static_cast<double>(p.snr_db) >= o.min_snr_db))
      continue;
    rows.push_back({at / range, -static_cast<double>(p.doppler_m_s), i});
  }
  return rows;
}

double residual(const Row& row, const Eigen::Vector3d& v) {
  return row.towards.dot(v) - row.nearing_m_s;
}

/// HᵀH and Hᵀd of some rows; in the plane the third unknown is held at zero.
struct Normal {
  explicit Normal(bool plane) { A(2, 2) = plane ? 1.0 : 0.0; }
  void add(const Row& row) {
    A += row.towards * row.towards.transpose();
    b += row.nearing_m_s * row.towards;
  }
  /// How well the worst direction is seen; 0: not at all.
  [[nodiscard]] double weakest() const {
    return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(A, Eigen::EigenvaluesOnly)
        .eigenvalues()[0];
  }
  Eigen::Matrix3d A = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
};

/// A tenth of what three directions at right angles give.
constexpr double kWeakestDraw = 0.1, kWeakest = 1e-3;

std::optional<Eigen::Vector3d> draw(const std::vector<Row>& rows, Rng& rng, bool plane) {
  Normal normal(plane);
  const std::size_t unknowns = plane ? 2 : 3;
  std::array<std::size_t, 3> drawn{};
  for (std::size_t k = 0; k < unknowns; ++k) {
    drawn[k] = rng.below(rows.size());
    if (std::find(drawn.begin(), drawn.begin() + static_cast<long>(k), drawn[k]) !=
        drawn.begin() + static_cast<long>(k))
      return std::nullopt;
    normal.add(rows[drawn[k]]);
  }
  const double volume = std::abs(normal.A.determinant());
  if (volume < kWeakestDraw * kWeakestDraw * kWeakestDraw) return std::nullopt;
  return Eigen::Vector3d(normal.A.ldlt().solve(normal.b));
}

/// Squares of the residuals, those of outliers all the same.
double cost(const std::vector<Row>& rows, const Eigen::Vector3d& v, double limit) {
  double sum = 0.0;
  for (const Row& row : rows) {
    const double r = residual(row, v);
    sum += std::min(r * r, limit * limit);
  }
  return sum;
}

Eigen::Vector3d agreed(const std::vector<Row>& rows, Rng& rng, const RadarVelocityOptions& o) {
  // Standing still is looked at first: then nothing else can be said of a frame without motion.
  Eigen::Vector3d best = Eigen::Vector3d::Zero();
  double least = cost(rows, best, o.inlier_m_s);
  for (std::size_t i = 0; i < o.draws; ++i) {
    const auto v = draw(rows, rng, o.plane);
    if (!v) continue;
    const double here = cost(rows, *v, o.inlier_m_s);
    if (here < least) least = here, best = *v;
  }
  return best;
}

Normal normal_of(const std::vector<Row>& rows, const Eigen::Vector3d& v,
                 const RadarVelocityOptions& o) {
  Normal normal(o.plane);
  for (const Row& row : rows)
    if (std::abs(residual(row, v)) <= o.inlier_m_s) normal.add(row);
  return normal;
}

}  // namespace

Result<RadarVelocity> radar_velocity(const RadarScan& scan, Rng rng,
                                     const RadarVelocityOptions& o) {
  const std::vector<Row> rows = rows_of(scan, o);
  const std::size_t unknowns = o.plane ? 2 : 3;
  const auto degenerate = [&](std::string what) {
    return Error{ErrorCode::degenerate, std::move(what), "radar frame"};
  };
  if (rows.size() <= unknowns)
    return degenerate("holds " + std::to_string(rows.size()) + " points, for " +
                      std::to_string(unknowns) + " unknowns and one to tell");
  RadarVelocity out;
  out.time = scan.time;
  out.points = rows.size();
  out.velocity_m_s = agreed(rows, rng, o);
  Normal normal(o.plane);
  for (int i = 0; i < 3; ++i) {
    normal = normal_of(rows, out.velocity_m_s, o);
    if (normal.weakest() < kWeakest)
      return degenerate("sees points in too few directions to tell how it moves");
    out.velocity_m_s = normal.A.ldlt().solve(normal.b);
  }
  out.inlier.assign(scan.points.size(), false);
  double squares = 0.0;
  for (const Row& row : rows) {
    const double r = residual(row, out.velocity_m_s);
    if (std::abs(r) > o.inlier_m_s) continue;
    out.inlier[row.point] = true;
    ++out.inliers;
    squares += r * r;
  }
  if (out.inliers <= unknowns || 2 * out.inliers < rows.size())
    return degenerate("holds " + std::to_string(rows.size()) + " points, of which only " +
                      std::to_string(out.inliers) + " agree");
  out.residual_m_s = std::sqrt(squares / static_cast<double>(out.inliers));
  const double variance = std::max(squares / static_cast<double>(out.inliers - unknowns),
                                   o.doppler_sigma_m_s * o.doppler_sigma_m_s);
  out.covariance = variance * normal.A.inverse();
  if (o.plane) out.covariance(2, 2) = 0.0;
  return out;
}

}  // namespace wayfare
