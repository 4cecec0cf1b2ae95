#include <wayfare/core/statistics.hpp>

#include <array>
#include <cmath>

#include <gtest/gtest.h>

namespace wayfare::eval {
namespace {

// Squares 4 + 16 + 16 + 16 + 25 + 25 + 49 + 81 = 232; squared distances from the mean 5: 32.
TEST(Statistics, MatchesASetWorkedByHand) {
  const std::array values = {2.0, 4.0, 4.0, 4.0, 5.0, 5.0, 7.0, 9.0};
  const Summary s = summarise(values);
  EXPECT_EQ(s.count, 8U);
  EXPECT_DOUBLE_EQ(s.mean, 5.0);
  EXPECT_DOUBLE_EQ(s.std, 2.0);
  EXPECT_DOUBLE_EQ(s.rmse, std::sqrt(29.0));
  EXPECT_DOUBLE_EQ(s.median, 4.5);
  EXPECT_DOUBLE_EQ(s.max, 9.0);
}

TEST(Statistics, IsAccurateForLargeNumbersThatDifferLittle) {
  const std::array values = {1e9 + 1.0, 1e9 + 2.0, 1e9 + 3.0};
  EXPECT_NEAR(summarise(values).std, std::sqrt(2.0 / 3.0), 1e-12);
}

TEST(Statistics, MedianDoesNotDependOnOrder) {
  EXPECT_EQ(median_of({9.0, -1.0, 3.0}), 3.0);
  EXPECT_EQ(median_of({9.0, -1.0, 3.0, 4.0}), 3.5);
  EXPECT_EQ(median_of({-2.0}), -2.0);
}

TEST(Statistics, UpperMedianIsOneOfTheValues) {
  std::vector<double> even = {9.0, -1.0, 3.0, 4.0}, odd = {9.0, -1.0, 3.0}, none;
  EXPECT_EQ(upper_median_of(even), 4.0);
  EXPECT_EQ(upper_median_of(odd), 3.0);
  EXPECT_EQ(upper_median_of(none), 0.0);
  std::vector<std::pair<int, double>> pairs = {{5, 0.1}, {7, 0.3}, {6, 0.2}};
  EXPECT_EQ(upper_median_of(pairs, &std::pair<int, double>::second), 0.2);
}

TEST(Statistics, IsNaNForAnEmptySet) {
  const Summary s = summarise({});
  EXPECT_EQ(s.count, 0U);
  for (const double v : {s.mean, s.std, s.rmse, s.median, s.max, median_of({})})
    EXPECT_TRUE(std::isnan(v));
}

// The maximum is of the values, not of their magnitudes.
TEST(Statistics, HandlesNegativeValues) {
  const std::array values = {-3.0, -1.0};
  EXPECT_EQ(summarise(values).max, -1.0);
  EXPECT_EQ(summarise(values).mean, -2.0);
}

}  // namespace
}  // namespace wayfare::eval
