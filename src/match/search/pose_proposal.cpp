#include <wayfare/match/pose_proposal.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <optional>
#include <string>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "match/search/candidates.hpp"

namespace wayfare {

/// c + g·d + ½ dᵀ H d of an offset d along the map's axes, m.
struct PoseProposal::Quadratic {
  double c = 0.0;
  Eigen::Vector2d g = Eigen::Vector2d::Zero();
  Eigen::Matrix2d h = Eigen::Matrix2d::Zero();

  Quadratic& operator+=(const Quadratic& o) {
    c += o.c;
    g += o.g;
    h += o.h;
    return *this;
  }
};

constexpr double kLogTwoPi = 1.8378770664093454836;

/// ln N(x; mean, Σ) over the poses of one heading, which is a quadratic in their translation.
class PoseProposal::LogDensity {
 public:
  static std::optional<LogDensity> of(const Gaussian<SE2d>& g) {
    const Eigen::LLT<Eigen::Matrix3d> llt(g.covariance);
    const bool finite = g.mean.translation().allFinite() && g.covariance.allFinite() &&
                        std::isfinite(g.mean.heading().radians());
    if (llt.info() != Eigen::Success || !finite) return std::nullopt;
    LogDensity d;
    d.mean_ = g.mean;
    d.information_ = llt.solve(Eigen::Matrix3d::Identity());
    d.log_norm_ = -llt.matrixLLT().diagonal().array().log().sum() - 1.5 * kLogTwoPi;
    return d;
  }

  /// As a quadratic about the pose (t, rotation).
  [[nodiscard]] Quadratic about(const Eigen::Vector2d& t, const SO2d& rotation) const {
    const double theta = (mean_.rotation().inverse() * rotation).angle().radians();
    // exp's translation is V(θ) times the tangent's (Solà et al. 2018, (158)).
    const Eigen::Vector2d v = SE2d::exp({1, 0, theta}).translation();
    const Eigen::Matrix2d V = (Eigen::Matrix2d() << v.x(), -v.y(), v.y(), v.x()).finished();
    const Eigen::Matrix2d to_tangent = V.inverse() * mean_.rotation().matrix().transpose();
    Eigen::Vector3d tau;
    tau << to_tangent * (t - mean_.translation()), theta;
    const Eigen::Vector3d slope = -information_ * tau;
    Quadratic q;
    q.c = log_norm_ - std::log(V.determinant()) + 0.5 * tau.dot(slope);
    q.g = to_tangent.transpose() * slope.head<2>();
    q.h = -to_tangent.transpose() * information_.topLeftCorner<2, 2>() * to_tangent;
    return q;
  }

 private:
  SE2d mean_;
  Eigen::Matrix3d information_;
  double log_norm_ = 0.0;
};

namespace {

int nodes_over(double reach_m, double cell_m) {
  constexpr double kMost = 2.0 * PoseProposal::kMaxHalf + 1.0;
  const double nodes = std::ceil(2.0 * reach_m / cell_m);
  return nodes > 1.0 ? static_cast<int>(std::min(nodes, kMost)) : 1;
}

Result<void> check(const LikelihoodField& grid, const PointSet& points,
                   const PoseProposalOptions& o) {
  const auto fault = [](const char* what) { return Error{ErrorCode::invalid, what}; };
  if (grid.empty()) return fault("PoseProposal: the map is empty");
  if (points.empty()) return fault("PoseProposal: no points");
  for (const auto& axis : {points.x_m(), points.y_m()})
    if (!std::all_of(axis.begin(), axis.end(), [](float t) { return std::isfinite(t); }))
      return fault("PoseProposal: a point is not finite");
  if (o.samples < 1 || o.headings < 1 || !(o.reach_sigmas > 0) || !std::isfinite(o.reach_sigmas) ||
      o.samples > 1 << 20 || o.headings > 1 << 12 || std::isnan(o.independent_points))
    return fault("PoseProposal: samples, headings or reach out of range");
  return {};
}

Error not_a_density(const char* which) {
  return {ErrorCode::numerical, std::string("PoseProposal: the ") + which +
                                    " is not finite, or its covariance not positive definite"};
}

}  // namespace

/// The samples' positions: at each heading a rectangle of whole cells about the proposal's mean
/// given that heading. If the proposal is narrower than a cell there is one node, jittered within
/// the proposal's extent.
struct PoseProposal::Lattice {
  SE2d mean;
  Eigen::Vector2d mean_per_rad;  // shift of the mean with heading, along the map's axes
  double cell_m;
  Eigen::Vector2d jitter_m;
  int columns, rows, headings;
  double first_rad, step_rad;

  Lattice(const Gaussian<SE2d>& proposal, double resolution_m, const PoseProposalOptions& o)
      : mean(proposal.mean), cell_m(resolution_m) {
    const Eigen::Matrix2d r = proposal.mean.rotation().matrix();
    const Eigen::Matrix3d& s = proposal.covariance;
    const Eigen::Vector2d cross = s.topRightCorner<2, 1>();
    mean_per_rad = r * cross / s(2, 2);
    const Eigen::Matrix2d rest = s.topLeftCorner<2, 2>() - cross * cross.transpose() / s(2, 2);
    const Eigen::Vector2d reach =
        o.reach_sigmas * (r * rest * r.transpose()).diagonal().cwiseMax(0.0).cwiseSqrt();
    columns = nodes_over(reach.x(), cell_m);
    rows = nodes_over(reach.y(), cell_m);
    jitter_m = (2.0 * reach).cwiseMin(cell_m).cwiseMax(1e-6 * cell_m);
    headings = std::max(o.headings, (o.samples + columns * rows - 1) / (columns * rows));
    const double reach_rad = std::min(std::numbers::pi, o.reach_sigmas * std::sqrt(s(2, 2)));
    first_rad = -reach_rad;
    step_rad = 2 * reach_rad / headings;
  }

  [[nodiscard]] int nodes() const { return columns * rows; }
  [[nodiscard]] SE2d moved(const Eigen::Vector3d& d) const {
    return SE2d(Eigen::Vector2d(mean.translation() + d.head<2>()),
                mean.rotation() * SO2d(Angle::radians(d[2])));
  }
  [[nodiscard]] Slice jittered_slice(int k, Rng& rng) const {
    const double heading_rad = first_rad + (k + rng.uniform()) * step_rad;
    const double x = (rng.uniform() - 0.5) * jitter_m.x();
    const double y = (rng.uniform() - 0.5) * jitter_m.y();
    const Eigen::Vector2d middle(0.5 * (columns - 1), 0.5 * (rows - 1));
    return {
        mean.rotation() * SO2d(Angle::radians(heading_rad)), heading_rad,
        mean.translation() + mean_per_rad * heading_rad + Eigen::Vector2d(x, y) - cell_m * middle};
  }
  /// Offset of node `i` of a slice from the mean: translation along the map's axes, and heading.
  [[nodiscard]] Eigen::Vector3d offset(const Slice& slice, int i) const {
    const Eigen::Vector2d node(i % columns, i / columns);
    Eigen::Vector3d d;
    d << slice.corner + cell_m * node - mean.translation(), slice.heading_rad;
    return d;
  }
  /// From Σ value to ln τ, weighted by the volume of a node.
  void add_densities(const Quadratic& f, double per_value, double* out) const {
    const double bend = 0.5 * f.h(0, 0) * cell_m * cell_m;
    for (int y = 0; y < rows; ++y, out += columns) {
      const double dy = y * cell_m;
      const double start = f.c + dy * (f.g.y() + 0.5 * dy * f.h(1, 1));
      const double slope = (f.g.x() + dy * f.h(0, 1)) * cell_m;
      for (int x = 0; x < columns; ++x)
        out[x] = per_value * out[x] + start + x * (slope + x * bend);
    }
  }
  [[nodiscard]] double log_volume() const { return std::log(step_rad * jitter_m.prod()); }
};

/// Σ value at every node of a slice.
void PoseProposal::score(const LikelihoodField& grid, const PointSet& points, const Slice& slice,
                         const Lattice& lattice, double* out) {
  const double inverse = 1.0 / grid.resolution_m();
  kernels::best_kernels().place(points.padded_x_m().data(), points.padded_y_m().data(),
                                static_cast<int>(u_.size()),
                                static_cast<float>(slice.rotation.cos() * inverse),
                                static_cast<float>(slice.rotation.sin() * inverse),
                                static_cast<float>(slice.corner.x() * inverse - grid.origin().x),
                                static_cast<float>(slice.corner.y() * inverse - grid.origin().y),
                                1048576.0F, u_.data(), v_.data());
  detail::score_blocks(grid, static_cast<int>(points.size()), u_, v_, index_,
                       {{0, 0}, {lattice.columns - 1, lattice.rows - 1}},
                       [&](const Cell& node, int count, const std::uint32_t* sums) {
                         std::copy_n(sums, count, out + node.y * lattice.columns + node.x);
                       });
}

Result<PoseDraw> PoseProposal::draw(const LikelihoodField& grid, const PointSet& points,
                                    const Gaussian<SE2d>& proposal, const Gaussian<SE2d>& motion,
                                    Rng& rng, const PoseProposalOptions& options) {
  nodes_ = 0;
  if (auto ok = check(grid, points, options); !ok) return ok.error();
  const auto q = LogDensity::of(proposal), p = LogDensity::of(motion);
  if (!q) return not_a_density("proposal");
  if (!p) return not_a_density("motion");

  const Lattice lattice(proposal, grid.resolution_m(), options);
  const double n = static_cast<double>(points.size()), independent = options.independent_points;
  const double scale = independent > 0 ? std::min(1.0, independent / n) : 1.0;
  const double floor = scale * grid.log_floor() * n + lattice.log_volume();
  for (auto* scratch : {&u_, &v_, &index_}) scratch->resize(points.padded_x_m().size());
  log_tau_.resize(static_cast<std::size_t>(lattice.headings) *
                  static_cast<std::size_t>(lattice.nodes()));
  slices_.clear();
  double* out = log_tau_.data();
  for (int k = 0; k < lattice.headings; ++k, out += lattice.nodes()) {
    slices_.push_back(lattice.jittered_slice(k, rng));
    const Slice& slice = slices_.back();
    score(grid, points, slice, lattice, out);
    Quadratic f = p->about(slice.corner, slice.rotation);
    if (!options.divide_by_proposal) f += q->about(slice.corner, slice.rotation);
    f.c += floor;
    lattice.add_densities(f, scale * grid.log_step(), out);
  }
  PoseDraw drawn = sample_pose(lattice, rng);
  if (!std::isfinite(drawn.log_evidence) || !drawn.T_map_points.translation().allFinite() ||
      !drawn.moments.covariance.allFinite())
    return Error{ErrorCode::numerical, "PoseProposal: the densities exceed the range of numbers"};
  cell_m_ = lattice.cell_m;
  columns_ = static_cast<std::size_t>(lattice.columns);
  nodes_ = static_cast<std::size_t>(lattice.nodes());
  return drawn;
}

std::vector<WeightedPose> PoseProposal::samples() const {
  std::vector<WeightedPose> samples;
  if (nodes_ == 0) return samples;
  const double sum = std::accumulate(log_tau_.begin(), log_tau_.end(), 0.0);
  samples.reserve(log_tau_.size());
  for (std::size_t i = 0; i < log_tau_.size(); ++i) {
    const Slice& slice = slices_[i / nodes_];
    const std::size_t node = i % nodes_, row = node / columns_;
    const Eigen::Vector2d cell(static_cast<double>(node % columns_), static_cast<double>(row));
    samples.push_back(
        {SE2d(Eigen::Vector2d(slice.corner + cell_m_ * cell), slice.rotation), log_tau_[i] / sum});
  }
  return samples;
}

/// Draws one of the samples by weight; sum and moments of the weights.
PoseDraw PoseProposal::sample_pose(const Lattice& lattice, Rng& rng) {
  constexpr double kNegligible = -30.0;
  const double top = *std::max_element(log_tau_.begin(), log_tau_.end());
  double total = 0.0;
  Eigen::Vector3d first = Eigen::Vector3d::Zero();
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
  const auto nodes = static_cast<std::size_t>(lattice.nodes());
  const auto offset = [&](std::size_t i) {
    return lattice.offset(slices_[i / nodes], static_cast<int>(i % nodes));
  };
  for (std::size_t i = 0; i < log_tau_.size(); ++i) {
    const double relative = log_tau_[i] - top;
    const double tau = log_tau_[i] = relative < kNegligible ? 0.0 : std::exp(relative);
    if (tau == 0.0) continue;
    const Eigen::Vector3d d = offset(i);
    total += tau;
    first += tau * d;
    second += tau * d * d.transpose();
  }
  first /= total;
  const Eigen::Matrix3d covariance = second / total - first * first.transpose();
  PoseDraw result;
  result.samples = static_cast<int>(log_tau_.size());
  result.log_evidence = top + std::log(total);
  result.T_map_points = lattice.moved(offset(pick(rng.uniform() * total)));
  result.moments.mean = lattice.moved(first);
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  turn.topLeftCorner<2, 2>() = result.moments.mean.rotation().matrix().transpose();
  result.moments.covariance = turn * covariance * turn.transpose();
  return result;
}

/// Index at which the cumulative sum of τ exceeds `sum`.
std::size_t PoseProposal::pick(double sum) const {
  std::size_t last = 0;
  for (std::size_t i = 0; i < log_tau_.size(); ++i) {
    if (log_tau_[i] == 0.0) continue;
    last = i;
    sum -= log_tau_[i];
    if (sum < 0.0) break;
  }
  return last;
}

}  // namespace wayfare
