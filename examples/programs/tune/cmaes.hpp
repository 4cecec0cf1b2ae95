#pragma once

// Covariance matrix adaptation (Hansen 2006), by pagmo where it was found when this was built.

#include <cstddef>
#include <span>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/tune/genetic.hpp>

namespace wayfare::examples {

struct CmaesOutcome {
  std::vector<double> best;  ///< genes in their own units
  double score = 0.0;
  std::size_t evaluations = 0;
};

/// Goes on from the best individuals of a genetic search; never worse than it. Draws from
/// `options.seed`. An error where it was built without pagmo.
[[nodiscard]] Result<CmaesOutcome> cmaes(const GeneticSearch& search, const GeneticState& from,
                                         std::size_t evaluations, const BatchFitness& fitness);

}  // namespace wayfare::examples
