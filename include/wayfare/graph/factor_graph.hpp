#pragma once

// A factor graph: variables of any manifold types, and edges of any types between them.
//
//   FactorGraph<Variables<SE2d, Eigen::Vector2d>, Edges<Between<SE2d>, RangeToBeacon>> graph;
//   const auto start = graph.add(SE2d());
//   const auto beacon = graph.add(Eigen::Vector2d(3, 1));
//   graph.fix(start);
//   graph.add(RangeToBeacon{2.9, 0.1}, start, beacon);
//   optimise(graph);

#include <algorithm>
#include <array>
#include <cstddef>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/contract.hpp>
#include <wayfare/core/manifold.hpp>
#include <wayfare/graph/detail/factor_equations.hpp>
#include <wayfare/graph/edge.hpp>
#include <wayfare/graph/growing_factor_graph.hpp>

namespace wayfare {

namespace detail {

/// The size of the solver's blocks: of the largest variable, and one of those it is compiled for.
/// A smaller variable fills the first rows of its block.
template <Manifold... V>
constexpr int block_size() {
  constexpr int largest = std::max({ManifoldTraits<V>::kDof...});
  static_assert(largest <= 6,
                "wayfare: a variable has up to 6 degrees of freedom; make several of a larger one");
  return largest <= 2 ? 2 : largest <= 3 ? 3 : 6;
}

template <class... V, class... U>
constexpr bool has_all(Variables<V...>, EdgeVariables<U...>) {
  return (kIsOneOf<U, V...> && ...);
}

}  // namespace detail

/// A plain value. Variables are numbered in the order they are added; edges keep their order among
/// those of the same type.
template <Manifold... V, class... E>
class FactorGraph<Variables<V...>, Edges<E...>> {
  static_assert((detail::check_edge<E>() && ...));
  static_assert((detail::has_all(Variables<V...>{}, typename E::Variables{}) && ...),
                "wayfare: the types of an edge's variables are among those of its graph");

 public:
  /// Numbers of a step of one variable: the largest dof.
  static constexpr int kBlock = detail::block_size<V...>();
  using Values = std::tuple<std::vector<V>...>;  ///< one list for each type of variable
  using Pose = void;                             ///< variables differ: there are no relative poses

  /// Returns what names the variable.
  template <class X>
  VariableId<X> add(const X& initial) requires detail::kIsOneOf<X, V...> {
    auto& values = std::get<std::vector<X>>(values_);
    variables_.push_back({type_of<X>(), values.size()});
    values.push_back(initial);
    return {size() - 1};
  }

  /// Between variables that are in the graph.
  template <class X, class... U>
  void add(const X& edge, const VariableId<U>&... variables) requires(
      detail::kIsOneOf<X, E...>&& detail::kJoinsTheseVariables<X, U...>) {
    WAYFARE_EXPECTS((contains(variables) && ...), "an edge joins variables of its graph");
    std::get<std::vector<detail::PlacedEdge<X>>>(edges_).push_back({edge, {variables.index...}});
  }

  /// Its value stays as it is.
  template <class X>
  void fix(const VariableId<X>& variable) {
    WAYFARE_EXPECTS(contains(variable), "a fixed variable is one of its graph");
    fixed_.push_back(variable.index);
  }

  /// Value of a variable.
  template <class X>
  [[nodiscard]] const X& operator[](const VariableId<X>& variable) const {
    return all<X>()[checked(variable)];
  }
  /// Value of a variable, to change it.
  template <class X>
  [[nodiscard]] X& operator[](const VariableId<X>& variable) {
    return std::get<std::vector<X>>(values_)[checked(variable)];
  }
  /// Of one type, in the order they were added.
  template <class X>
  [[nodiscard]] const std::vector<X>& all() const {
    return std::get<std::vector<X>>(values_);
  }
  /// Of one type, in the order they were added.
  template <class X>
  [[nodiscard]] const std::vector<detail::PlacedEdge<X>>& edges() const {
    return std::get<std::vector<detail::PlacedEdge<X>>>(edges_);
  }

  /// Number of variables.
  [[nodiscard]] int size() const { return static_cast<int>(variables_.size()); }
  /// Number of edges of all types.
  [[nodiscard]] int edge_count() const {
    return static_cast<int>((edges<E>().size() + ... + std::size_t{0}));
  }
  /// Numbers of the variables that keep their value.
  [[nodiscard]] const std::vector<int>& fixed() const { return fixed_; }
  /// Degrees of freedom of a variable.
  [[nodiscard]] int dof(int variable) const {
    constexpr int kDofs[] = {ManifoldTraits<V>::kDof...};
    return kDofs[place(variable).type];
  }
  /// What messages call a variable.
  [[nodiscard]] std::string name(int variable) const {
    return "variable " + std::to_string(variable);
  }

  /// All values, type by type.
  [[nodiscard]] const Values& values() const { return values_; }
  /// Replaces all values; as many of each type as before.
  void set_values(const Values& values) { values_ = values; }

  /// Moves a variable by the first numbers of `step`.
  template <class Step>
  void move(int variable, const Step& step) {
    const Place& p = place(variable);
    const auto move_one = [&]<class X>(std::vector<X>& values) {
      values[p.index] =
          ManifoldTraits<X>::plus(values[p.index], step.template head<ManifoldTraits<X>::kDof>());
      return true;
    };
    (void)((p.type == type_of<V>() && move_one(std::get<std::vector<V>>(values_))) || ...);
  }

  /// visit(edge, the numbers of its variables, their values...) for every edge, type by type.
  template <class Visit>
  void each_edge(const Visit& with) const {
    (each_edge_of<E>(with), ...);
  }

 private:
  friend class GrowingGraph<FactorGraph>;

  /// Which of the types, and the index among its values.
  struct Place {
    int type;
    std::size_t index;
  };

  template <class X>
  static constexpr int type_of() {
    int type = -1, i = 0;
    ((std::is_same_v<X, V> ? type = i++ : i++), ...);
    return type;
  }
  template <class X>
  static constexpr int edge_type() {
    int type = -1, i = 0;
    ((std::is_same_v<X, E> ? type = i++ : i++), ...);
    return type;
  }
  /// The number of the first edge of type X among all edges.
  template <class X>
  [[nodiscard]] int first_number() const {
    std::size_t before = 0;
    ((edge_type<E>() < edge_type<X>() ? before += edges<E>().size() : before), ...);
    return static_cast<int>(before);
  }
  [[nodiscard]] const Place& place(int variable) const {
    return variables_[static_cast<std::size_t>(variable)];
  }
  template <class X>
  [[nodiscard]] bool contains(const VariableId<X>& v) const {
    return v.index >= 0 && v.index < size() && place(v.index).type == type_of<X>();
  }
  template <class X>
  [[nodiscard]] std::size_t checked(const VariableId<X>& variable) const {
    WAYFARE_EXPECTS(contains(variable), "the variable is one of this graph");
    return place(variable.index).index;
  }

  template <class X, class Visit>
  void each_edge_of(const Visit& with) const {
    for (const auto& placed : edges<X>()) with_values(placed, with, typename X::Variables{});
  }
  template <class X, class Visit, class... U>
  void with_values(const detail::PlacedEdge<X>& placed, const Visit& with,
                   EdgeVariables<U...>) const {
    [&]<std::size_t... I>(std::index_sequence<I...>) {
      with(placed.edge, placed.variables, all<U>()[place(placed.variables[I]).index]...);
    }
    (std::index_sequence_for<U...>{});
  }

  std::vector<Place> variables_;
  Values values_;
  std::tuple<std::vector<detail::PlacedEdge<E>>...> edges_;
  std::vector<int> fixed_;
};

/// Initial values along relative poses, which a factor graph need not have: compile errors.
template <class V, class E>
void start_from_odometry(FactorGraph<V, E>&) {
  static_assert(!std::is_same_v<V, V>, "wayfare: a start along odometry takes pose graphs only");
}
/// As start_from_odometry.
template <class V, class E>
void start_from_tree(FactorGraph<V, E>&) {
  static_assert(!std::is_same_v<V, V>, "wayfare: a spanning tree's start takes pose graphs only");
}
/// As start_from_odometry.
template <class V, class E>
void start_from_chordal(FactorGraph<V, E>&) {
  static_assert(
      !std::is_same_v<V, V>,
      "wayfare: the chordal start relaxes rotations between poses: it takes pose graphs only");
}

}  // namespace wayfare
