#include "graph/consistency/growth.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <numbers>
#include <string>
#include <utility>

#include <Eigen/Cholesky>

#include <wayfare/core/statistics.hpp>
#include <wayfare/graph/detail/validate.hpp>
#include <wayfare/graph/pose_graph.hpp>

#include "graph/lists.hpp"

namespace wayfare::detail {
namespace {

template <LieGroup G>
constexpr int kAxes = static_cast<int>(G::Vector::RowsAtCompileTime);

}  // namespace

template <LieGroup G>
Result<void> check_chain(const PoseGraph<G>& graph) {
  const std::vector<int> chain = chain_of(graph);
  for (int k = 1; k < graph.size(); ++k)
    if (chain[at(k)] < 0)
      return Error{ErrorCode::degenerate,
                   "no trusted edge joins poses " + graph.label(k - 1) + " and " + graph.label(k)};
  return {};
}

template <LieGroup G>
LoopGrowth<G>::LoopGrowth(const PoseGraph<G>& graph, const LoopConsistencyOptions& options)
    : graph_(graph),
      options_(options),
      paths_(graph),
      state_(graph.edges.size(), State::open),
      compared_(graph.edges.size(), 0),
      p_values_(graph.edges.size(), 1.0),
      gate_(chi_square_quantile(options.inlier_probability, ManifoldTraits<G>::kDof)),
      scale_(options.noise_scale) {
  std::vector<int> trusted;
  for (std::size_t k = 0; k < graph.edges.size(); ++k) {
    const int edge = static_cast<int>(k);
    if (graph.edges[k].robust) {
      open_.push_back(edge);
    } else {
      state_[k] = State::accepted;
      trusted.push_back(edge);
    }
  }
  paths_.accept(trusted);
  measure_spread();
  if (!(scale_ > 0.0)) estimate_scale();
}

template <LieGroup G>
void LoopGrowth<G>::measure_spread() {
  typename G::Vector mean = G::Vector::Zero();
  for (const G& x : paths_.odometry()) mean += x.translation() / graph_.size();
  double sum = 0.0;
  for (const G& x : paths_.odometry()) sum += (x.translation() - mean).squaredNorm();
  spread_ = 2.0 * sum / (graph_.size() * kAxes<G>);
}

/// A quarter of the loops is assumed to be true, so that the quantile of d² at 1/4, which is that
/// of the true ones at least, is not below theirs.
template <LieGroup G>
void LoopGrowth<G>::estimate_scale() {
  constexpr double kQuantile = 0.25, kLeast = 1.0 / 32.0;
  scale_ = 1.0;
  if (open_.empty()) return;
  std::vector<double> squares;
  for (const int k : open_) {
    const PoseEdge<G>& loop = graph_.edges[at(k)];
    const LoopPath<G> path = paths_.along_chain(loop.from, loop.to);
    const SquareOf<G> s = path.covariance + paths_.covariance(k);
    const TangentOf<G> r = path.across.minus(loop.measurement);
    if (const double d2 = r.dot(s.ldlt().solve(r)); d2 >= 0.0) squares.push_back(d2);
  }
  if (squares.empty()) return;
  const auto quantile = squares.begin() + static_cast<long>(kQuantile * double(squares.size()));
  std::nth_element(squares.begin(), quantile, squares.end());
  const double few = 1.0 + 5.0 / std::sqrt(static_cast<double>(squares.size()));
  const double ratio = *quantile / chi_square_quantile(kQuantile, ManifoldTraits<G>::kDof);
  scale_ = std::clamp(few * ratio, kLeast, 1.0);
}

template <LieGroup G>
auto LoopGrowth<G>::compare(int edge, const LoopPath<G>& path) const -> Agreement {
  constexpr int kDof = ManifoldTraits<G>::kDof;
  // Volume of the unit ball by (2π)^(n/2).
  constexpr double kBall = kDof == 3 ? 0.26596152026762 : 1.0 / 48.0;
  const SquareOf<G> s = scale_ * (path.covariance + paths_.covariance(edge));
  const TangentOf<G> r = path.across.minus(graph_.edges[at(edge)].measurement);
  // Unrelated poses are no further apart than the path is long.
  const double apart = std::min(spread_, path.length * path.length / 3.0);
  SquareOf<G> unrelated = s;
  for (int k = 0; k < kDof; ++k)
    unrelated(k, k) += k < kAxes<G> ? apart : std::numbers::pi * std::numbers::pi / 3.0;
  const Eigen::LLT<SquareOf<G>> factor(s), outer(unrelated);
  const double square = factor.matrixL().solve(r).squaredNorm();
  double p_value = kBall;
  for (int k = 0; k < kDof; ++k)
    p_value *= std::sqrt(square) * factor.matrixLLT()(k, k) / outer.matrixLLT()(k, k);
  if (!std::isfinite(p_value)) return {0.0, 1.0};
  return {square, std::min(p_value, 1.0)};
}

/// Compares the loops for the first time that close a cycle of at most `hops` edges and one.
template <LieGroup G>
void LoopGrowth<G>::reach(int hops) {
  if (hops <= hops_) return;
  hops_ = hops;
  LoopPath<G> path;
  for (const int k : open_)
    if (paths_.edges(k) > hops && paths_.find(k, hops, path)) classify(k, path);
  drop_decided();
}

/// Compares the open loops again that have shorter paths over edges accepted just now.
template <LieGroup G>
void LoopGrowth<G>::compare_shortened(const std::vector<int>& accepted) {
  constexpr std::size_t kSearches =
      8;  // between the ends of a loop, in the time of one from an edge
  const std::vector<int> loops = paths_.affected(accepted, open_, hops_);
  if (kSearches * accepted.size() < loops.size()) {
    int longest = 0;
    for (const int k : loops) longest = std::max(longest, paths_.edges(k));
    std::vector<int> poses;
    for (const int edge : accepted) poses.push_back(graph_.edges[at(edge)].from);
    paths_.shorten(poses, std::min(hops_, longest - 1), loops,
                   [&](int k, const LoopPath<G>& path) { classify(k, path); });
  } else {
    LoopPath<G> path;
    for (const int k : loops)
      if (paths_.find(k, std::min(hops_, paths_.edges(k) - 1), path)) classify(k, path);
  }
  drop_decided();
}

template <LieGroup G>
double LoopGrowth<G>::classify(int edge, const LoopPath<G>& path) {
  const Agreement found = compare(edge, path);
  if (std::exchange(compared_[at(edge)], 1) == 0) ++unaccepted_;
  if (found.square > gate_) state_[at(edge)] = State::refused;
  return p_values_[at(edge)] = found.p_value;
}

template <LieGroup G>
void LoopGrowth<G>::accept(const std::vector<Candidate>& candidates) {
  std::vector<int> edges;
  for (const Candidate& c : candidates) {
    p_values_[at(c.edge)] = c.p_value;
    state_[at(c.edge)] = State::accepted;
    edges.push_back(c.edge);
    --unaccepted_;
  }
  paths_.accept(edges);
  drop_decided();
  compare_shortened(edges);
}

/// The most significant candidates: all far below the limit, else the one of the least p-value and
/// those similar to it.
template <LieGroup G>
bool LoopGrowth<G>::accept_most_significant(std::vector<Candidate> candidates) {
  constexpr double kFar = 0.03, kSimilar = 10.0;
  ++rounds_;
  const double limit = options_.max_false / std::max(1.0, static_cast<double>(unaccepted_));
  double least = 1.0;
  for (const Candidate& c : candidates) least = std::min(least, c.p_value);
  const double enough = std::min(std::max(kSimilar * least, kFar * limit), limit);
  std::erase_if(candidates, [&](const Candidate& c) { return c.p_value > enough; });
  if (!candidates.empty()) accept(candidates);
  return !candidates.empty();
}

/// The open loops that close a cycle of at most `hops` edges and one.
template <LieGroup G>
auto LoopGrowth<G>::candidates(int hops) const -> std::vector<Candidate> {
  std::vector<Candidate> all;
  for (const int k : open_)
    if (paths_.edges(k) <= hops) all.push_back({k, p_values_[at(k)]});
  return all;
}

template <LieGroup G>
void LoopGrowth<G>::run() {
  constexpr int kHops = 16;
  for (int hops = kHops; !open_.empty();) {
    reach(hops);
    if (accept_most_significant(candidates(hops))) continue;
    if (hops >= graph_.size()) break;
    hops = std::min(4 * hops, graph_.size());
  }
}

/// Loops whose ends are near each other on the trajectory say the same and have one number; of
/// every edge, −1 where it is not open.
template <LieGroup G>
std::vector<int> LoopGrowth<G>::regions() const {
  constexpr int kNear = 32;
  const auto ends = [&](int k) {
    const PoseEdge<G>& e = graph_.edges[at(k)];
    return std::minmax(e.from, e.to);
  };
  Components parts(static_cast<int>(state_.size()));
  for (const int a : open_)
    for (const int b : open_)
      if (std::abs(ends(a).first - ends(b).first) <= kNear &&
          std::abs(ends(a).second - ends(b).second) <= kNear)
        parts.join(a, b);
  std::vector<int> region(state_.size(), -1);
  for (const int k : open_) region[at(k)] = parts.root(k);
  return region;
}

/// The logarithm of the joint p-value of `first` and what is accepted after it in other regions,
/// corrected for the number of loops.
template <LieGroup G>
double LoopGrowth<G>::joint_log_p_value(const Candidate& first,
                                        const std::vector<int>& region) const {
  const double loops = std::max(1.0, static_cast<double>(unaccepted_));
  LoopGrowth trial(*this);
  trial.accept(std::vector{first});
  trial.run();
  std::map<int, double> p_values;  // the least of each region
  for (const int k : open_) {
    if (!trial.accepted(at(k))) continue;
    double& least = p_values.try_emplace(region[at(k)], 1.0).first->second;
    least = std::min(least, trial.p_values_[at(k)]);
  }
  p_values[region[at(first.edge)]] = first.p_value;
  double sum = 0.0;
  for (const auto& [name, p_value] : p_values) sum += std::log(std::max(p_value, 1e-12) * loops);
  return sum;
}

/// The most significant candidates, one of each region.
template <LieGroup G>
auto LoopGrowth<G>::most_significant_by_region(const std::vector<int>& region) const
    -> std::vector<Candidate> {
  constexpr std::size_t kMost = 32;
  std::vector<Candidate> all = candidates(graph_.size());
  std::sort(all.begin(), all.end(), [](const Candidate& a, const Candidate& b) {
    return a.p_value < b.p_value || (a.p_value == b.p_value && a.edge < b.edge);
  });
  std::vector<Candidate> first;
  for (const Candidate& c : all) {
    const auto same = [&](const Candidate& f) { return region[at(f.edge)] == region[at(c.edge)]; };
    if (first.size() < kMost && std::none_of(first.begin(), first.end(), same)) first.push_back(c);
  }
  return first;
}

template <LieGroup G>
bool LoopGrowth<G>::accept_together() {
  if (open_.empty()) return false;
  reach(graph_.size());
  const std::vector<int> region = regions();
  double least = std::log(std::min(options_.max_false, 1.0));
  Candidate best{-1, 1.0};
  for (const Candidate& c : most_significant_by_region(region)) {
    const double sum = joint_log_p_value(c, region);
    if (sum < least) least = sum, best = c;
  }
  if (best.edge < 0) return false;
  accept(std::vector{best});
  run();
  return true;
}

template Result<void> check_chain(const PoseGraph<SE2d>&);
template Result<void> check_chain(const PoseGraph<SE3d>&);
template class LoopGrowth<SE2d>;
template class LoopGrowth<SE3d>;

}  // namespace wayfare::detail
