#pragma once

// Sparse Cholesky H = L Lᵀ on fixed-size blocks. Column by column, looking left: block column j is
// H's minus what each earlier column k with a block L(j,k) contributes, L(i,j) −= L(i,k) L(j,k)ᵀ.
// Every operation is a dense product of N×N blocks whose size the compiler knows; the pattern is
// found once on the graph of blocks, N² times smaller than that of scalars. (Davis, "Direct methods
// for sparse linear systems", chapter 4, with blocks for scalars.)

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include <wayfare/graph/linear_solver.hpp>

namespace wayfare {

/// LinearSolver of our own, with Eigen's dense blocks only. Allocates in `analyse` alone.
template <int N>
class BlockCholesky {
 public:
  static constexpr int kBlock = N;

  void analyse(const BlockSparse<N>& h) {
    order_ = minimum_degree_order(h);
    find_pattern(h);
    find_sources(h);
    values_.resize(rows_.size());
    diagonal_.resize(order_.size());
    slot_of_row_.assign(order_.size(), -1);
    permuted_.resize(static_cast<Eigen::Index>(order_.size()) * N);
  }

  FactorOutcome factorise(const BlockSparse<N>& h) {
    load(h);
    for (int j = 0; j < columns(); ++j) {
      subtract_earlier(j);
      const Eigen::LLT<Block> llt(diagonal_[index(j)]);
      if (llt.info() != Eigen::Success) return {false, original(j)};
      diagonal_[index(j)] = llt.matrixL();
      const auto lower = diagonal_[index(j)].template triangularView<Eigen::Lower>();
      for (int s = starts_[index(j)]; s < starts_[index(j) + 1]; ++s) {
        Block& l = values_[index(s)];
        l = lower.solve(l.transpose().eval()).transpose().eval();
      }
    }
    return {};
  }

  void solve_in_place(Eigen::VectorXd& x) {
    for (int i = 0; i < columns(); ++i) segment(permuted_, order_[index(i)]) = segment(x, i);
    for (int j = 0; j < columns(); ++j) {
      auto y = segment(permuted_, j);
      diagonal_[index(j)].template triangularView<Eigen::Lower>().solveInPlace(y);
      for (int s = starts_[index(j)]; s < starts_[index(j) + 1]; ++s)
        segment(permuted_, rows_[index(s)]).noalias() -= values_[index(s)] * y;
    }
    for (int j = columns() - 1; j >= 0; --j) {
      auto y = segment(permuted_, j);
      for (int s = starts_[index(j)]; s < starts_[index(j) + 1]; ++s)
        y.noalias() -= values_[index(s)].transpose() * segment(permuted_, rows_[index(s)]);
      diagonal_[index(j)].template triangularView<Eigen::Lower>().transpose().solveInPlace(y);
    }
    for (int i = 0; i < columns(); ++i) segment(x, i) = segment(permuted_, order_[index(i)]);
  }

 private:
  using Block = Eigen::Matrix<double, N, N>;

  /// Block (j, column) of L: it and the blocks below it in that column change column j.
  struct RowEntry {
    int column;
    int slot;
  };
  /// Where a block of H goes: a slot of values_, or −1 − j for diagonal block j.
  struct Source {
    int slot;
    bool transposed;
  };

  static std::size_t index(int i) { return static_cast<std::size_t>(i); }
  static auto segment(Eigen::VectorXd& x, int i) {
    return x.template segment<N>(static_cast<Eigen::Index>(i) * N);
  }
  [[nodiscard]] int columns() const { return static_cast<int>(order_.size()); }
  [[nodiscard]] int original(int j) const {
    return static_cast<int>(std::find(order_.begin(), order_.end(), j) - order_.begin());
  }

  /// Row j of L has a block wherever the elimination tree leads from a block of H in row j up to j.
  void find_pattern(const BlockSparse<N>& h) {
    const std::vector<std::vector<int>> upper = permuted_upper(h);
    const std::size_t n = order_.size();
    std::vector<int> parent(n, -1), seen_in_row(n, -1);
    std::vector<std::vector<int>> rows_of_column(n);
    row_starts_.assign(1, 0);
    row_entries_.clear();
    for (int j = 0; j < columns(); ++j) {
      seen_in_row[index(j)] = j;
      for (int k : upper[index(j)]) {
        for (; seen_in_row[index(k)] != j; k = parent[index(k)]) {
          seen_in_row[index(k)] = j;
          row_entries_.push_back({k, static_cast<int>(rows_of_column[index(k)].size())});
          rows_of_column[index(k)].push_back(j);
          if (parent[index(k)] < 0) parent[index(k)] = j;
        }
      }
      row_starts_.push_back(static_cast<int>(row_entries_.size()));
    }
    starts_.assign(1, 0);
    rows_.clear();
    for (const auto& rows : rows_of_column) {
      rows_.insert(rows_.end(), rows.begin(), rows.end());
      starts_.push_back(static_cast<int>(rows_.size()));
    }
    for (RowEntry& e : row_entries_) e.slot += starts_[index(e.column)];
  }

  /// For each column of the reordered H, the rows above the diagonal.
  std::vector<std::vector<int>> permuted_upper(const BlockSparse<N>& h) const {
    std::vector<std::vector<int>> upper(order_.size());
    for (int c = 0; c < h.columns(); ++c) {
      for (int b = h.starts()[index(c)]; b + 1 < h.starts()[index(c) + 1]; ++b) {
        const int i = order_[index(h.rows()[index(b)])], j = order_[index(c)];
        upper[index(std::max(i, j))].push_back(std::min(i, j));
      }
    }
    return upper;
  }

  void find_sources(const BlockSparse<N>& h) {
    sources_.clear();
    for (int c = 0; c < h.columns(); ++c) {
      for (int b = h.starts()[index(c)]; b < h.starts()[index(c) + 1]; ++b) {
        const int i = order_[index(h.rows()[index(b)])], j = order_[index(c)];
        if (i == j) {
          sources_.push_back({-1 - j, false});
          continue;
        }
        const auto first = rows_.begin() + starts_[index(std::min(i, j))];
        const auto last = rows_.begin() + starts_[index(std::min(i, j)) + 1];
        const auto at = std::lower_bound(first, last, std::max(i, j));
        sources_.push_back({static_cast<int>(at - rows_.begin()), i < j});
      }
    }
  }

  void load(const BlockSparse<N>& h) {
    for (Block& v : values_) v.setZero();
    for (int b = 0; b < h.blocks(); ++b) {
      const auto [slot, transposed] = sources_[index(b)];
      if (slot < 0) {
        diagonal_[index(-1 - slot)] = h.block(b).template selfadjointView<Eigen::Upper>();
      } else if (transposed) {
        values_[index(slot)] = h.block(b).transpose();
      } else {
        values_[index(slot)] = h.block(b);
      }
    }
  }

  void subtract_earlier(int j) {
    for (int s = starts_[index(j)]; s < starts_[index(j) + 1]; ++s)
      slot_of_row_[index(rows_[index(s)])] = s;
    for (int e = row_starts_[index(j)]; e < row_starts_[index(j) + 1]; ++e) {
      const auto [column, slot] = row_entries_[index(e)];
      const Block across = values_[index(slot)].transpose();
      diagonal_[index(j)].noalias() -= values_[index(slot)] * across;
      for (int s = slot + 1; s < starts_[index(column) + 1]; ++s)
        values_[index(slot_of_row_[index(rows_[index(s)])])].noalias() -=
            values_[index(s)] * across;
    }
  }

  std::vector<int> order_;          // of each original column, its place in the elimination
  std::vector<int> starts_, rows_;  // L below the diagonal, column by column, rows ascending
  std::vector<int> row_starts_;     // … and row by row
  std::vector<RowEntry> row_entries_;
  std::vector<Source> sources_;  // one a block of H
  std::vector<Block> values_, diagonal_;
  std::vector<int> slot_of_row_;  // of the column at work
  Eigen::VectorXd permuted_;
};

static_assert(LinearSolver<BlockCholesky<3>> && LinearSolver<BlockCholesky<6>>);

}  // namespace wayfare
