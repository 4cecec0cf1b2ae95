#pragma once

// How variables and edges are added to the incremental optimiser of a factor graph
// (IncrementalGraphOptimiser in incremental.hpp).

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/contract.hpp>
#include <wayfare/core/manifold.hpp>
#include <wayfare/core/result.hpp>
#include <wayfare/graph/detail/edge_blocks.hpp>
#include <wayfare/graph/detail/factor_equations.hpp>
#include <wayfare/graph/edge.hpp>

namespace wayfare {

template <Manifold... V>
struct Variables {};
template <class... E>
struct Edges {};
template <class AllVariables, class AllEdges>
class FactorGraph;
template <class Graph>
class GrowingGraph;
template <int N>
struct IncrementalTerm;

namespace detail {

/// An edge and the numbers of its variables.
template <class E>
struct PlacedEdge {
  E edge;
  std::array<int, E::Variables::kCount> variables;
};

template <class X, class... All>
inline constexpr bool kIsOneOf = (std::is_same_v<X, All> || ...);
template <class E, class... V>
inline constexpr bool kJoinsTheseVariables =
    std::is_same_v<EdgeVariables<V...>, typename E::Variables>;

}  // namespace detail

/// How variables and edges of any types are added.
template <Manifold... V, class... E>
class GrowingGraph<FactorGraph<Variables<V...>, Edges<E...>>> {
 public:
  using Graph = FactorGraph<Variables<V...>, Edges<E...>>;  ///< solved and pending

  /// Added with the next update. `held`: fixed. An Error if it is not finite.
  template <class X>
  Result<VariableId<X>> add(const X& initial,
                            bool held = false) requires detail::kIsOneOf<X, V...> {
    if (!ManifoldTraits<X>::minus(initial, initial).allFinite())
      return Error{ErrorCode::invalid, graph_.name(graph_.size()) + " is not finite"};
    const VariableId<X> added = graph_.add(initial);
    is_held_.push_back(held);
    if (held) graph_.fix(added);
    return added;
  }

  /// Added with the next update. Errors, with nothing added: a variable that the graph does not
  /// have, an information that is not positive semi-definite, an error or a Jacobian that is not
  /// finite at the current values. The message counts edges as graph() does, type by type.
  template <class X, class... U>
  Result<void> add(const X& edge, const VariableId<U>&... variables) requires(
      detail::kIsOneOf<X, E...>&& detail::kJoinsTheseVariables<X, U...>) {
    const std::array<int, sizeof...(U)> numbers{variables.index...};
    if (auto valid = check(edge, numbers, variables...); !valid) return valid;
    const int first = static_cast<int>(edge_of_.size());
    edge_of_.resize(edge_of_.size() + kTermsOf<X>, static_cast<int>(order_.size()));
    order_.push_back({Graph::template edge_type<X>(),
                      static_cast<int>(graph_.template edges<X>().size()), first});
    graph_.add(edge, variables...);
    return {};
  }

  /// A pending variable keeps its value. An Error if it was solved as a free one.
  template <class X>
  Result<void> fix(const VariableId<X>& variable) {
    if (!graph_.contains(variable))
      return Error{ErrorCode::not_found,
                   "fixed " + graph_.name(variable.index) + " is not in the graph"};
    return hold(variable.index);
  }

  /// Adds the variables and edges of `grown` that graph() does not have, those of each type after
  /// as many of the same type as it has; the common ones are assumed to be identical, except that
  /// pending ones may be fixed now. Errors, with nothing added: those of `add` and `fix`.
  Result<void> append(const Graph& grown);
  /// Removes the variables and edges added since the last successful update.
  void discard_pending() { truncate(solved_.variables, solved_.edges); }

  /// Solved variables as estimated; pending ones at their initial values.
  [[nodiscard]] const Graph& graph() const { return graph_; }
  /// Of a variable, pending or solved.
  template <class X>
  [[nodiscard]] const X& operator[](const VariableId<X>& variable) const {
    return graph_[variable];
  }

 protected:
  static constexpr int kBlock = Graph::kBlock;    ///< numbers of a step of one variable
  using Value = std::variant<V...>;               ///< of a variable of any type
  using Step = Eigen::Matrix<double, kBlock, 1>;  ///< of a variable

  /// What is not pending.
  struct Solved {
    std::size_t variables = 0,  ///< numbers of variables
        edges = 0;              ///< numbers of edges
  };

  /// For containers.
  static std::size_t index(int i) { return static_cast<std::size_t>(i); }
  /// Numbers of what is solved.
  [[nodiscard]] Solved solved() const { return solved_; }
  /// Nothing is pending any more.
  void settle() { solved_ = {index(graph_.size()), edges()}; }
  /// What came after `before` is pending again.
  void unsettle(const Solved& before) { solved_ = before; }
  /// Whether the variable keeps its value.
  [[nodiscard]] bool is_held(int variable) const { return is_held_[index(variable)] != 0; }
  /// Error (degenerate): nothing to solve.
  [[nodiscard]] Result<void> check_pending() const {
    if (graph_.size() > 0) return {};
    return Error{ErrorCode::degenerate, "the graph has no variables"};
  }

  /// Edges have their own kernels.
  [[nodiscard]] static RobustKernel kernel() { return {}; }
  /// Of a variable of any type.
  [[nodiscard]] Value value(int variable) const {
    std::optional<Value> x;
    with_variable(graph_, variable, [&](const auto& at) { x = at; });
    return *x;
  }
  /// The type of `value` is that of the variable.
  static void set_value(Graph& graph, int variable, const Value& value) {
    with_variable(graph, variable, [&]<class X>(X& at) { at = std::get<X>(value); });
  }
  /// The variable becomes origin ⊞ step.
  void place(int variable, const Value& origin, const Step& step) {
    with_variable(graph_, variable, [&]<class X>(X& at) {
      at = ManifoldTraits<X>::plus(std::get<X>(origin),
                                   step.template head<ManifoldTraits<X>::kDof>());
    });
  }

  /// Edges are in the order they were added here.
  [[nodiscard]] std::size_t edges() const { return order_.size(); }
  /// Number of the edge of a term; the edges' terms are numbered one after the other.
  [[nodiscard]] std::size_t edge_of(int term) const { return index(edge_of_[index(term)]); }
  /// ρ(eᵀΩe) of edge k at the current values.
  [[nodiscard]] double cost_of(std::size_t k) const {
    double cost = 0.0;
    with_edge(k, [&](const auto& placed, const auto&... u) {
      cost = robust_value(placed.edge, squared_error(placed.edge, value_of(u)...)).cost;
    });
    return cost;
  }
  /// visit(term, its variables, its values), linearised at `origins`. Returns whether values are
  /// finite.
  template <class Visit>
  bool linearise(std::size_t k, const std::vector<Value>& origins, const Visit& visit) const;
  /// Names the edge for which `linearise` returned false.
  [[nodiscard]] Error fault_at(const std::vector<Value>& origins) const;

  Graph graph_;  ///< including pending; values as estimated

 private:
  /// An edge: its type, its number among those of the type, its first term.
  struct Ordered {
    int type, number, first_term;
  };
  /// One for each pair of variables.
  template <class X>
  static constexpr std::size_t kTermsOf =
      std::max<std::size_t>(1, X::Variables::kCount*(X::Variables::kCount - 1) / 2);

  template <class X, class... U>
  Result<void> check(const X& edge, const std::array<int, sizeof...(U)>& numbers,
                     const VariableId<U>&... variables) const;
  Result<void> hold(int variable);
  void truncate(std::size_t variables, std::size_t edges);

  template <class SomeGraph, class Visit>
  static void with_variable(SomeGraph& graph, int variable, const Visit& visit) {
    const auto [type, number] = graph.place(variable);
    const auto of_type = [&, t = type, n = number]<class X>(std::type_identity<X>) {
      if (t != Graph::template type_of<X>()) return false;
      visit(std::get<std::vector<X>>(graph.values_)[n]);
      return true;
    };
    (void)(of_type(std::type_identity<V>{}) || ...);
  }
  template <class X>
  [[nodiscard]] const X& value_of(const VariableId<X>& u) const {
    return graph_.template all<X>()[graph_.place(u.index).index];
  }
  template <class X>
  static const X& value_of(const VariableId<X>& u, const std::vector<Value>& values) {
    return std::get<X>(values[index(u.index)]);
  }

  /// visit(edge k with the numbers of its variables, these numbers with their types...).
  template <class Visit>
  void with_edge(std::size_t k, const Visit& visit) const {
    const auto of_type = [&]<class X>(std::type_identity<X>) {
      if (order_[k].type != Graph::template edge_type<X>()) return false;
      const auto& placed = graph_.template edges<X>()[index(order_[k].number)];
      with_types(placed, visit, typename X::Variables{});
      return true;
    };
    (void)(of_type(std::type_identity<E>{}) || ...);
  }
  template <class X, class Visit, class... U>
  static void with_types(const detail::PlacedEdge<X>& placed, const Visit& visit,
                         EdgeVariables<U...>) {
    [&]<std::size_t... I>(std::index_sequence<I...>) {
      visit(placed, VariableId<U>{placed.variables[I]}...);
    }
    (std::index_sequence_for<U...>{});
  }

  std::vector<Ordered> order_;  // of all edges
  std::vector<int> edge_of_;    // of each term
  std::vector<char> is_held_;
  Solved solved_;
};

}  // namespace wayfare

#include <wayfare/graph/detail/growing_factor_graph.hpp>
