#pragma once

// A genetic algorithm for real numbers within bounds (Goldberg 1989): selection by rank, two-point
// crossover, small mutations, elitism. Individuals are judged many at a time, so that a fitness can
// work on all of them at once and on as many threads as it likes.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <wayfare/core/result.hpp>

namespace wayfare {

/// One number to be found.
struct Gene {
  std::string name;
  double low = 0.0, high = 1.0;
  /// Evenly spread over its logarithm (`low` > 0), for quantities known to decades only.
  bool logarithmic = false;

  [[nodiscard]] double value(double unit) const;  ///< of a position in [0, 1]
  [[nodiscard]] double unit(double value) const;  ///< the inverse, within [0, 1]
};

struct GeneticOptions {
  std::size_t population = 1000;
  std::size_t generations = 25;
  std::size_t elite = 20;  ///< the best go on unchanged
  /// The best individual is chosen as a parent this many times as often as the middle one, the
  /// worst as rarely as two less this; from 1 (chance alone) to 2.
  double selection_pressure = 1.8;
  double crossover_rate = 0.9;  ///< else the child is its first parent
  double mutation_rate = 0.06;  ///< of each gene
  /// Standard deviation of a mutation, as a share of the gene's range; falls evenly to a tenth of
  /// it by the last generation.
  double mutation_sigma = 0.15;
  std::uint64_t seed = 1;
};

/// Lower is better; what is not finite counts as worst.
struct GenerationSummary {
  double best = 0.0;
  double mean = 0.0;            ///< of the finite ones
  std::size_t failed = 0;       ///< not finite
  std::size_t evaluations = 0;  ///< since the start
};

/// Everything a run is between two generations; nothing else is needed to go on.
struct GeneticState {
  std::vector<double> units;   ///< individuals row by row, each gene in [0, 1], best first
  std::vector<double> scores;  ///< of the individuals
  std::vector<GenerationSummary> history;  ///< one for each generation judged

  [[nodiscard]] std::size_t generation() const { return history.size(); }
};

/// Scores of individuals: genes row by row in their own units, one score for each.
using BatchFitness =
    std::function<void(std::span<const double> individuals, std::span<double> scores)>;

class GeneticSearch {
 public:
  GeneticSearch(std::vector<Gene> genes, const GeneticOptions& options);

  [[nodiscard]] const std::vector<Gene>& genes() const { return genes_; }
  [[nodiscard]] const GeneticOptions& options() const { return options_; }

  /// The first generation, spread over the bounds and judged; `known` (rows of genes in their own
  /// units) take the first places.
  [[nodiscard]] GeneticState start(const BatchFitness& fitness,
                                   std::span<const double> known = {}) const;
  /// The next generation. Draws from a stream of its own, so that it depends on `state` alone.
  [[nodiscard]] GeneticState next(const GeneticState& state, const BatchFitness& fitness) const;

  [[nodiscard]] bool finished(const GeneticState& state) const {
    return state.generation() >= options_.generations;
  }
  /// The best individual in its own units.
  [[nodiscard]] std::vector<double> best(const GeneticState& state) const;

  /// A state as text, to the last bit, with what it depends on; reading checks all of it.
  [[nodiscard]] std::string format(const GeneticState& state) const;
  [[nodiscard]] Result<GeneticState> parse(std::string_view text, const std::string& source) const;

 private:
  void judge(GeneticState& state, std::size_t from, std::size_t evaluations,
             const BatchFitness& fitness) const;
  [[nodiscard]] std::string heading() const;

  std::vector<Gene> genes_;
  GeneticOptions options_;
};

}  // namespace wayfare
