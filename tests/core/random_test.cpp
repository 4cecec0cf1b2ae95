#include <wayfare/core/random.hpp>

#include <array>
#include <cmath>
#include <cstdint>
#include <set>
#include <vector>

#include <gtest/gtest.h>

namespace wayfare {
namespace {

// The reference algorithms of Blackman and Vigna, written from their description (rotations as
// shifts, one word at a time) and not from our header.
std::uint64_t rotate_left(std::uint64_t x, unsigned k) { return (x << k) | (x >> (64U - k)); }

struct ReferenceSplitMix {
  std::uint64_t x;
  std::uint64_t next() {
    x += 0x9E3779B97F4A7C15U;
    std::uint64_t z = x;
    z = (z ^ (z >> 30U)) * 0xBF58476D1CE4E5B9U;
    z = (z ^ (z >> 27U)) * 0x94D049BB133111EBU;
    return z ^ (z >> 31U);
  }
};

struct ReferenceXoshiro256pp {
  std::uint64_t a, b, c, d;
  std::uint64_t next() {
    const std::uint64_t out = rotate_left(a + d, 23) + a;
    const std::uint64_t shifted = b << 17U;
    c ^= a;
    d ^= b;
    b ^= c;
    a ^= d;
    c ^= shifted;
    d = rotate_left(d, 45);
    return out;
  }
};

// Values printed with the published code: SplitMix64 from seed 1234567 (Rosetta Code's list), and
// xoshiro256++ from the state {1, 2, 3, 4}.
TEST(Random, TheReferencesMatchThePublishedValues) {
  ReferenceSplitMix split{1234567};
  for (const std::uint64_t expected :
       {6457827717110365317U, 3203168211198807973U, 9817491932198370423U, 4593380528125082431U,
        16408922859458223821U}) {
    EXPECT_EQ(split.next(), expected);
  }
  ReferenceXoshiro256pp xoshiro{1, 2, 3, 4};
  for (const std::uint64_t expected : {41943041U, 58720359U}) {
    EXPECT_EQ(xoshiro.next(), expected);
  }
  EXPECT_EQ(xoshiro.next(), 3588806011781223U);
  EXPECT_EQ(xoshiro.next(), 3591011842654386U);
  EXPECT_EQ(xoshiro.next(), 9228616714210784205U);
}

TEST(Random, IsXoshiroSeededThroughSplitMix) {
  for (const std::uint64_t seed : {std::uint64_t{0}, std::uint64_t{42}, ~std::uint64_t{0}}) {
    ReferenceSplitMix split{seed};
    ReferenceXoshiro256pp reference{split.next(), split.next(), split.next(), split.next()};
    Rng rng(seed);
    for (int i = 0; i < 1000; ++i) ASSERT_EQ(rng(), reference.next()) << seed << " " << i;
  }
}

TEST(Random, StreamsDependOnSeedAndIndexOnly) {
  Rng used(7);
  const Rng fresh(7);
  for (int i = 0; i < 100; ++i) used.normal();
  for (std::uint64_t index : {0U, 1U, 1000U}) {
    Rng a = used.stream(index), b = fresh.stream(index);
    for (int i = 0; i < 100; ++i) ASSERT_EQ(a(), b());
  }
}

TEST(Random, StreamsDoNotRepeatEachOther) {
  // 1000 streams and their own substreams, 20 draws each: among 4e4 numbers of 64 bits the chance
  // of one repeat is 4e-11.
  std::set<std::uint64_t> seen;
  std::size_t drawn = 0;
  const Rng root(3);
  for (std::uint64_t i = 0; i < 1000; ++i) {
    for (Rng rng : {root.stream(i), root.stream(i).stream(i)}) {
      for (int k = 0; k < 20; ++k, ++drawn) seen.insert(rng());
    }
  }
  Rng self = root;
  for (int k = 0; k < 20; ++k, ++drawn) seen.insert(self());
  EXPECT_EQ(seen.size(), drawn);
}

// Recorded results depend on the streams: their seeds are fixed.
TEST(Random, StreamsAreSeededThroughSplitMix) {
  constexpr std::uint64_t kSeed = 42;
  for (const std::uint64_t index : {0U, 1U, 7U}) {
    ReferenceSplitMix split{kSeed ^ (0xd1342543de82ef95U * (index + 1))};
    Rng expected(split.next()), stream = Rng(kSeed).stream(index);
    for (int i = 0; i < 10; ++i) ASSERT_EQ(stream(), expected()) << index;
  }
}

// Neighbouring streams must not be correlated: the mean product of n pairs of centred uniforms has
// standard deviation (1/12)/√n.
TEST(Random, NeighbouringStreamsAreUncorrelated) {
  constexpr int kCount = 100'000;
  const Rng root(11);
  double sum = 0.0;
  for (std::uint64_t i = 0; i < kCount; ++i) {
    sum += (root.stream(i).uniform() - 0.5) * (root.stream(i + 1).uniform() - 0.5);
  }
  EXPECT_LE(std::abs(sum / kCount), 6.0 / 12.0 / std::sqrt(kCount));
}

/// Mean of the k-th power of `n` draws.
template <class Draw>
double moment(Draw draw, int n, int power) {
  double sum = 0.0;
  for (int i = 0; i < n; ++i) sum += std::pow(draw(), power);
  return sum / n;
}

// The k-th moment's estimate has variance (m₂ₖ − mₖ²)/n; six standard deviations.
TEST(Random, UniformMoments) {
  constexpr int kCount = 1'000'000;
  Rng rng(5);
  for (int k = 1; k <= 4; ++k) {
    const double mean = 1.0 / (k + 1);
    const double sigma = std::sqrt((1.0 / (2 * k + 1) - mean * mean) / kCount);
    EXPECT_NEAR(moment([&] { return rng.uniform(); }, kCount, k), mean, 6.0 * sigma) << k;
  }
  for (int i = 0; i < 10'000; ++i) {
    const double u = rng.uniform(-2.0, 3.0);
    ASSERT_GE(u, -2.0);
    ASSERT_LE(u, 3.0);
  }
}

TEST(Random, NormalMoments) {
  constexpr int kCount = 1'000'000;
  // E xᵏ of a standard normal, k = 0 … 8.
  constexpr std::array<double, 9> kMoments{1, 0, 1, 0, 3, 0, 15, 0, 105};
  Rng rng(6);
  for (std::size_t k = 1; k <= 4; ++k) {
    const double sigma = std::sqrt((kMoments[2 * k] - kMoments[k] * kMoments[k]) / kCount);
    EXPECT_NEAR(moment([&] { return rng.normal(); }, kCount, static_cast<int>(k)), kMoments[k],
                6.0 * sigma)
        << k;
  }
  EXPECT_NEAR(moment([&] { return rng.normal(10.0, 0.5); }, kCount, 1), 10.0, 6.0 * 0.5e-3);
  // Of the square about the mean: σ² with standard deviation σ²·√(2/n).
  EXPECT_NEAR(moment([&] { return rng.normal(10.0, 0.5) - 10.0; }, kCount, 2), 0.25,
              6.0 * 0.25 * std::sqrt(2.0 / kCount));
}

// The two values of a Box-Muller pair are independent: the mean of their product has standard
// deviation 1/√n.
TEST(Random, ConsecutiveNormalsAreUncorrelated) {
  constexpr int kCount = 500'000;
  Rng rng(8);
  double product = 0.0, square = 0.0;
  for (int i = 0; i < kCount; ++i) {
    const double a = rng.normal(), b = rng.normal();
    product += a * b;
    square += (a * a - 1.0) * (b * b - 1.0);
  }
  EXPECT_LE(std::abs(product / kCount), 6.0 / std::sqrt(kCount));
  EXPECT_LE(std::abs(square / kCount), 6.0 * 2.0 / std::sqrt(kCount));  // Var = 2 · 2
}

// χ² of n draws over m cells has mean m − 1 and variance 2(m − 1).
TEST(Random, BelowIsUniform) {
  Rng rng(9);
  for (const std::size_t m : {2U, 3U, 7U, 64U, 100U}) {
    constexpr int kCount = 200'000;
    std::vector<double> counts(m, 0.0);
    for (int i = 0; i < kCount; ++i) counts.at(rng.below(m)) += 1.0;
    const double expected = kCount / static_cast<double>(m);
    double chi_square = 0.0;
    for (const double c : counts) chi_square += (c - expected) * (c - expected) / expected;
    const auto freedom = static_cast<double>(m - 1);
    EXPECT_LE(std::abs(chi_square - freedom), 6.0 * std::sqrt(2.0 * freedom)) << m;
  }
  EXPECT_EQ(rng.below(1), 0U);
  static_assert(std::same_as<decltype(rng.below(std::uint8_t{3})), std::size_t>);
  static_assert(std::same_as<decltype(rng.below(std::uint64_t{3})), std::uint64_t>);
  constexpr std::uint64_t kHuge = (std::uint64_t{1} << 63U) + 1;
  for (int i = 0; i < 100; ++i) ASSERT_LT(rng.below(kHuge), kHuge);
}

TEST(RandomDeathTest, BelowZeroViolatesThePrecondition) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_DEATH((void)Rng(1).below(0), "number of values must be positive");
}

}  // namespace
}  // namespace wayfare
