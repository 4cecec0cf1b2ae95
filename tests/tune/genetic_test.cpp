#include <wayfare/tune/genetic.hpp>

#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

namespace wayfare {
namespace {

std::vector<Gene> genes(std::size_t n) {
  std::vector<Gene> all;
  for (std::size_t i = 0; i < n; ++i)
    all.push_back(i % 2 == 0
                      ? Gene{std::string("gene_").append(std::to_string(i)), -5.0, 5.0, false}
                      : Gene{std::string("gene_").append(std::to_string(i)), 1e-3, 1e3, true});
  return all;
}

//! [fitness]
/// Zero if every linear gene is 1 and every logarithmic one 10.
void bowl(std::size_t n, std::span<const double> x, std::span<double> scores) {
  for (std::size_t i = 0; i < scores.size(); ++i) {
    double sum = 0.0;
    for (std::size_t g = 0; g < n; ++g) {
      const double v = x[i * n + g];
      const double e = g % 2 == 0 ? v - 1.0 : std::log10(v / 10.0);
      sum += e * e;
    }
    scores[i] = sum;
  }
}

BatchFitness bowl_of(std::size_t n) {
  return [n](auto x, auto scores) { bowl(n, x, scores); };
}

GeneticState run(const GeneticSearch& search, const BatchFitness& fitness) {
  GeneticState s = search.start(fitness);
  while (!search.finished(s)) s = search.next(s, fitness);
  return s;
}
//! [fitness]

TEST(Gene, UnitValueRoundTrip) {
  const Gene linear{"a", -2.0, 6.0, false}, logarithmic{"b", 1e-4, 1e2, true};
  EXPECT_DOUBLE_EQ(linear.value(0.25), 0.0);
  EXPECT_NEAR(logarithmic.value(0.5), 0.1, 1e-15);
  for (const double u : {0.0, 0.3, 1.0}) {
    EXPECT_NEAR(linear.unit(linear.value(u)), u, 1e-15);
    EXPECT_NEAR(logarithmic.unit(logarithmic.value(u)), u, 1e-14);
  }
  EXPECT_EQ(linear.unit(99.0), 1.0);
  EXPECT_EQ(logarithmic.unit(-1.0), 0.0);
}

//! [search]
TEST(Genetic, FindsTheMinimumOfABowl) {
  const GeneticOptions o{.population = 200, .generations = 60, .elite = 4};
  const GeneticSearch search(genes(8), o);
  const GeneticState s = run(search, bowl_of(8));
  // The first generation has a mean score of 12: 8·(range²/12 + offset²).
  EXPECT_LT(s.scores.front(), 0.05);
  EXPECT_GT(s.history.front().best, 20.0 * s.scores.front());
  const auto best = search.best(s);
  for (std::size_t g = 0; g < 8; g += 2) EXPECT_NEAR(best[g], 1.0, 0.25);
}
//! [search]

TEST(Genetic, KeepsTheBestAndStaysInBounds) {
  const GeneticOptions o{
      .population = 40, .generations = 15, .elite = 1, .mutation_rate = 0.9, .mutation_sigma = 2.0};
  const GeneticSearch search(genes(5), o);
  GeneticState s = search.start(bowl_of(5));
  while (!search.finished(s)) {
    const double before = s.scores.front();
    s = search.next(s, bowl_of(5));
    EXPECT_LE(s.scores.front(), before);
    EXPECT_TRUE(std::is_sorted(s.scores.begin(), s.scores.end()));
    for (const double u : s.units) EXPECT_TRUE(u >= 0.0 && u <= 1.0);
  }
  EXPECT_EQ(s.history.back().evaluations, 40U + 14U * 39U);
}

TEST(Genetic, NonFiniteScoresDoNotEndTheRun) {
  const GeneticOptions o{.population = 60, .generations = 10, .elite = 2};
  const GeneticSearch search(genes(4), o);
  const BatchFitness half = [](auto x, auto scores) {
    bowl(4, x, scores);
    for (std::size_t i = 0; i < scores.size(); ++i)
      if (x[4 * i] < 0.0) scores[i] = std::numeric_limits<double>::quiet_NaN();
  };
  const GeneticState first = search.start(half);
  EXPECT_GT(first.history[0].failed, 15U);
  EXPECT_TRUE(std::isinf(first.scores.back()));
  EXPECT_TRUE(std::isfinite(first.history[0].mean));
  const GeneticState last = run(search, half);
  EXPECT_LT(last.history.back().failed, first.history[0].failed);
}

TEST(Genetic, PutsKnownIndividualsFirst) {
  const GeneticOptions o{.population = 10, .elite = 1};
  const GeneticSearch search(genes(2), o);
  const std::vector<double> known = {1.0, 10.0};
  const GeneticState s = search.start(bowl_of(2), known);
  EXPECT_NEAR(s.scores.front(), 0.0, 1e-20);
}

TEST(Genetic, ResumesFromTextBitExactly) {
  const GeneticOptions o{.population = 30, .generations = 8, .elite = 2};
  const GeneticSearch search(genes(6), o);
  const GeneticState whole = run(search, bowl_of(6));
  GeneticState s = search.start(bowl_of(6));
  while (!search.finished(s)) {
    const auto read = search.parse(search.format(s), "checkpoint");
    ASSERT_TRUE(read.has_value());
    s = search.next(*read, bowl_of(6));
  }
  EXPECT_EQ(s.units, whole.units);
  EXPECT_EQ(s.scores, whole.scores);
}

TEST(Genetic, RejectsForeignCheckpoints) {
  const GeneticOptions o{.population = 12, .elite = 2};
  const GeneticSearch search(genes(3), o);
  const GeneticState s = search.start(bowl_of(3));
  const std::string text = search.format(s);
  for (std::size_t cut = 0; cut + 5 < text.size(); cut += 7)
    EXPECT_FALSE(search.parse(text.substr(0, cut), "cut").has_value()) << cut;
  GeneticOptions other = o;
  other.seed = 2;
  const auto rejected = GeneticSearch(genes(3), other).parse(text, "run.checkpoint");
  ASSERT_FALSE(rejected.has_value());
  EXPECT_EQ(rejected.error().source, "run.checkpoint");
  EXPECT_FALSE(GeneticSearch(genes(4), o).parse(text, "x").has_value());
}

TEST(Genetic, SelectsParentsByRank) {
  // Without crossover and mutation children are copies, mostly of the better half.
  const GeneticOptions o{.population = 400,
                         .elite = 1,
                         .selection_pressure = 2.0,
                         .crossover_rate = 0.0,
                         .mutation_rate = 0.0};
  const GeneticSearch search(genes(1), o);
  const GeneticState first = search.start(bowl_of(1));
  const GeneticState second = search.next(first, bowl_of(1));
  const double middle = first.scores[200];
  const auto better = std::count_if(second.scores.begin(), second.scores.end(),
                                    [middle](double v) { return v < middle; });
  EXPECT_NEAR(static_cast<double>(better), 300.0, 30.0);  // ∫₀^½ 2 − 2x = 3/4; σ = 9
}

TEST(Genetic, SelectsParentsByTournament) {
  const GeneticOptions o{
      .population = 400, .elite = 1, .tournament = 3, .crossover_rate = 0.0, .mutation_rate = 0.0};
  const GeneticSearch search(genes(1), o);
  const GeneticState first = search.start(bowl_of(1));
  const GeneticState second = search.next(first, bowl_of(1));
  const double middle = first.scores[200];
  const auto better = std::count_if(second.scores.begin(), second.scores.end(),
                                    [middle](double v) { return v < middle; });
  // One of three is of the better half: 1 − (1/2)³ = 7/8 of 400; σ = 6.6.
  EXPECT_NEAR(static_cast<double>(better), 350.0, 22.0);
  GeneticOptions by_rank = o;
  by_rank.tournament = 0;
  EXPECT_TRUE(search.parse(search.format(second), "x").has_value());
  EXPECT_FALSE(GeneticSearch(genes(1), by_rank).parse(search.format(second), "x").has_value());
}

}  // namespace
}  // namespace wayfare
