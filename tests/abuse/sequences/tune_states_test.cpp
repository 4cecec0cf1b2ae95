// Saved states of the genetic search: interrupted anywhere, and with changed bytes.

#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>
#include <wayfare/tune/genetic.hpp>

#include "abuse/abuse.hpp"

namespace wayfare::tests {
namespace {

GeneticSearch search_of(Rng& rng) {
  GeneticOptions o;
  o.population = 2 + rng.below(8);
  o.elite = rng.below(o.population);
  o.generations = 6;
  o.seed = rng();
  std::vector<Gene> genes;
  for (std::size_t g = 1 + rng.below(3); g > 0; --g)
    genes.push_back({"g" + std::to_string(g), 0.5, 0.5 + rng.uniform(), rng.below(2) == 0});
  return {genes, o};
}

BatchFitness fitness_of(std::size_t genes) {
  return [genes](std::span<const double> x, std::span<double> scores) {
    for (std::size_t i = 0; i < scores.size(); ++i) {
      scores[i] = 0.0;
      for (std::size_t g = 0; g < genes; ++g) scores[i] += x[i * genes + g] * x[i * genes + g];
      if (x[i * genes] < 0.6) scores[i] = kNan;
    }
  };
}

TEST(GeneticStates, InterruptedAnywhereTheyEndTheSame) {
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Rng rng(seed);
    const GeneticSearch search = search_of(rng);
    const BatchFitness fitness = fitness_of(search.genes().size());
    GeneticState straight = search.start(fitness), resumed = straight;
    while (!search.finished(straight)) {
      straight = search.next(straight, fitness);
      if (rng.below(2) == 0) {
        const auto restored = search.parse(search.format(resumed), "saved");
        ASSERT_TRUE(restored) << restored.error().to_string();
        resumed = *restored;
      }
      resumed = search.next(resumed, fitness);
      ASSERT_EQ(search.format(resumed), search.format(straight));
    }
    for (std::size_t i = 1; i < straight.scores.size(); ++i)
      ASSERT_LE(straight.scores[i - 1], straight.scores[i]);
  }
}

std::string changed(std::string text, Rng& rng) {
  constexpr std::string_view kBytes = "0123456789 .-+e\nnaif#\r\t";
  for (std::uint64_t n = 1 + rng.below(3); n > 0 && !text.empty(); --n) {
    const std::size_t at = rng.below(text.size());
    const char byte =
        rng.below(4) == 0 ? static_cast<char>(rng()) : kBytes[rng.below(kBytes.size())];
    switch (rng.below(5)) {
      case 0:
        text.erase(at, 1 + rng.below(4));
        break;
      case 1:
        text.insert(at, 1, byte);
        break;
      case 2:
        text.resize(at);
        break;
      case 3:
        text += text.substr(at);
        break;
      default:
        text[at] = byte;
    }
  }
  return text;
}

TEST(GeneticStates, ChangedBytesAreRefusedOrAreTheStateTheySay) {
  std::size_t refused = 0;
  for (std::uint64_t seed = 0; seed < 6000; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Rng rng(seed % 20);
    const GeneticSearch search = search_of(rng);
    const BatchFitness fitness = fitness_of(search.genes().size());
    GeneticState state = search.start(fitness);
    if (rng.below(2) == 0) state = search.next(state, fitness);
    Rng changes = Rng(seed).stream(1);
    const std::string text = changed(search.format(state), changes);
    const auto parsed = search.parse(text, "saved");
    if (!parsed) {
      ASSERT_EQ(parsed.error().source, "saved");
      ++refused;
      continue;
    }
    ASSERT_EQ(search.format(*parsed), text);
    const GeneticState next = search.next(*parsed, fitness);
    for (const double u : next.units) ASSERT_TRUE(u >= 0.0 && u <= 1.0);
  }
  EXPECT_GT(refused, 5000U);
}

}  // namespace
}  // namespace wayfare::tests
