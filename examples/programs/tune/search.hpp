#pragma once

// Genetic searches that can be watched, stopped and resumed.

#include <atomic>
#include <functional>
#include <string>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/tune/genetic.hpp>
#include <wayfare/tune/ins_fitness.hpp>

namespace wayfare::examples {

/// The mean of each individual's scores over the drives.
class DrivesFitness {
 public:
  explicit DrivesFitness(std::vector<InsFitness> drives) : drives_(std::move(drives)) {}
  void operator()(std::span<const double> individuals, std::span<double> scores) const;
  /// Called with the share of the generation that is evaluated.
  std::function<void(double)> progress;

 private:
  std::vector<InsFitness> drives_;
};

struct SearchPlan {
  std::string folder;
  std::size_t runs = 1;
  bool resume = false;
  bool writes = true;  ///< checkpoints; true in one process only
};

struct SearchHooks {
  /// Whether to stop after the current generation.
  std::function<bool()> stop;
  /// Called after each generation with the index of the run and its state.
  std::function<void(std::size_t, const GeneticState&)> after_generation;
};

struct SearchResult {
  std::vector<GeneticState> runs;
  std::vector<GeneticSearch> searches;  ///< of the runs
  bool complete = true;                 ///< false if stopped on request
  [[nodiscard]] std::size_t best() const;
};

[[nodiscard]] std::string checkpoint_name(std::size_t run);

/// Run k has the seed options.seed + k. Each state is on disk before the next generation begins.
/// With `resume` a run continues from its checkpoint, if it exists; an error if that is of another
/// search or other drives.
[[nodiscard]] Result<SearchResult> search(const SearchPlan& plan, const std::vector<Gene>& genes,
                                          const GeneticOptions& options,
                                          const BatchFitness& fitness, const SearchHooks& hooks);

}  // namespace wayfare::examples
