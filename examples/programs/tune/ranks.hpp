#pragma once

// The processes of a search: one, or those of mpirun. All run the same search with the same random
// numbers; each evaluates its share of the individuals.

#include <cstddef>

#include <wayfare/tune/genetic.hpp>

namespace wayfare::examples {

class Ranks {
 public:
  /// Joins the other processes, if there are any.
  Ranks(int* argc, char*** argv);
  ~Ranks();
  Ranks(const Ranks&) = delete;
  Ranks& operator=(const Ranks&) = delete;

  [[nodiscard]] int count() const { return count_; }
  [[nodiscard]] bool first() const { return rank_ == 0; }
  /// Evaluates the share of this process and gathers all scores. Collective.
  [[nodiscard]] BatchFitness share(BatchFitness fitness) const;
  /// Whether it is true on one of the ranks. Collective.
  [[nodiscard]] bool any(bool mine) const;
  /// Ends all ranks after a failure on one of them.
  void abort(int code) const;

 private:
  int rank_ = 0, count_ = 1;
};

}  // namespace wayfare::examples
