#include <wayfare/graph/detail/incremental_sum.hpp>

#include <gtest/gtest.h>

namespace wayfare {
namespace {

// Small integers: every order of summation gives the same result.
TEST(IncrementalSum, EqualsTheSumOfTheLatestValues) {
  IncrementalSum sum;
  EXPECT_EQ(sum.total(), 0.0);
  double expected = 0.0;
  for (std::size_t n = 1; n <= 70; ++n) {
    sum.resize(n);
    sum.set(n - 1, static_cast<double>(n));
    expected += static_cast<double>(n);
    const std::size_t again = n / 3;
    expected += 5.0 - sum[again];
    sum.set(again, 5.0);
    if (n % 4 != 0) continue;  // several changes per sum
    EXPECT_EQ(sum.total(), expected) << n;
  }
  sum.resize(3);
  EXPECT_EQ(sum.total(), sum[0] + sum[1] + sum[2]);
  sum.resize(40);
  EXPECT_EQ(sum[39], 0.0);
  EXPECT_EQ(sum.total(), sum[0] + sum[1] + sum[2]);
}

TEST(IncrementalSum, KeepsNoRoundingErrorsOfReplacedValues) {
  IncrementalSum sum;
  sum.resize(5);
  sum.set(1, 1e-3);
  sum.set(3, 1e20);
  EXPECT_EQ(sum.total(), 1e20);
  sum.set(3, 0.0);
  EXPECT_EQ(sum.total(), 1e-3);
}

}  // namespace
}  // namespace wayfare
