#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstdlib>
#include <numeric>

#include <Eigen/Cholesky>

#include <wayfare/core/statistics.hpp>

#include "methods.hpp"

namespace wayfare::examples {
namespace {

constexpr std::size_t at(int i) { return static_cast<std::size_t>(i); }

template <LieGroup G>
SquareOf<G> covariance_of(const PoseEdge<G>& edge) {
  const SquareOf<G> by =
      PoseError<G>::linearise(edge.measurement, G(), edge.measurement).by_to.inverse();
  return by * edge.information.inverse() * by.transpose();
}

/// Poses along the odometry and the covariance between any two.
template <LieGroup G>
class Chain {
 public:
  explicit Chain(const PoseGraph<G>& graph)
      : poses_(graph.poses.size()), sums_(graph.poses.size(), SquareOf<G>::Zero()) {
    std::vector<const PoseEdge<G>*> edges(poses_.size(), nullptr);
    for (const auto& e : graph.edges)
      if (!e.robust && std::abs(e.from - e.to) == 1) edges[at(std::max(e.from, e.to))] = &e;
    for (std::size_t k = 1; k < poses_.size(); ++k) {
      const PoseEdge<G>& e = *edges[k];
      poses_[k] =
          poses_[k - 1] * (e.to == static_cast<int>(k) ? e.measurement : e.measurement.inverse());
      const SquareOf<G> move = poses_[at(e.to)].adjoint();
      sums_[k] = sums_[k - 1] + move * covariance_of(e) * move.transpose();
    }
  }

  [[nodiscard]] G between(int i, int j) const { return poses_[at(i)].inverse() * poses_[at(j)]; }
  /// Of between(i, j), as a right perturbation.
  [[nodiscard]] SquareOf<G> covariance(int i, int j) const {
    const SquareOf<G> move = poses_[at(j)].inverse().adjoint();
    return move * (sums_[at(std::max(i, j))] - sums_[at(std::min(i, j))]) * move.transpose();
  }

 private:
  std::vector<G> poses_;
  std::vector<SquareOf<G>> sums_;
};

/// Squared Mahalanobis error of the cycle a, odometry, b backwards, odometry.
template <LieGroup G>
double cycle_error(const Chain<G>& chain, const PoseEdge<G>& a, const PoseEdge<G>& b,
                   const SquareOf<G>& of_a, const SquareOf<G>& of_b) {
  const G ahead = chain.between(a.from, b.from), back = chain.between(b.to, a.to);
  const G predicted = ahead * b.measurement * back;
  const auto moved = [](const G& by, const SquareOf<G>& covariance) -> SquareOf<G> {
    const SquareOf<G> move = by.inverse().adjoint();
    return move * covariance * move.transpose();
  };
  const SquareOf<G> s = of_a + chain.covariance(b.to, a.to) + moved(back, of_b) +
                        moved(b.measurement * back, chain.covariance(a.from, b.from));
  const TangentOf<G> r = predicted.minus(a.measurement);
  return r.dot(s.ldlt().solve(r));
}

/// Rows of bits.
class Pairs {
 public:
  explicit Pairs(std::size_t n) : words_((n + 63) / 64), bits_(n * words_, 0) {}
  void set(std::size_t i, std::size_t j) { row(i)[j / 64] |= std::uint64_t{1} << j % 64; }
  [[nodiscard]] std::uint64_t* row(std::size_t i) { return bits_.data() + i * words_; }
  [[nodiscard]] const std::uint64_t* row(std::size_t i) const { return bits_.data() + i * words_; }
  [[nodiscard]] std::size_t words() const { return words_; }
  [[nodiscard]] int common(std::size_t i, const std::vector<std::uint64_t>& with) const {
    int count = 0;
    for (std::size_t w = 0; w < words_; ++w) count += std::popcount(row(i)[w] & with[w]);
    return count;
  }

 private:
  std::size_t words_;
  std::vector<std::uint64_t> bits_;
};

/// From `first`, always the candidate with most neighbours among the candidates.
std::vector<std::size_t> grow_clique(const Pairs& pairs, std::size_t first) {
  std::vector<std::size_t> clique{first};
  std::vector<std::uint64_t> open(pairs.row(first), pairs.row(first) + pairs.words());
  for (;;) {
    int most = -1;
    std::size_t best = 0;
    for (std::size_t w = 0; w < open.size(); ++w)
      for (std::uint64_t left = open[w]; left != 0; left &= left - 1) {
        const std::size_t k = 64 * w + static_cast<std::size_t>(std::countr_zero(left));
        if (const int common = pairs.common(k, open); common > most) most = common, best = k;
      }
    if (most < 0) return clique;
    clique.push_back(best);
    for (std::size_t w = 0; w < open.size(); ++w) open[w] &= pairs.row(best)[w];
  }
}

}  // namespace

template <LieGroup G>
std::vector<char> largest_clique_of_loops(const PoseGraph<G>& graph, double scale) {
  constexpr std::size_t kStarts = 3;
  const double gate = scale * chi_square_quantile(0.99, ManifoldTraits<G>::kDof);
  const Chain<G> chain(graph);
  std::vector<std::size_t> loops;
  std::vector<SquareOf<G>> covariances;
  for (std::size_t k = 0; k < graph.edges.size(); ++k) {
    if (!graph.edges[k].robust) continue;
    loops.push_back(k);
    covariances.push_back(covariance_of(graph.edges[k]));
  }
  Pairs pairs(loops.size());
  std::vector<int> degree(loops.size(), 0);
  for (std::size_t a = 0; a < loops.size(); ++a)
    for (std::size_t b = 0; b < a; ++b) {
      if (cycle_error(chain, graph.edges[loops[a]], graph.edges[loops[b]], covariances[a],
                      covariances[b]) > gate)
        continue;
      pairs.set(a, b), pairs.set(b, a);
      ++degree[a], ++degree[b];
    }
  std::vector<std::size_t> order(loops.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return degree[a] > degree[b]; });
  std::vector<std::size_t> best;
  for (std::size_t k = 0; k < std::min(kStarts, order.size()); ++k) {
    auto clique = grow_clique(pairs, order[k]);
    if (clique.size() > best.size()) best = std::move(clique);
  }
  std::vector<char> in(graph.edges.size(), 0);
  for (const std::size_t k : best) in[loops[k]] = 1;
  return in;
}

template std::vector<char> largest_clique_of_loops(const PoseGraph<SE2d>&, double);
template std::vector<char> largest_clique_of_loops(const PoseGraph<SE3d>&, double);

}  // namespace wayfare::examples
