#pragma once

// Genetic runs that a person can watch, stop and take up again.

#include <atomic>
#include <functional>
#include <string>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/tune/genetic.hpp>
#include <wayfare/tune/ins_fitness.hpp>

namespace wayfare::examples {

/// The mean over drives of each individual's score.
class DrivesFitness {
 public:
  explicit DrivesFitness(std::vector<InsFitness> drives) : drives_(std::move(drives)) {}
  void operator()(std::span<const double> individuals, std::span<double> scores) const;
  /// Called with the share of a generation that is judged.
  std::function<void(double)> progress;

 private:
  std::vector<InsFitness> drives_;
};

struct SearchPlan {
  std::string folder;
  std::size_t runs = 1;
  bool resume = false;
  bool writes = true;  ///< checkpoints: one process of many
};

struct SearchHooks {
  /// Whether to end after the generation that is running.
  std::function<bool()> stop;
  /// After each generation: which run, and its state.
  std::function<void(std::size_t, const GeneticState&)> told;
};

struct SearchResult {
  std::vector<GeneticState> runs;
  std::vector<GeneticSearch> searches;  ///< beside them
  bool complete = true;                 ///< else stopped on request
  [[nodiscard]] std::size_t best() const;
};

[[nodiscard]] std::string checkpoint_name(std::size_t run);

/// Run k draws from seed + k. Each state is on the disk before the next generation begins. With
/// `resume` a run goes on from its checkpoint where there is one; an error where that is of another
/// search or other drives.
[[nodiscard]] Result<SearchResult> search(const SearchPlan& plan, const std::vector<Gene>& genes,
                                          const GeneticOptions& options,
                                          const BatchFitness& fitness,
                                          std::span<const double> nominal,
                                          const SearchHooks& hooks);

}  // namespace wayfare::examples
