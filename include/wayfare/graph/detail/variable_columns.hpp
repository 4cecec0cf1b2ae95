#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace wayfare {

/// A variable of type V: its number among all variables of its graph.
template <class V>
struct VariableId {
  int index = -1;
  bool operator==(const VariableId&) const = default;
};

/// The block column of each free variable of a graph.
class VariableColumns {
 public:
  void number(int variables, std::span<const int> fixed) {
    columns_.assign(static_cast<std::size_t>(variables), 0);
    for (const int variable : fixed) columns_[static_cast<std::size_t>(variable)] = -1;
    free_.clear();
    for (int variable = 0; variable < variables; ++variable) {
      int& column = columns_[static_cast<std::size_t>(variable)];
      if (column < 0) continue;
      column = static_cast<int>(free_.size());
      free_.push_back(variable);
    }
  }

  /// Of all variables.
  [[nodiscard]] int size() const { return static_cast<int>(columns_.size()); }
  /// The free variables in the order of their columns.
  [[nodiscard]] const std::vector<int>& free() const { return free_; }
  /// The column of a variable, −1 if it is fixed.
  [[nodiscard]] int of(int variable) const { return columns_[static_cast<std::size_t>(variable)]; }

 private:
  std::vector<int> columns_, free_;
};

}  // namespace wayfare
