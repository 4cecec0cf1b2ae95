#include <wayfare/filter/particles.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace wayfare {
namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();
const double kNan = std::nan("");

std::vector<double> logs(std::vector<double> weights) {
  for (double& w : weights) w = std::log(w);
  return weights;
}

std::vector<int> counts(const std::vector<ParticleIndex>& drawn, std::size_t particles) {
  std::vector<int> n(particles);
  for (const ParticleIndex i : drawn) ++n.at(i);
  return n;
}

constexpr Resampling kAll[] = {Resampling::multinomial, Resampling::residual,
                               Resampling::stratified, Resampling::low_variance};

TEST(LogSumExp, IsFiniteWhereTheWeightsUnderflow) {
  EXPECT_NEAR(log_sum_exp(logs({0.1, 0.2, 0.3})), std::log(0.6), 1e-15);
  EXPECT_NEAR(log_sum_exp(std::vector<double>{-5000.0, -5000.0}), -5000.0 + std::log(2.0), 1e-12);
  EXPECT_NEAR(log_sum_exp(std::vector<double>{5000.0, -kInf}), 5000.0, 0.0);
  EXPECT_NEAR(log_sum_exp(std::vector<double>{kNan, 1.0, kInf}), 1.0, 0.0);
  EXPECT_EQ(log_sum_exp({}), -kInf);
  EXPECT_EQ(log_sum_exp(std::vector<double>{-kInf, kNan}), -kInf);
}

TEST(Normalise, SumsToOneAndReportsTheEvidence) {
  std::vector<double> w{-1000.0, -1001.0, -1002.5};
  const double evidence = log_sum_exp(w);
  const Normalisation n = normalise(w);
  EXPECT_EQ(n.log_sum, evidence);
  EXPECT_FALSE(n.collapsed);
  EXPECT_EQ(n.refused, 0U);
  EXPECT_NEAR(log_sum_exp(w), 0.0, 1e-12);
  EXPECT_NEAR(w[0] - w[2], 2.5, 1e-12);
}

TEST(Normalise, InvalidWeightsBecomeZero) {
  std::vector<double> w{kNan, 0.0, kInf, 0.0, -kInf};
  const Normalisation n = normalise(w);
  EXPECT_EQ(n.refused, 2U);
  EXPECT_FALSE(n.collapsed);
  EXPECT_EQ(w[0], -kInf);
  EXPECT_EQ(w[2], -kInf);
  EXPECT_EQ(w[4], -kInf);
  EXPECT_NEAR(w[1], std::log(0.5), 1e-15);
}

TEST(Normalise, CollapseGivesEqualWeights) {
  std::vector<double> w{-kInf, kNan, -kInf, -kInf};
  const Normalisation n = normalise(w);
  EXPECT_TRUE(n.collapsed);
  EXPECT_EQ(n.refused, 1U);
  for (const double l : w) EXPECT_NEAR(l, std::log(0.25), 1e-15);
  std::vector<double> none;
  EXPECT_TRUE(normalise(none).collapsed);
}

TEST(EffectiveSampleSize, CountsEqualWeights) {
  EXPECT_NEAR(effective_sample_size(logs({0.2, 0.2, 0.2, 0.2})), 4.0, 1e-12);
  EXPECT_NEAR(effective_sample_size(std::vector<double>{-900.0, -900.0, -kInf, kNan}), 2.0, 1e-12);
  EXPECT_EQ(effective_sample_size(std::vector<double>{-700.0, -kInf}), 1.0);
  EXPECT_EQ(effective_sample_size(std::vector<double>{-kInf, -kInf}), 0.0);
  // 1/Σw² of w = (½, ¼, ¼): 1/(¼ + ⅛) = 8/3.
  EXPECT_NEAR(effective_sample_size(logs({2.0, 1.0, 1.0})), 8.0 / 3.0, 1e-12);
}

class EveryScheme : public ::testing::TestWithParam<Resampling> {};

// E[count] = n·w for each scheme. Over R runs the mean count has a standard error of at most
// √(n·w(1 − w)/R), multinomial's, which bounds that of the three others (Douc, Cappé, Moulines
// 2005); six of them are allowed.
TEST_P(EveryScheme, IsUnbiased) {
  const std::vector<double> w{0.05, 0.31, 0.0, 0.14, 0.5};
  const std::vector<double> log_w = logs({5.0, 31.0, 0.0, 14.0, 50.0});
  const std::size_t n = 7;
  const int runs = 20000;
  Rng rng(11);
  std::vector<double> total(w.size());
  for (int r = 0; r < runs; ++r)
    for (const ParticleIndex i : resample(log_w, n, GetParam(), rng)) total[i] += 1.0;
  for (std::size_t i = 0; i < w.size(); ++i) {
    const double expected = 7.0 * w[i];
    EXPECT_NEAR(total[i] / runs, expected, 6.0 * std::sqrt(expected * (1.0 - w[i]) / runs) + 1e-12)
        << "particle " << i;
  }
}

TEST_P(EveryScheme, DrawsAscendInTheRequestedNumber) {
  Rng rng(5);
  std::vector<double> log_w(100);
  for (double& l : log_w) l = 30.0 * rng.normal();
  for (const std::size_t n : {std::size_t{0}, std::size_t{1}, std::size_t{30}, std::size_t{1000}}) {
    const auto drawn = resample(log_w, n, GetParam(), rng);
    ASSERT_EQ(drawn.size(), n);
    EXPECT_TRUE(std::is_sorted(drawn.begin(), drawn.end()));
  }
}

TEST_P(EveryScheme, SameSeedSameDraws) {
  const std::vector<double> log_w = logs({1.0, 2.0, 3.0, 4.0, 5.0});
  Rng a(9), b(9), c(10);
  const auto first = resample(log_w, 1000, GetParam(), a);
  EXPECT_EQ(first, resample(log_w, 1000, GetParam(), b));
  if (GetParam() == Resampling::multinomial) {
    EXPECT_NE(first, resample(log_w, 1000, GetParam(), c));
  }
}

TEST_P(EveryScheme, OneParticleWithAllTheWeightIsAlwaysDrawn) {
  Rng rng(1);
  const std::vector<double> log_w{-kInf, -kInf, -1e6, -kInf};
  for (const ParticleIndex i : resample(log_w, 50, GetParam(), rng)) EXPECT_EQ(i, 2U);
}

TEST_P(EveryScheme, InvalidWeightsAreNeverDrawn) {
  Rng rng(1);
  const std::vector<double> log_w{kNan, 0.0, kInf, 0.0, -kInf};
  const auto n = counts(resample(log_w, 1000, GetParam(), rng), 5);
  EXPECT_EQ(n[0] + n[2] + n[4], 0);
  EXPECT_GT(n[1], 0);
  EXPECT_GT(n[3], 0);
}

TEST_P(EveryScheme, WithoutWeightsAllAreEqual) {
  Rng rng(1);
  const std::vector<double> none{-kInf, kNan, -kInf, -kInf};
  const auto n = counts(resample(none, 4000, GetParam(), rng), 4);
  // 1000 each, multinomial to within six of √(4000·¼·¾) = 27.4.
  for (const int c : n) EXPECT_NEAR(c, 1000, 165);
  const std::vector<double> empty;
  EXPECT_EQ(resample(empty, 3, GetParam(), rng), (std::vector<ParticleIndex>{0, 0, 0}));
}

std::string scheme_name(const ::testing::TestParamInfo<Resampling>& info) {
  constexpr const char* kSchemes[] = {"Multinomial", "Residual", "Stratified", "LowVariance"};
  return kSchemes[static_cast<int>(info.param)];
}

INSTANTIATE_TEST_SUITE_P(Schemes, EveryScheme, ::testing::ValuesIn(kAll), scheme_name);

// The largest difference of a count from n·w.
TEST(Resample, CountsStayWithinTheirSchemesBounds) {
  Rng rng(23);
  for (int run = 0; run < 200; ++run) {
    std::vector<double> w(40);
    double sum = 0.0;
    for (double& x : w) sum += x = std::exp(2.0 * rng.normal());
    const std::vector<double> log_w = logs(w);
    for (const std::size_t n : {std::size_t{10}, std::size_t{40}, std::size_t{333}}) {
      const auto low = counts(resample(log_w, n, Resampling::low_variance, rng), w.size());
      const auto strata = counts(resample(log_w, n, Resampling::stratified, rng), w.size());
      const auto rest = counts(resample(log_w, n, Resampling::residual, rng), w.size());
      for (std::size_t i = 0; i < w.size(); ++i) {
        const double expected = static_cast<double>(n) * w[i] / sum;
        EXPECT_LT(std::abs(low[i] - expected), 1.0 + 1e-9);
        EXPECT_LT(std::abs(strata[i] - expected), 2.0 + 1e-9);
        EXPECT_GE(rest[i], std::floor(expected - 1e-9));
      }
    }
  }
}

TEST(Resample, EqualWeightsKeepTheSet) {
  Rng rng(2);
  const std::vector<double> equal(30, -123.0);
  for (const Resampling scheme : {Resampling::low_variance, Resampling::residual}) {
    const auto n = counts(resample(equal, 30, scheme, rng), 30);
    for (const int c : n) EXPECT_EQ(c, 1);
  }
}

// The counts of a multinomial draw are binomial: variance n·w(1 − w). The sample variance over R
// runs has a relative standard error of about √(2/R) (and a bit more, as binomial tails are not
// normal); eight of those.
TEST(Resample, MultinomialHasItsVariance) {
  const std::vector<double> log_w = logs({1.0, 3.0});
  Rng rng(4);
  const int runs = 20000;
  double sum = 0.0, squares = 0.0;
  for (int r = 0; r < runs; ++r) {
    const double c = counts(resample(log_w, 20, Resampling::multinomial, rng), 2)[0];
    sum += c;
    squares += c * c;
  }
  const double mean = sum / runs, variance = squares / runs - mean * mean;
  EXPECT_NEAR(variance, 20 * 0.25 * 0.75, 8.0 * std::sqrt(2.0 / runs) * 3.75);
}

}  // namespace
}  // namespace wayfare
