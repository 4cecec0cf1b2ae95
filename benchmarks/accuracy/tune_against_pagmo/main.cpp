// The genetic search, pagmo's simple genetic algorithm and its CMA-ES (Hansen 2006) on the same
// fitness with the same number of evaluations: the final score of each.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include <pagmo/algorithm.hpp>
#include <pagmo/algorithms/cmaes.hpp>
#include <pagmo/algorithms/sga.hpp>
#include <pagmo/population.hpp>
#include <pagmo/problem.hpp>

#include <wayfare/tune/ins_fitness.hpp>

#include "support/program_files.hpp"
#include "support/progress_line.hpp"
#include "tune/drives.hpp"

namespace {

using namespace wayfare;
using namespace wayfare::examples;

struct Options {
  std::string training, nominal;
  std::size_t population = 100, generations = 25, seeds = 3, cmaes_population = 20;
  int threads = 1;
};

/// Genes in the unit cube; diverged individuals score 1e4.
struct Problem {
  const InsFitness* judge = nullptr;
  const std::vector<Gene>* genes = nullptr;

  [[nodiscard]] pagmo::vector_double fitness(const pagmo::vector_double& units) const {
    std::vector<double> values;
    for (std::size_t g = 0; g < units.size(); ++g) values.push_back((*genes)[g].value(units[g]));
    double score = 0.0;
    (*judge)(values, {&score, 1});
    return {std::min(score, 1e4)};
  }
  [[nodiscard]] std::pair<pagmo::vector_double, pagmo::vector_double> get_bounds() const {
    return {pagmo::vector_double(genes->size(), 0.0), pagmo::vector_double(genes->size(), 1.0)};
  }
};
struct Outcome {
  double score = 0.0;
  unsigned long long evaluations = 0;
  double seconds = 0.0;
};

Outcome with_pagmo(const InsFitness& fitness, const std::vector<Gene>& genes,
                   pagmo::algorithm algorithm, std::size_t population, unsigned seed) {
  ProgressLine timer("pagmo", true);
  const pagmo::problem problem{Problem{&fitness, &genes}};
  pagmo::population individuals(problem, population, seed);
  individuals = algorithm.evolve(individuals);
  return {individuals.champion_f()[0], individuals.get_problem().get_fevals(), timer.finish()};
}

Outcome with_wayfare(const InsFitness& fitness, const std::vector<Gene>& genes, const Options& o,
                     unsigned seed) {
  ProgressLine timer("wayfare", true);
  GeneticOptions options;
  options.population = o.population;
  options.generations = o.generations;
  options.elite = std::max<std::size_t>(1, o.population / 50);
  options.seed = seed;
  const GeneticSearch search(genes, options);
  const BatchFitness batch = [&fitness](auto x, auto scores) { fitness(x, scores); };
  GeneticState state = search.start(batch);
  while (!search.finished(state)) state = search.next(state, batch);
  return {state.scores.front(), state.history.back().evaluations, timer.finish()};
}

Result<void> run(const Options& o) {
  const auto drive = load_drive(o.training, 1);
  if (!drive) return drive.error();
  GnssInsOptions nominal = drive->config.filter;
  if (!o.nominal.empty()) {
    const auto config = read_nav_config(o.nominal);
    if (!config) return config.error();
    nominal = with_ins_genes(nominal, ins_genes(config->filter));
  }
  InsFitnessOptions options;
  options.threads = o.threads;
  const auto fitness = InsFitness::make(drive->tuning, options);
  if (!fitness) return fitness.error();
  // pagmo evaluates one individual at a time: the narrowest kernel is the fastest for it, with
  // bit-identical scores.
  options.kernel = "baseline";
  options.threads = 1;
  const auto one_by_one = InsFitness::make(drive->tuning, options);
  if (!one_by_one) return one_by_one.error();
  const std::vector<Gene> genes = ins_gene_bounds(nominal);
  eval::Table table({{"search"}, {"seed"}, {"final fitness"}, {"evaluations"}, {"time", "s"}});
  const auto row = [&table](const std::string& who, std::size_t seed, const Outcome& outcome) {
    table.add_row({who, std::to_string(seed), eval::fixed(outcome.score, 4),
                   std::to_string(outcome.evaluations), eval::fixed(outcome.seconds, 1)});
    std::fprintf(stderr, "%s, seed %zu: %.4f\n", who.c_str(), seed, outcome.score);
  };
  const std::size_t evaluations = o.population * o.generations;
  for (std::size_t s = 1; s <= o.seeds; ++s) {
    const auto seed = static_cast<unsigned>(s);
    row("wayfare genetic", s, with_wayfare(*fitness, genes, o, seed));
    pagmo::sga sga(static_cast<unsigned>(o.generations - 1), 0.9, 1.0, 0.06, 0.15, 2, "exponential",
                   "gaussian", "tournament", seed);
    row("pagmo sga", s, with_pagmo(*one_by_one, genes, pagmo::algorithm{sga}, o.population, seed));
    const auto rounds = static_cast<unsigned>(evaluations / o.cmaes_population - 1);
    pagmo::cmaes cmaes(rounds, -1, -1, -1, -1, 0.3, 1e-9, 1e-9, false, true, seed);
    row("pagmo cmaes", s,
        with_pagmo(*one_by_one, genes, pagmo::algorithm{cmaes}, o.cmaes_population, seed));
  }
  std::fputs(table.to_text().c_str(), stdout);
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  CommandLine app("Compare the genetic search with those of pagmo on the fitness of one drive.");
  Options o;
  app.add_option("--training", o.training, "a drive as tune reads it").required();
  app.add_option("--nominal", o.nominal, "nominal parameters, centre of the bounds");
  app.add_option("--population", o.population, "of the genetic searches").show_default();
  app.add_option("--generations", o.generations, "of the genetic searches").show_default();
  app.add_option("--seeds", o.seeds, "runs of each search").show_default();
  app.add_option("--threads", o.threads, "of the fitness of many individuals").show_default();
  app.example("--training drive1", "the search beside pagmo's on one drive");
  if (const auto code = app.parse(argc, argv)) return *code;
  return exit_code("tune_against_pagmo", run(o));
}
