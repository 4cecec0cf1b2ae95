#include "cmaes.hpp"

#include <algorithm>
#include <utility>

#ifdef WAYFARE_PAGMO
#include <pagmo/algorithm.hpp>
#include <pagmo/algorithms/cmaes.hpp>
#include <pagmo/population.hpp>
#include <pagmo/problem.hpp>
#endif

#include "support/command_line.hpp"

namespace wayfare::examples {

#ifdef WAYFARE_PAGMO

namespace {

/// Genes in the unit cube; diverged individuals score 1e6.
struct UnitProblem {
  const GeneticSearch* search = nullptr;
  const BatchFitness* judge = nullptr;

  [[nodiscard]] pagmo::vector_double fitness(const pagmo::vector_double& units) const {
    std::vector<double> values;
    for (std::size_t g = 0; g < units.size(); ++g)
      values.push_back(search->genes()[g].value(units[g]));
    double score = 0.0;
    (*judge)(values, {&score, 1});
    return {std::min(score, 1e6)};
  }
  [[nodiscard]] std::pair<pagmo::vector_double, pagmo::vector_double> get_bounds() const {
    const std::size_t n = search->genes().size();
    return {pagmo::vector_double(n, 0.0), pagmo::vector_double(n, 1.0)};
  }
};

}  // namespace

Result<CmaesOutcome> cmaes(const GeneticSearch& search, const GeneticState& from,
                           std::size_t evaluations, const BatchFitness& fitness) {
  const std::size_t n = search.genes().size();
  const std::size_t individuals = std::min<std::size_t>(20, from.scores.size());
  if (individuals < 5) return bad_use("CMA-ES needs a population of at least five");
  const auto seed = static_cast<unsigned>(search.options().seed);
  pagmo::population population(pagmo::problem{UnitProblem{&search, &fitness}}, 0, seed);
  for (std::size_t i = 0; i < individuals; ++i) {
    const auto row = from.units.begin() + static_cast<std::ptrdiff_t>(i * n);
    population.push_back({row, row + static_cast<std::ptrdiff_t>(n)},
                         {std::min(from.scores[i], 1e6)});
  }
  const auto rounds = static_cast<unsigned>(std::max<std::size_t>(1, evaluations / individuals));
  const pagmo::algorithm algorithm{
      pagmo::cmaes(rounds, -1, -1, -1, -1, 0.1, 1e-9, 1e-9, false, true, seed)};
  population = algorithm.evolve(population);
  CmaesOutcome outcome;
  outcome.score = population.champion_f()[0];
  outcome.evaluations = static_cast<std::size_t>(population.get_problem().get_fevals());
  for (std::size_t g = 0; g < n; ++g)
    outcome.best.push_back(search.genes()[g].value(population.champion_x()[g]));
  return outcome;
}

#else

Result<CmaesOutcome> cmaes(const GeneticSearch&, const GeneticState&, std::size_t,
                           const BatchFitness&) {
  return Error{ErrorCode::unsupported, "this program was built without pagmo (libpagmo-dev)"};
}

#endif

}  // namespace wayfare::examples
