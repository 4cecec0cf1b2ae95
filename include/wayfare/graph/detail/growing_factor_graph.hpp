#pragma once

#include <wayfare/graph/growing_factor_graph.hpp>

namespace wayfare {

template <Manifold... V, class... E>
template <class X, class... U>
Result<void> GrowingGraph<FactorGraph<Variables<V...>, Edges<E...>>>::check(
    const X& edge, const std::array<int, sizeof...(U)>& numbers,
    const VariableId<U>&... variables) const {
  const auto fault = [&](ErrorCode code, const std::string& what) {
    const int number =
        graph_.template first_number<X>() + static_cast<int>(graph_.template edges<X>().size());
    return detail::edge_fault(number, numbers, code, what);
  };
  Result<void> known;
  const auto look_up = [&](const auto& variable) {
    if (known && !graph_.contains(variable))
      known = fault(ErrorCode::not_found,
                    "names " + graph_.name(variable.index) + ", which the graph does not have");
  };
  (look_up(variables), ...);
  if (!known) return known;
  if constexpr (detail::kHasInformation<X>) {
    if (auto valid = detail::check_information(edge.information); !valid)
      return fault(valid.error().code, valid.error().message);
  }
  if (auto valid = detail::check_error(edge, value_of(variables)...); !valid)
    return fault(valid.error().code, valid.error().message);
  return {};
}

template <Manifold... V, class... E>
Result<void> GrowingGraph<FactorGraph<Variables<V...>, Edges<E...>>>::hold(int variable) {
  if (is_held(variable)) return {};
  if (index(variable) < solved_.variables)
    return Error{ErrorCode::unsupported, graph_.name(variable) + " was free and is fixed now"};
  is_held_[index(variable)] = 1;
  graph_.fixed_.push_back(variable);
  return {};
}

template <Manifold... V, class... E>
Result<void> GrowingGraph<FactorGraph<Variables<V...>, Edges<E...>>>::append(const Graph& grown) {
  const std::size_t variables = index(graph_.size()), edges = order_.size();
  const std::vector<int> held = graph_.fixed();
  const std::vector<char> is_held = is_held_;
  const auto take_edges = [&]<class X>(std::type_identity<X>) {
    Result<void> taken;
    const auto take = [&](const auto& placed, const auto&... u) { taken = add(placed.edge, u...); };
    for (std::size_t i = graph_.template edges<X>().size();
         taken && i < grown.template edges<X>().size(); ++i)
      with_types(grown.template edges<X>()[i], take, typename X::Variables{});
    return taken;
  };
  const auto take = [&]() -> Result<void> {
    if (index(grown.size()) < variables ||
        ((grown.template edges<E>().size() < graph_.template edges<E>().size()) || ...))
      return Error{ErrorCode::invalid, "the graph has lost variables or edges"};
    Result<void> taken;
    for (int i = graph_.size(); taken && i < grown.size(); ++i)
      with_variable(grown, i, [&](const auto& x) {
        if (auto added = add(x); !added) taken = added.error();
      });
    for (std::size_t i = 0; taken && i < grown.fixed().size(); ++i) taken = hold(grown.fixed()[i]);
    ((taken = taken ? take_edges(std::type_identity<E>{}) : taken), ...);
    return taken;
  };
  auto taken = take();
  if (taken) return taken;
  truncate(variables, edges);
  graph_.fixed_ = held;
  is_held_ = is_held;
  return taken;
}

template <Manifold... V, class... E>
void GrowingGraph<FactorGraph<Variables<V...>, Edges<E...>>>::truncate(std::size_t variables,
                                                                       std::size_t edges) {
  for (; order_.size() > edges; order_.pop_back()) {
    edge_of_.resize(index(order_.back().first_term));
    (void)((order_.back().type == Graph::template edge_type<E>() &&
            (std::get<std::vector<detail::PlacedEdge<E>>>(graph_.edges_).pop_back(), true)) ||
           ...);
  }
  for (; index(graph_.size()) > variables; graph_.variables_.pop_back())
    (void)((graph_.variables_.back().type == Graph::template type_of<V>() &&
            (std::get<std::vector<V>>(graph_.values_).pop_back(), true)) ||
           ...);
  std::erase_if(graph_.fixed_, [&](int variable) { return index(variable) >= variables; });
  is_held_.resize(variables);
}

template <Manifold... V, class... E>
template <class Visit>
bool GrowingGraph<FactorGraph<Variables<V...>, Edges<E...>>>::linearise(
    std::size_t k, const std::vector<Value>& origins, const Visit& visit) const {
  bool finite = true;
  with_edge(k, [&]<class X>(const detail::PlacedEdge<X>& placed, const auto&... u) {
    using Term = IncrementalTerm<kBlock>;
    constexpr std::size_t kCount = sizeof...(u);
    std::array<Term, kTermsOf<X>> terms;  // of the pairs (0, 1), (0, 2) … (1, 2) …
    for (Term& t : terms) {
      for (auto* block : {&t.aa, &t.ab, &t.bb}) block->setZero();
      for (auto* right : {&t.ra, &t.rb}) right->setZero();
    }
    // What belongs to variable i alone is in the first pair that contains it.
    const auto to_gradient = [&](auto i, const auto& part) {
      constexpr int kRows = std::remove_cvref_t<decltype(part)>::RowsAtCompileTime;
      auto& right = i == 0 ? terms[0].ra : terms[i == 0 ? 0 : i - 1].rb;
      right.template head<kRows>() = -part;
      finite = finite && right.allFinite();
    };
    const auto to_hessian = [&](auto i, auto j, const auto& part) {
      constexpr int kRows = std::remove_cvref_t<decltype(part)>::RowsAtCompileTime;
      constexpr int kColumns = std::remove_cvref_t<decltype(part)>::ColsAtCompileTime;
      constexpr std::size_t kPair =
          i == j ? (i == 0 ? 0 : i - 1) : i * kCount - i * (i + 1) / 2 + j - i - 1;
      auto& block = i != j ? terms[kPair].ab : i == 0 ? terms[0].aa : terms[kPair].bb;
      block.template topLeftCorner<kRows, kColumns>() = part;
      finite = finite && block.allFinite();
    };
    detail::edge_blocks(placed.edge, 1.0, true, to_gradient, to_hessian, value_of(u, origins)...);
    int term = order_[k].first_term;
    if constexpr (kCount == 1) {
      visit(term, placed.variables[0], -1, terms[0]);
    } else {
      for (std::size_t i = 0, pair = 0; i < kCount; ++i)
        for (std::size_t j = i + 1; j < kCount; ++j, ++pair, ++term) {
          Term& t = terms[pair];
          const int a = placed.variables[i], b = placed.variables[j];
          if (a == b) {  // one variable twice
            t.aa += t.bb + t.ab + t.ab.transpose();
            t.ra += t.rb;
          }
          visit(term, a, a == b ? -1 : b, t);
        }
    }
  });
  return finite;
}

template <Manifold... V, class... E>
Error GrowingGraph<FactorGraph<Variables<V...>, Edges<E...>>>::fault_at(
    const std::vector<Value>& origins) const {
  for (std::size_t k = 0; k < edges(); ++k) {
    Result<void> valid;
    with_edge(k, [&]<class X>(const detail::PlacedEdge<X>& placed, const auto&... u) {
      valid = detail::check_error(placed.edge, value_of(u, origins)...);
      if (valid) return;
      const int number = graph_.template first_number<X>() + order_[k].number;
      valid =
          detail::edge_fault(number, placed.variables, valid.error().code, valid.error().message);
    });
    if (!valid) return valid.error();
  }
  return {ErrorCode::degenerate, "an edge's product of Jacobians and information overflows"};
}

}  // namespace wayfare
