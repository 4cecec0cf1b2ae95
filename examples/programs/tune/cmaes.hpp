#pragma once

#include <cstddef>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/tune/genetic.hpp>

namespace wayfare::examples {

/// Result of covariance matrix adaptation (Hansen 2006), by pagmo if it was available at build
/// time.
struct CmaesOutcome {
  std::vector<double> best;  ///< genes in their units
  double score = 0.0;
  std::size_t evaluations = 0;
};

/// Starts from the best individuals of a genetic search; never worse than it. Random numbers from
/// `options.seed`. An error if built without pagmo.
[[nodiscard]] Result<CmaesOutcome> cmaes(const GeneticSearch& search, const GeneticState& from,
                                         std::size_t evaluations, const BatchFitness& fitness);

}  // namespace wayfare::examples
