#include <wayfare/core/pack.hpp>

#include <cmath>
#include <limits>
#include <utility>

#include <gtest/gtest.h>

#include <wayfare/core/se3.hpp>

namespace wayfare {
namespace {

template <class P>
class PackTest : public ::testing::Test {};
using Packs = ::testing::Types<Pack<double, 1>, Pack<double, 2>, Pack<double, 4>, Pack<double, 8>,
                               Pack<float, 2>, Pack<float, 4>, Pack<float, 8>, Pack<float, 16>>;
TYPED_TEST_SUITE(PackTest, Packs);

/// Different numbers of both signs.
template <class P>
P ramp(double from, double step) {
  P p;
  for (int i = 0; i < P::kLanes; ++i) p.set(i, static_cast<typename P::Lane>(from + step * i));
  return p;
}

TYPED_TEST(PackTest, EveryLaneMatchesTheScalar) {
  using P = TypeParam;
  using T = typename P::Lane;
  const P a = ramp<P>(-2.25, 0.75), b = ramp<P>(0.5, 0.125);
  for (int i = 0; i < P::kLanes; ++i) {
    const T x = a[i], y = b[i];
    // Compilers evaluate functions of constants more accurately than the run-time library.
    const T rounding = 8 * std::numeric_limits<T>::epsilon();
    EXPECT_EQ((a + b)[i], x + y);
    EXPECT_EQ((a - b)[i], x - y);
    EXPECT_EQ((a * b)[i], x * y);
    EXPECT_EQ((a / b)[i], x / y);
    EXPECT_EQ((-a)[i], -x);
    EXPECT_EQ(abs(a)[i], std::abs(x));
    EXPECT_EQ(sqrt(b)[i], std::sqrt(y));
    EXPECT_NEAR(sin(a)[i], std::sin(x), rounding);
    EXPECT_NEAR(cos(a)[i], std::cos(x), rounding);
    EXPECT_NEAR(exp(a)[i], std::exp(x), rounding * std::exp(x));
    EXPECT_NEAR(atan2(a, b)[i], std::atan2(x, y), rounding);
    EXPECT_EQ(floor(a)[i], std::floor(x));
    EXPECT_NEAR(tan(b)[i], std::tan(y), rounding * (1 + std::abs(std::tan(y))));
    EXPECT_NEAR(log(b)[i], std::log(y), rounding);
    EXPECT_EQ(select(a < P(0), a, b)[i], x < T(0) ? x : y);
    EXPECT_EQ((2 * a)[i], T(2) * x);  // scalars are broadcast to all lanes
    P sum = a, difference = a, product = a, quotient = a;
    sum += b;
    difference -= b;
    product *= b;
    quotient /= b;
    EXPECT_EQ(sum[i], x + y);
    EXPECT_EQ(difference[i], x - y);
    EXPECT_EQ(product[i], x * y);
    EXPECT_EQ(quotient[i], x / y);
  }
}

TYPED_TEST(PackTest, ComparesLaneByLane) {
  using P = TypeParam;
  const P a = ramp<P>(-2.25, 0.75);
  const P b = select(a < P(0), a, a * P(2));  // equal below zero, else not smaller
  for (const auto& [left, right] : {std::pair(a, b), std::pair(b, a)})
    for (int i = 0; i < P::kLanes; ++i) {
      const auto x = left[i], y = right[i];
      EXPECT_EQ((left < right)[i], x < y);
      EXPECT_EQ((left <= right)[i], x <= y);
      EXPECT_EQ((left > right)[i], x > y);
      EXPECT_EQ((left >= right)[i], x >= y);
      EXPECT_EQ((left == right)[i], x == y);
      EXPECT_EQ((left != right)[i], x != y);
    }
}

TYPED_TEST(PackTest, MasksAreLaneByLane) {
  using P = TypeParam;
  P a(1.0);
  EXPECT_TRUE(all(a == P(1)));
  a.set(P::kLanes - 1, std::numeric_limits<typename P::Lane>::quiet_NaN());
  EXPECT_TRUE(any(!is_finite(a)));
  EXPECT_FALSE(all(is_finite(a)));
  EXPECT_FALSE(is_finite(a)[P::kLanes - 1]);
  EXPECT_EQ(any(is_finite(a)), P::kLanes > 1);
  MaskOf<P> m(false);
  m.set(0, true);
  EXPECT_TRUE(any(m));
  EXPECT_EQ(all(m), P::kLanes == 1);
  EXPECT_TRUE(all(m || !m));
  EXPECT_FALSE(any(m && !m));
}

// The exponential of small and large rotation vectors in one pack: each lane has its own branch.
TYPED_TEST(PackTest, RotationsAreLaneByLane) {
  using P = TypeParam;
  using T = typename P::Lane;
  const P angle = ramp<P>(1e-6, 0.37);
  const SO3<P> turn = SO3<P>::exp(Eigen::Matrix<P, 3, 1>(P(0.6) * angle, P(0), P(0.8) * angle));
  const Eigen::Matrix<P, 3, 1> moved = turn * Eigen::Matrix<P, 3, 1>(P(1), P(2), P(3));
  for (int i = 0; i < P::kLanes; ++i) {
    const auto expected =
        SO3<T>::exp({T(0.6) * angle[i], T(0), T(0.8) * angle[i]}) * Eigen::Matrix<T, 3, 1>(1, 2, 3);
    for (int k = 0; k < 3; ++k) {
      EXPECT_NEAR(moved[k][i], expected[k], 16 * std::numeric_limits<T>::epsilon());
    }
  }
}

}  // namespace
}  // namespace wayfare
