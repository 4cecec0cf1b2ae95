#include <wayfare/sim/detail/smooth_curve.hpp>

#include <algorithm>
#include <array>
#include <cmath>

namespace wayfare::sim {
namespace {

// The four basis functions that are nonzero on a segment, at u in [0, 1] of it.
std::array<double, 4> basis(double u) {
  const double v = 1.0 - u;
  return {v * v * v / 6.0, (3.0 * u * u * u - 6.0 * u * u + 4.0) / 6.0,
          (-3.0 * u * u * u + 3.0 * u * u + 3.0 * u + 1.0) / 6.0, u * u * u / 6.0};
}
std::array<double, 4> basis_first(double u) {
  const double v = 1.0 - u;
  return {-0.5 * v * v, 1.5 * u * u - 2.0 * u, -1.5 * u * u + u + 0.5, 0.5 * u * u};
}
std::array<double, 4> basis_second(double u) { return {1.0 - u, 3.0 * u - 2.0, 1.0 - 3.0 * u, u}; }

// Normal equations with half bandwidth three.
class BandedNormal {
 public:
  explicit BandedNormal(std::size_t unknowns)
      : band_(unknowns, {0, 0, 0, 0}), right_(unknowns, Eigen::Vector3d::Zero()) {}

  void add(std::size_t first, const std::array<double, 4>& row, const Eigen::Vector3d& value,
           double weight) {
    for (std::size_t i = 0; i < 4; ++i) {
      right_[first + i] += weight * row[i] * value;
      for (std::size_t j = i; j < 4; ++j) band_[first + i][j - i] += weight * row[i] * row[j];
    }
  }

  // Banded LDLᵀ; nothing if the matrix is not positive definite.
  bool solve() {
    const std::size_t n = band_.size();
    for (std::size_t i = 0; i < n; ++i) {
      auto& pivot = band_[i];
      if (!(pivot[0] > 0.0)) return false;
      for (std::size_t a = 1; a < 4 && i + a < n; ++a) {
        const double l = pivot[a] / pivot[0];
        for (std::size_t b = a; b < 4 && i + b < n; ++b) band_[i + a][b - a] -= l * pivot[b];
        right_[i + a] -= l * right_[i];
      }
    }
    for (std::size_t i = n; i-- > 0;) {
      for (std::size_t a = 1; a < 4 && i + a < n; ++a) right_[i] -= band_[i][a] * right_[i + a];
      right_[i] /= band_[i][0];
    }
    return true;
  }
  std::vector<Eigen::Vector3d> take() { return std::move(right_); }

 private:
  std::vector<std::array<double, 4>> band_;
  std::vector<Eigen::Vector3d> right_;
};

struct Place {
  std::size_t segment;
  double u;
};

Place place_of(double s, std::size_t segments) {
  const auto last = static_cast<double>(segments - 1);
  const double segment = std::clamp(std::floor(s), 0.0, last);
  return {static_cast<std::size_t>(segment), std::clamp(s - segment, 0.0, 1.0)};
}

Result<void> check(std::span<const CurveSample> samples, double begin_s, double end_s) {
  if (!(end_s > begin_s)) return Error{ErrorCode::invalid, "a curve needs a span of time"};
  std::size_t values = 0;
  for (const CurveSample& s : samples) {
    if (!std::isfinite(s.time_s) || !s.value.allFinite() || !(s.sigma > 0.0))
      return Error{ErrorCode::invalid, "a sample of the curve is not finite"};
    values += s.of == CurveSample::Of::value ? 1 : 0;
  }
  if (values < 3) return Error{ErrorCode::invalid, "a curve needs three values or more"};
  return {};
}

}  // namespace

Result<SmoothCurve> SmoothCurve::fit(std::span<const CurveSample> samples, double begin_s,
                                     double end_s, const CurveFit& options) {
  WAYFARE_EXPECTS(options.knot_spacing_s > 0.0 && options.third_derivative_sigma > 0.0,
                  "knots need a spacing and the third derivative a size");
  if (auto ok = check(samples, begin_s, end_s); !ok) return ok.error();
  SmoothCurve curve;
  curve.begin_s_ = begin_s, curve.end_s_ = end_s;
  const double wanted = std::ceil((end_s - begin_s) / options.knot_spacing_s - 1e-9);
  if (!(wanted < 5e6)) return Error{ErrorCode::invalid, "the curve would need too many knots"};
  const auto segments = static_cast<std::size_t>(std::max(1.0, wanted));
  curve.spacing_s_ = (end_s - begin_s) / static_cast<double>(segments);
  const double h = curve.spacing_s_;

  BandedNormal normal(segments + 3);
  for (const CurveSample& s : samples) {
    if (s.time_s < begin_s || s.time_s > end_s) continue;
    const auto [segment, u] = place_of((s.time_s - begin_s) / h, segments);
    auto row = s.of == CurveSample::Of::value ? basis(u) : basis_first(u);
    if (s.of == CurveSample::Of::derivative)
      for (double& r : row) r /= h;
    normal.add(segment, row, s.value, 1.0 / (s.sigma * s.sigma));
  }
  const double jerk = std::pow(h, 3) * options.third_derivative_sigma;
  for (std::size_t k = 0; k < segments; ++k)
    normal.add(k, {-1.0, 3.0, -3.0, 1.0}, Eigen::Vector3d::Zero(), h / (jerk * jerk));
  if (!normal.solve())
    return Error{ErrorCode::degenerate, "the samples do not determine the curve"};
  curve.control_ = normal.take();
  return curve;
}

SmoothCurve::Point SmoothCurve::at(double time_s) const {
  const bool outside = time_s < begin_s_ || time_s > end_s_;
  const double t = std::clamp(time_s, begin_s_, end_s_);
  const double h = spacing_s_;
  const auto [segment, u] = place_of((t - begin_s_) / h, control_.size() - 3);
  const auto b = basis(u), d = basis_first(u), dd = basis_second(u);
  Point p{Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
  for (std::size_t i = 0; i < 4; ++i) {
    const Eigen::Vector3d& c = control_[segment + i];
    p.value += b[i] * c;
    if (outside) continue;
    p.first += d[i] / h * c;
    p.second += dd[i] / (h * h) * c;
  }
  return p;
}

}  // namespace wayfare::sim
