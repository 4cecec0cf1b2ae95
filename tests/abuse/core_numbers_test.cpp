// Times, angles, statistics and random numbers at the ends of their ranges.

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/core/angle.hpp>
#include <wayfare/core/geodesy.hpp>
#include <wayfare/core/pack.hpp>
#include <wayfare/core/random.hpp>
#include <wayfare/core/statistics.hpp>
#include <wayfare/core/time.hpp>

#include "abuse/abuse.hpp"

namespace wayfare::tests {
namespace {

constexpr std::int64_t kFirstNs = std::numeric_limits<std::int64_t>::min();
constexpr std::int64_t kLastNs = std::numeric_limits<std::int64_t>::max();

__extension__ using Wide = __int128;

std::int64_t saturated(Wide x) {
  return x < kFirstNs ? kFirstNs : x > kLastNs ? kLastNs : static_cast<std::int64_t>(x);
}

// Any 64 bits, near the ends more often than not.
std::int64_t any_nanoseconds(Rng& rng) {
  const auto bits = static_cast<std::int64_t>(rng());
  switch (rng.below(4)) {
    case 0:
      return kFirstNs + static_cast<std::int64_t>(rng.below(1000));
    case 1:
      return kLastNs - static_cast<std::int64_t>(rng.below(1000));
    case 2:
      return bits / 1'000'000'000;
    default:
      return bits;
  }
}

TEST(TimeAbuse, SumsAndDifferencesEndAtTheRange) {
  Rng rng(1);
  for (int i = 0; i < 20000; ++i) {
    const std::int64_t a = any_nanoseconds(rng), b = any_nanoseconds(rng);
    const LogTime s = LogTime::from_nanoseconds(a), t = LogTime::from_nanoseconds(b);
    ASSERT_EQ((s - t).count(), saturated(Wide{a} - b)) << a << ' ' << b;
    ASSERT_EQ((s + Duration(b)).nanoseconds(), saturated(Wide{a} + b)) << a << ' ' << b;
    ASSERT_EQ((s - Duration(b)).nanoseconds(), saturated(Wide{a} - b)) << a << ' ' << b;
    LogTime moved = s;
    moved += Duration(b);
    ASSERT_EQ(moved, s + Duration(b));
  }
}

TEST(TimeAbuse, TheNextInstantOfAGridAsByCounting) {
  Rng rng(2);
  for (int i = 0; i < 20000; ++i) {
    const std::int64_t grid = any_nanoseconds(rng), time = any_nanoseconds(rng);
    const std::int64_t period = 1 + static_cast<std::int64_t>(rng() >> (1 + rng.below(62)));
    const Wide steps = grid > time ? 0 : (Wide{time} - grid) / period + 1;
    const LogTime next = next_on_grid(LogTime::from_nanoseconds(grid), Duration(period),
                                      LogTime::from_nanoseconds(time));
    ASSERT_EQ(next.nanoseconds(), saturated(grid + steps * period))
        << grid << ' ' << period << ' ' << time;
  }
}

TEST(TimeAbuse, SecondsOfAnySizeAreAnInstant) {
  for (const double s : {kInf, -kInf, kHuge, -kHuge, 1e9, -1e9, 9.3e9, -9.3e9, kTiny, -0.0}) {
    const LogTime t = LogTime::from_seconds(s);
    EXPECT_NEAR(t.seconds(), std::clamp(s, -9223372036.854775807, 9223372036.854775807), 1e-6);
    EXPECT_EQ(from_seconds(s), t.since_epoch());
  }
}

TEST(AngleAbuse, WrapsWhatIsFiniteAndNothingElse) {
  Rng rng(3);
  for (int i = 0; i < 20000; ++i) {
    const double angle =
        std::ldexp(rng.uniform(-1.0, 1.0), static_cast<int>(rng.below(2000)) - 1000);
    const double wrapped = wrap_to_pi(angle);
    ASSERT_TRUE(wrapped > -std::numbers::pi && wrapped <= std::numbers::pi) << angle;
    ASSERT_EQ(wrap_to_pi(wrapped), wrapped);
  }
  for (const double odd : kNotFinite) {
    EXPECT_TRUE(std::isnan(wrap_to_pi(odd)));
    EXPECT_TRUE(std::isnan(Angle::degrees(odd).wrapped().radians()));
  }
}

TEST(StatisticsAbuse, OfValuesThatAreNotNumbersAreNaN) {
  const std::vector<double> nan{3.0, kNan, 1.0, 2.0, kNan, -7.0};
  for (const std::vector<double>& values : {nan, {kNan}, {}}) {
    EXPECT_TRUE(std::isnan(median_of(values)));
    for (const double part : {0.0, 0.3, 1.0}) EXPECT_TRUE(std::isnan(quantile(values, part)));
    const Summary s = summarise(values);
    EXPECT_EQ(s.count, values.size());
    for (const double v : {s.mean, s.std, s.rmse, s.median, s.max}) EXPECT_TRUE(std::isnan(v));
  }
}

TEST(StatisticsAbuse, InfiniteHugeEqualAndSingleValuesHaveTheirOrder) {
  EXPECT_EQ(median_of({kInf, -kInf, 2.0}), 2.0);
  EXPECT_EQ(median_of({kInf}), kInf);
  EXPECT_EQ(quantile({kInf, -kInf, 2.0}, 1.0), kInf);
  EXPECT_EQ(quantile({kInf, -kInf, 2.0}, 0.0), -kInf);
  EXPECT_EQ(median_of(std::vector<double>(9999, kHuge)), kHuge);
  EXPECT_EQ(summarise(std::vector<double>{-kInf, kInf}).max, kInf);
  EXPECT_EQ(upper_median_of(std::vector<double>{}), 0.0);
  std::vector<double> one{kInf};
  EXPECT_EQ(upper_median_of(one), kInf);
}

TEST(StatisticsDeathTest, AShareOutsideZeroToOneViolatesThePrecondition) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  for (const double part : {-0.1, 1.1, kNan})
    EXPECT_DEATH((void)quantile({1.0, 2.0}, part), "share");
}

TEST(ChiSquareAbuse, EndsForAnyNumberOfDegreesOfFreedom) {
  for (const double dof : {kTiny, 1e-3, 1.0, 1e6, 9e8, 1.1e9, 1e12, kHuge, kInf}) {
    SCOPED_TRACE(dof);
    for (const double x : {0.0, kTiny, 1.0, dof, kHuge, kInf}) {
      const double p = chi_square_probability(x, dof);
      EXPECT_TRUE(p >= 0.0 && p <= 1.0 + 1e-9) << x << ' ' << p;
    }
    EXPECT_EQ(chi_square_probability(-kInf, dof), 0.0);
    EXPECT_TRUE(std::isnan(chi_square_probability(kNan, dof)));
  }
  for (const double dof : {9e8, 1.1e9, 1e12}) {
    EXPECT_NEAR(chi_square_probability(dof, dof), 0.5, 1e-4) << dof;
    EXPECT_NEAR(chi_square_quantile(0.9, dof) / dof, 1.0, 1e-3) << dof;
    // The normal approximation of the whole.
    EXPECT_NEAR(chi_square_probability(dof + 2.0 * std::sqrt(2.0 * dof), dof), 0.97725, 1e-4);
  }
}

TEST(RngAbuse, EveryBoundAndEverySeedWork) {
  for (const std::uint64_t seed : {std::uint64_t{0}, std::uint64_t{1}, Rng::max()}) {
    Rng rng = Rng(seed).stream(Rng::max());
    for (const std::uint64_t n :
         {std::uint64_t{1}, std::uint64_t{2}, (std::uint64_t{1} << 63) + 1, Rng::max()})
      for (int i = 0; i < 100; ++i) ASSERT_LT(rng.below(n), n);
    for (int i = 0; i < 1000; ++i) ASSERT_TRUE(std::isfinite(rng.normal()));
    EXPECT_EQ(rng.uniform(3.0, 3.0), 3.0);
  }
  Rng source(5);
  (void)source.normal();  // the second of a pair is kept
  expect_value_semantics(source, [](Rng& r) {
    return std::array<double, 3>{r.normal(), r.uniform(), static_cast<double>(r())};
  });
}

TEST(GeodesyAbuse, AnyFinitePointHasCoordinatesAndNothingElse) {
  Rng rng(4);
  for (int i = 0; i < 5000; ++i) {
    Eigen::Vector3d p;
    for (double& x : p) x = rng.below(5) == 0 ? 0.0 : rng.uniform(-1.0, 1.0);
    p *= std::pow(10.0, rng.uniform(-300.0, 290.0));
    const Geodetic g = geodetic_from_ecef(p);
    ASSERT_TRUE(std::isfinite(g.height_m)) << p.transpose();
    ASSERT_LE(std::abs(g.latitude.radians()), 0.5 * std::numbers::pi) << p.transpose();
    ASSERT_LE(std::abs(g.longitude.radians()), std::numbers::pi) << p.transpose();
  }
  for (const double odd : kNotFinite) {
    const Geodetic g = geodetic_from_ecef({odd, 1.0, 2.0});
    EXPECT_FALSE(std::isfinite(g.height_m));
    EXPECT_FALSE(ecef_from_geodetic({Angle::radians(odd), Angle{}, 0.0}).allFinite());
    EXPECT_FALSE(LocalTangentPlane({Angle::radians(odd), Angle{}, 0.0}).ecef_m().allFinite());
  }
}

TEST(GeodesyAbuse, ThePolesAndTheCentreAreReturnedAsThemselves) {
  for (const double z : {6.4e6, -6.4e6, 1e9}) {
    const Geodetic pole = geodetic_from_ecef({0.0, 0.0, z});
    EXPECT_NEAR(std::abs(pole.latitude.degrees()), 90.0, 1e-12);
    EXPECT_NEAR(ecef_from_geodetic(pole).z(), z, 1e-6);
  }
  EXPECT_NEAR(std::abs(geodetic_from_ecef(Eigen::Vector3d::Zero()).latitude.degrees()), 90.0, 1e-9);
  const Geodetic near{Angle::degrees(89.0), Angle::degrees(180.0), 0.0};
  const Geodetic back = geodetic_from_ned(ned_from_geodetic(near, near), near);
  EXPECT_NEAR(back.height_m, 0.0, 1e-6);
  // An offset across the date line.
  const LocalTangentPlane plane({Angle::degrees(10.0), Angle::degrees(179.9999), 0.0});
  EXPECT_LT(plane.offset({Angle::degrees(10.0), Angle::degrees(-179.9999), 0.0}).norm(), 30.0);
}

TEST(PackAbuse, LanesThatAreNotNumbersDoNotChangeTheirNeighbours) {
  using Four = Pack<double, 4>;
  Four odd(1.0);
  for (int i = 0; i < 3; ++i) odd.set(i, kNotFinite[static_cast<std::size_t>(i)]);
  const auto finite = is_finite(odd);
  for (int i = 0; i < 3; ++i) EXPECT_FALSE(finite[i]);
  EXPECT_TRUE(finite[3]);
  EXPECT_TRUE(any(finite));
  EXPECT_FALSE(all(finite));
  const Four mended = select(finite, odd, Four(7.0));
  for (int i = 0; i < 3; ++i) EXPECT_EQ(mended[i], 7.0);
  for (const Four& f :
       {sqrt(odd), exp(odd), odd * odd + odd, abs(odd), floor(odd), atan2(odd, odd)})
    EXPECT_TRUE(std::isfinite(f[3]));
}

TEST(NumbersAbuse, TwoThreadsCountTheSame) {
  const auto both = in_two_threads([](int) {
    Rng rng(9);
    std::vector<double> values;
    for (int i = 0; i < 2000; ++i)
      values.push_back(wrap_to_pi(rng.normal(0.0, 1e6)) + chi_square_quantile(rng.uniform(), 3.0));
    values.push_back(median_of(values));
    return values;
  });
  EXPECT_EQ(both[0], both[1]);
}

}  // namespace
}  // namespace wayfare::tests
