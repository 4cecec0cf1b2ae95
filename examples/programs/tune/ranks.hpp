#pragma once

// The processes that tune together: one, or those that mpirun started. All of them run the same
// search and draw the same numbers; each judges its share of the individuals.

#include <cstddef>

#include <wayfare/tune/genetic.hpp>

namespace wayfare::examples {

class Ranks {
 public:
  /// Joins the others, if there are any.
  Ranks(int* argc, char*** argv);
  ~Ranks();
  Ranks(const Ranks&) = delete;
  Ranks& operator=(const Ranks&) = delete;

  [[nodiscard]] int rank() const { return rank_; }
  [[nodiscard]] int count() const { return count_; }
  [[nodiscard]] bool first() const { return rank_ == 0; }
  /// Judges the share of this process and gathers all scores. Needs all ranks.
  [[nodiscard]] BatchFitness share(BatchFitness fitness) const;
  /// Whether one of the ranks says so. Needs all ranks.
  [[nodiscard]] bool any(bool mine) const;
  /// Ends all ranks, where one of them failed alone.
  void abort(int code) const;

 private:
  int rank_ = 0, count_ = 1;
};

}  // namespace wayfare::examples
