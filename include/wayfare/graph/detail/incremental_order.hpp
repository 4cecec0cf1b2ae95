#pragma once

// Elimination order of the affected part of a sparse system. The unaffected subtrees appear as
// cliques of the variables they couple.

#include <span>
#include <vector>

namespace wayfare {

/// Approximate minimum degree on a quotient graph (Amestoy, Davis, Duff 1996, without
/// supervariables) that can start from cliques and can order chosen nodes last (constrained as in
/// Davis, Gilbert, Larimore, Ng 2004): recently changed variables are likely to change again, which
/// affects fewer cliques the later they are eliminated. Reuses its memory.
class IncrementalOrder {
 public:
  /// Starts a new graph of `nodes` nodes without edges.
  void start(int nodes);
  /// Two different nodes are coupled; repeats are allowed.
  void join(int a, int b);
  /// All of `nodes`, different from each other, are coupled.
  void join_all(std::span<const int> nodes);
  /// Orders the node after all others; such nodes are in ascending order.
  void keep_last(int node) { at(is_last_, node) = 1; }

  /// The elimination order. Ends what `start` began.
  [[nodiscard]] const std::vector<int>& find();

 private:
  template <class T>
  static T& at(std::vector<T>& v, int i) {
    return v[static_cast<std::size_t>(i)];
  }

  void find_first_degrees();
  int take_least();
  void gather_pivot(int pivot);
  void count_outside();
  void update_neighbour(int node, int pivot);
  void list(int node, int degree);
  void unlist(int node);
  void append_rest();

  int nodes_ = 0, remaining_ = 0, least_ = 0, stamp_ = 0;
  std::vector<std::vector<int>> neighbours_;  // of each node, those joined to it by `join`
  std::vector<std::vector<int>> elements_of_;
  std::vector<std::vector<int>> elements_;  // an eliminated node's, then those of join_all
  std::vector<char> is_last_, eliminated_, absorbed_;
  std::vector<int> degree_, first_, next_, previous_;  // lists of nodes by degree
  std::vector<int> seen_, outside_, counted_;
  std::vector<int> clique_;  // nodes coupled by the current pivot
  std::vector<int> order_;
  int extra_elements_ = 0;
};

}  // namespace wayfare
