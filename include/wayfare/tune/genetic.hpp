#pragma once

// A real-coded genetic algorithm with bounds (Goldberg 1989): selection by rank or by tournament,
// two-point crossover, small mutations, elitism. Individuals are evaluated in batches, so that a
// fitness can vectorise and use any number of threads.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <wayfare/core/result.hpp>

namespace wayfare {

/// One parameter of the search.
struct Gene {
  std::string name;  ///< shown in reports and stored with a state
  double low = 0.0,  ///< in its own unit
      high = 1.0;    ///< in its own unit, not below `low`
  /// Uniform in its logarithm (`low` > 0), for quantities known to decades only.
  bool logarithmic = false;

  [[nodiscard]] double value(double unit) const;  ///< of a position in [0, 1]
  [[nodiscard]] double unit(double value) const;  ///< the inverse, within [0, 1]
};

/// Size, selection and variation of a GeneticSearch.
struct GeneticOptions {
  std::size_t population = 1000;  ///< individuals of a generation, at least 2
  std::size_t generations = 25;   ///< evaluated in all, the first included
  std::size_t elite = 20;         ///< number of best individuals copied unchanged
  /// Selection probability of the best individual relative to the median one; that of the worst is
  /// two less this. From 1 (uniform) to 2.
  double selection_pressure = 1.8;
  /// Tournament selection instead of that by rank: each parent is the best of this many individuals
  /// drawn with equal probability. Zero: by rank.
  std::size_t tournament = 0;
  double crossover_rate = 0.9;  ///< else the child copies its first parent
  double mutation_rate = 0.06;  ///< of each gene
  /// Standard deviation of a mutation, as a fraction of the gene's range; decreases linearly to a
  /// tenth by the last generation.
  double mutation_sigma = 0.15;
  std::uint64_t seed = 1;  ///< of all draws
};

/// Lower scores are better; non-finite ones are worst.
struct GenerationSummary {
  double best = 0.0;            ///< score of the best individual
  double mean = 0.0;            ///< of the finite scores
  std::size_t failed = 0;       ///< not finite
  std::size_t evaluations = 0;  ///< since the start
};

/// The complete state of a run between two generations.
struct GeneticState {
  std::vector<double> units;   ///< individuals row by row, each gene in [0, 1], best first
  std::vector<double> scores;  ///< of the individuals
  std::vector<GenerationSummary> history;  ///< one per evaluated generation

  /// Number of generations evaluated.
  [[nodiscard]] std::size_t generation() const { return history.size(); }
};

/// Scores of individuals: genes row by row in their own units, one score per row.
using BatchFitness =
    std::function<void(std::span<const double> individuals, std::span<double> scores)>;

/// A search over genes between bounds, which the caller runs generation by generation.
class GeneticSearch {
 public:
  /// Requires a gene, finite ordered bounds (positive for logarithmic genes), a population of at
  /// least two that is larger than its elite.
  GeneticSearch(std::vector<Gene> genes, const GeneticOptions& options);

  /// The parameters searched, in the order of an individual's row.
  [[nodiscard]] const std::vector<Gene>& genes() const { return genes_; }
  /// As given.
  [[nodiscard]] const GeneticOptions& options() const { return options_; }

  /// The first generation, uniform over the bounds and evaluated; `known` (rows of genes in their
  /// own units) are its first individuals, NaN where a gene is not known.
  [[nodiscard]] GeneticState start(const BatchFitness& fitness,
                                   std::span<const double> known = {}) const;
  /// The next generation. Has its own random stream, so that it depends on `state` only.
  [[nodiscard]] GeneticState next(const GeneticState& state, const BatchFitness& fitness) const;

  /// Whether all generations were evaluated.
  [[nodiscard]] bool finished(const GeneticState& state) const {
    return state.generation() >= options_.generations;
  }
  /// The best individual in its own units.
  [[nodiscard]] std::vector<double> best(const GeneticState& state) const;

  /// A state as text, bit-exact, with genes and options; parsing checks all of it: what is accepted
  /// is formatted to the same text.
  [[nodiscard]] std::string format(const GeneticState& state) const;
  /// The inverse of format(). Errors (parse, invalid) name `source` and the line.
  [[nodiscard]] Result<GeneticState> parse(std::string_view text, const std::string& source) const;

 private:
  void evaluate(GeneticState& state, std::size_t from, std::size_t evaluations,
                const BatchFitness& fitness) const;
  [[nodiscard]] std::string header() const;

  std::vector<Gene> genes_;
  GeneticOptions options_;
};

}  // namespace wayfare
