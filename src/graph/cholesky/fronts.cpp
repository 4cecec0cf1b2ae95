#include "graph/cholesky/symbolic.hpp"

#include <algorithm>
#include <utility>

namespace wayfare::cholesky {
namespace {

/// order[k] = inner[outer[k]]: renumbers by `inner`, then by `outer`.
std::vector<int> chained(std::span<const int> inner, std::span<const int> outer) {
  std::vector<int> order;
  order.reserve(outer.size());
  for (const int i : outer) order.push_back(inner[at(i)]);
  return order;
}

class Planner {
 public:
  Planner(const UpperPattern& pattern, int block) : pattern_(pattern) { plan_.block = block; }

  FrontPlan plan(std::vector<int> order) {
    number_columns(std::move(order));
    make_fronts();
    sort_blocks();
    place_.assign(plan_.order.size(), -1);
    plan_.rows.reserve(2 * pattern_.rows.size());
    plan_.runs.reserve(pattern_.rows.size());
    for (int s = 0; s < static_cast<int>(plan_.fronts.size()); ++s) lay_out(s);
    return std::move(plan_);
  }

 private:
  struct Entry {
    int row, column, block;
  };

  void number_columns(std::vector<int> order);
  void make_fronts();
  void sort_blocks();
  void lay_out(int s);
  void find_rows(int s);
  void place_blocks(Front& front, int s);
  void find_runs(Front& child, const Front& front);

  UpperPattern pattern_;
  FrontPlan plan_;
  Supernodes supernodes_;
  detail::Lists<Entry> entries_;  // H's blocks by front
  std::vector<int> place_;        // of each column, its block row in the current front
};

void Planner::number_columns(std::vector<int> order) {
  {
    const auto parent = elimination_tree(renumbered(pattern_, inverse_order(order)));
    order = chained(order, postorder(parent));
  }
  const ColumnLists above = renumbered(pattern_, inverse_order(order));
  const auto parent = elimination_tree(above);
  supernodes_ = find_supernodes(parent, column_counts(above, parent), plan_.block);
  plan_.order = chained(order, supernodes_.order);
  plan_.number = inverse_order(plan_.order);
}

void Planner::make_fronts() {
  const std::size_t n = supernodes_.parent.size();
  plan_.fronts.resize(n);
  for (std::size_t s = 0; s < n; ++s) {
    Front& f = plan_.fronts[s];
    f.first = supernodes_.first[s];
    f.columns = supernodes_.first[s + 1] - f.first;
    f.parent = supernodes_.parent[s];
  }
  plan_.children = detail::Lists<int>(n, [&](const auto& visit) {
    for (std::size_t s = 0; s < n; ++s)
      if (const int parent = plan_.fronts[s].parent; parent >= 0)
        visit(parent, static_cast<int>(s));
  });
}

void Planner::sort_blocks() {
  std::vector<int> front_of(plan_.order.size());
  for (std::size_t s = 0; s < plan_.fronts.size(); ++s)
    for (int k = 0; k < plan_.fronts[s].columns; ++k)
      front_of[at(plan_.fronts[s].first + k)] = static_cast<int>(s);
  entries_ = detail::Lists<Entry>(plan_.fronts.size(), [&](const auto& visit) {
    for (int c = 0; c < pattern_.columns(); ++c) {
      for (int k = pattern_.starts[at(c)]; k < pattern_.starts[at(c) + 1]; ++k) {
        const int a = plan_.number[at(pattern_.rows[at(k)])], b = plan_.number[at(c)];
        const int column = std::min(a, b);
        visit(front_of[at(column)], Entry{std::max(a, b), column, a > b ? k : -1 - k});
      }
    }
  });
  plan_.placements.reserve(pattern_.rows.size());
}

void Planner::lay_out(int s) {
  find_rows(s);
  Front& front = plan_.fronts[at(s)];
  for (int k = 0; k < front.columns; ++k) place_[at(front.first + k)] = k;
  int next = front.columns;
  for (const int r : plan_.rows_of(front)) place_[at(r)] = next++;
  place_blocks(front, s);
  for (const int child : plan_.children[s]) find_runs(plan_.fronts[at(child)], front);
}

// place_ marks rows already found by −2 − s, which is not a block row.
void Planner::find_rows(int s) {
  Front& front = plan_.fronts[at(s)];
  const int end = front.first + front.columns, mark = -2 - s;
  front.rows_begin = static_cast<int>(plan_.rows.size());
  const auto take = [&](int r) {
    if (r < end || place_[at(r)] == mark) return;
    place_[at(r)] = mark;
    plan_.rows.push_back(r);
  };
  for (const Entry& e : entries_[s]) take(e.row);
  for (const int c : plan_.children[s]) {
    const Front& child = plan_.fronts[at(c)];
    for (int i = 0; i < child.rows; ++i) take(plan_.rows[at(child.rows_begin + i)]);
  }
  std::sort(plan_.rows.begin() + front.rows_begin, plan_.rows.end());
  front.rows = static_cast<int>(plan_.rows.size()) - front.rows_begin;
}

void Planner::place_blocks(Front& front, int s) {
  front.placements_begin = static_cast<int>(plan_.placements.size());
  for (const Entry& e : entries_[s]) {
    const bool transposed = e.block < 0;
    const int row = place_[at(e.row)], column = e.column - front.first;
    const bool below = row >= front.columns;
    plan_.placements.push_back({transposed ? -1 - e.block : e.block,
                                below ? row - front.columns : row, column, transposed, below});
  }
  front.placements_end = static_cast<int>(plan_.placements.size());
}

/// Rows of the child that are also contiguous in the front are added in one run.
void Planner::find_runs(Front& child, const Front& front) {
  child.runs_begin = static_cast<int>(plan_.runs.size());
  const auto rows = plan_.rows_of(child);
  const auto pivots = std::lower_bound(rows.begin(), rows.end(), front.first + front.columns);
  int before = -2;
  for (auto row = rows.begin(); row != rows.end(); ++row) {
    const int to = place_[at(*row)] - (row < pivots ? 0 : front.columns);
    if (row != pivots && to == before + 1) {
      ++plan_.runs.back().length;
    } else {
      plan_.runs.push_back({static_cast<int>(row - rows.begin()), to, 1});
      if (row < pivots) ++child.pivot_runs;
    }
    before = to;
  }
  child.runs = static_cast<int>(plan_.runs.size()) - child.runs_begin;
}

}  // namespace

FrontPlan plan_fronts(const UpperPattern& pattern, std::vector<int> order, int block) {
  return Planner(pattern, block).plan(std::move(order));
}

}  // namespace wayfare::cholesky
