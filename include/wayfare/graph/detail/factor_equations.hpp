#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/result.hpp>
#include <wayfare/graph/detail/edge_blocks.hpp>
#include <wayfare/graph/detail/variable_columns.hpp>
#include <wayfare/graph/edge.hpp>
#include <wayfare/graph/linear_solver.hpp>

namespace wayfare {

template <class AllVariables, class AllEdges>
class FactorGraph;
template <class Graph>
struct EquationsOf;

/// H = Σ w JᵀΩJ and g = Σ w JᵀΩe of a factor graph over its free variables, with w the kernel's
/// weight. Each variable has a block of the same size; the rows that a smaller one does not use
/// have the scale of its information on the diagonal and nothing else, so that their step is zero.
template <class Graph>
class FactorEquations {
 public:
  static constexpr int kBlock = Graph::kBlock;
  using Matrix = BlockSparse<kBlock>;

  /// Sets up the pattern for a validated graph; returns whether it changed.
  bool set_structure(const Graph& graph);

  /// Weights of the edges in addition to the kernel's, in the order of each_edge; empty: 1.
  void set_weights(std::vector<double> weights) { weights_ = std::move(weights); }

  /// Whether the edges' own kernels apply; default true. Otherwise ρ(s) = s.
  void use_kernels(bool use) { kernels_ = use; }

  /// Fills H and g at the graph's values; returns Σ w ρ(eᵀΩe).
  double linearise(const Graph& graph, const RobustKernel& = {});

  /// Σ w ρ(eᵀΩe).
  [[nodiscard]] double cost(const Graph& graph, const RobustKernel& = {}) const {
    double sum = 0.0;
    std::size_t k = 0;
    graph.each_edge([&](const auto& edge, const auto&, const auto&... x) {
      const double s = squared_error(edge, x...);
      sum += weight(k++) * (kernels_ ? robust_value(edge, s).cost : s);
    });
    return sum;
  }

  /// Σ eᵀΩe over all edges at the last linearisation, without kernel and weights.
  [[nodiscard]] double chi2() const { return chi2_; }

  [[nodiscard]] Matrix& hessian() { return hessian_; }
  [[nodiscard]] const Matrix& hessian() const { return hessian_; }
  [[nodiscard]] const Eigen::VectorXd& gradient() const { return gradient_; }
  /// The free variables in the order of the block columns.
  [[nodiscard]] const std::vector<int>& free() const { return columns_.free(); }
  /// The block column of a variable, −1 if it is fixed.
  [[nodiscard]] int column(int variable) const { return columns_.of(variable); }

 private:
  [[nodiscard]] double weight(std::size_t edge) const {
    return weights_.empty() ? 1.0 : weights_[edge];
  }
  template <class E, class... X>
  double add(const E& edge, std::size_t k, const int* slots, const int* columns, const X&... x);
  void fill_unused(const Graph& graph);

  std::vector<int> ends_;   // the structure's own copy: the variables of each edge, then −1
  std::vector<int> fixed_;  // and the fixed ones
  VariableColumns columns_;
  bool is_complete_ = false;  // an exception while the structure was made leaves a part of it
  std::vector<int> slots_;  // blocks of H of every pair i ≤ j of an edge's variables, −1: fixed
  std::vector<double> weights_;
  Matrix hessian_;
  Eigen::VectorXd gradient_;
  double chi2_ = 0.0;
  bool kernels_ = true;
};

template <class V, class E>
struct EquationsOf<FactorGraph<V, E>> {
  using Type = FactorEquations<FactorGraph<V, E>>;
};

template <class Graph>
bool FactorEquations<Graph>::set_structure(const Graph& graph) {
  std::vector<int> ends;
  graph.each_edge([&](const auto&, const auto& variables, const auto&...) {
    ends.insert(ends.end(), variables.begin(), variables.end());
    ends.push_back(-1);
  });
  if (is_complete_ && columns_.size() == graph.size() && ends == ends_ && fixed_ == graph.fixed())
    return false;
  is_complete_ = false;
  ends_ = std::move(ends);
  fixed_ = graph.fixed();
  columns_.number(graph.size(), fixed_);
  std::vector<std::pair<int, int>> pairs;
  const auto each_pair = [&](const auto& with) {
    graph.each_edge([&](const auto&, const auto& variables, const auto&...) {
      for (std::size_t i = 0; i < variables.size(); ++i)
        for (std::size_t j = i; j < variables.size(); ++j)
          with(column(variables[i]), column(variables[j]));
    });
  };
  each_pair([&](int a, int b) {
    if (a >= 0 && b >= 0 && a != b) pairs.emplace_back(a, b);
  });
  hessian_ = Matrix(static_cast<int>(free().size()), pairs);
  gradient_.setZero(static_cast<Eigen::Index>(free().size()) * kBlock);
  slots_.clear();
  each_pair([&](int a, int b) {
    slots_.push_back(a < 0 || b < 0 ? -1 : hessian_.find(std::min(a, b), std::max(a, b)));
  });
  is_complete_ = true;
  return true;
}

template <class Graph>
double FactorEquations<Graph>::linearise(const Graph& graph, const RobustKernel&) {
  hessian_.set_zero();
  gradient_.setZero();
  chi2_ = 0.0;
  double cost = 0.0;
  std::size_t k = 0;
  const int* slots = slots_.data();
  graph.each_edge([&](const auto& edge, const auto& variables, const auto&... x) {
    constexpr std::size_t kCount = sizeof...(x);
    std::array<int, kCount> columns;
    std::transform(variables.begin(), variables.end(), columns.begin(),
                   [&](int v) { return column(v); });
    cost += add(edge, k++, slots, columns.data(), x...);
    slots += kCount * (kCount + 1) / 2;
  });
  fill_unused(graph);
  return cost;
}

template <class Graph>
template <class E, class... X>
double FactorEquations<Graph>::add(const E& edge, std::size_t k, const int* slots,
                                   const int* columns, const X&... x) {
  const auto to_gradient = [&](auto i, const auto& part) {
    constexpr int kRows = std::remove_cvref_t<decltype(part)>::RowsAtCompileTime;
    if (columns[i] >= 0) gradient_.template segment<kRows>(columns[i] * kBlock) += part;
  };
  const auto to_hessian = [&](auto i, auto j, const auto& part) {
    const int slot = *slots++;
    if (slot < 0) return;
    constexpr int kRows = std::remove_cvref_t<decltype(part)>::RowsAtCompileTime;
    constexpr int kColumns = std::remove_cvref_t<decltype(part)>::ColsAtCompileTime;
    auto block = hessian_.block(slot);
    if (columns[i] <= columns[j]) block.template topLeftCorner<kRows, kColumns>().noalias() += part;
    if (columns[i] > columns[j] || (i != j && columns[i] == columns[j]))
      block.template topLeftCorner<kColumns, kRows>().noalias() += part.transpose();
  };
  const detail::EdgeCost added =
      detail::edge_blocks(edge, weight(k), kernels_, to_gradient, to_hessian, x...);
  chi2_ += added.squared_error;
  return weight(k) * added.cost;
}

template <class Graph>
void FactorEquations<Graph>::fill_unused(const Graph& graph) {
  for (int c = 0; c < hessian_.columns(); ++c) {
    const int dof = graph.dof(free()[static_cast<std::size_t>(c)]);
    if (dof == kBlock) continue;
    auto diagonal = hessian_.block(hessian_.diagonal_index(c)).diagonal();
    const double scale = diagonal.head(dof).maxCoeff();
    diagonal.tail(kBlock - dof).setConstant(scale > 0.0 ? scale : 1.0);
  }
}

namespace detail {

/// Success if it is finite, not zero, symmetric, and positive semi-definite to rounding; else
/// "has zero information", for an edge.
[[nodiscard]] Result<void> check_information(const Eigen::Ref<const Eigen::MatrixXd>& information);

/// "edge 3 (1, 7) has …"; edges are counted type by type.
[[nodiscard]] Error edge_fault(int index, std::span<const int> variables, ErrorCode code,
                               const std::string& what);

/// What is wrong with the error of an edge or its Jacobians at x, or success.
template <Edge E, class... X>
[[nodiscard]] Result<void> check_error(const E& edge, const X&... x) {
  JacobiansOf<E> jacobians;
  if (!EdgeError<E>(linearise(edge, jacobians, x...)).allFinite())
    return Error{ErrorCode::invalid, "has an error that is not finite"};
  if (!std::isfinite(squared_error(edge, x...)))
    return Error{ErrorCode::degenerate, "has an error too large to square"};
  if (!std::apply([](const auto&... by) { return (by.allFinite() && ...); }, jacobians.by))
    return Error{ErrorCode::invalid, "has a Jacobian that is not finite"};
  return {};
}

}  // namespace detail

/// The first edge whose information is not that of a measurement, or success. Errors that are not
/// finite are found when they are computed, variables that are not determined when H is factorised.
template <class V, class E>
[[nodiscard]] Result<void> validate(const FactorGraph<V, E>& graph) {
  if (graph.size() == 0) return Error{ErrorCode::degenerate, "the graph has no variables"};
  Result<void> first;
  int index = 0;
  graph.each_edge([&]<class X>(const X& edge, const auto& variables, const auto&...) {
    if constexpr (detail::kHasInformation<X>) {
      if (first) {
        const auto checked = detail::check_information(edge.information);
        if (!checked)
          first =
              detail::edge_fault(index, variables, checked.error().code, checked.error().message);
      }
    }
    ++index;
  });
  return first;
}

/// Names the edge that makes the cost or the gradient of a valid graph not finite.
template <class V, class E>
[[nodiscard]] Error cost_overflow(const FactorGraph<V, E>& graph) {
  Result<void> first;
  int index = 0;
  graph.each_edge([&](const auto& edge, const auto& variables, const auto&... x) {
    const auto checked = first ? detail::check_error(edge, x...) : Result<void>{};
    if (!checked)
      first = detail::edge_fault(index, variables, checked.error().code, checked.error().message);
    ++index;
  });
  if (!first) return first.error();
  return {ErrorCode::degenerate, "the sum of the edges' squared errors overflows"};
}

}  // namespace wayfare
