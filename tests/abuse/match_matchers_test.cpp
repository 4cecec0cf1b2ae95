// Every matcher at the border of what it takes.

#include <cmath>
#include <optional>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Eigenvalues>

#include <wayfare/match/correlative.hpp>
#include <wayfare/match/gauss_newton.hpp>
#include <wayfare/match/registration.hpp>

#include "abuse/abuse.hpp"
#include "abuse/map_cases.hpp"

namespace wayfare::tests {
namespace {

struct BicubicMatcher : GaussNewtonMatcher {
  BicubicMatcher() : GaussNewtonMatcher({.interpolation = Interpolation::bicubic}) {}
};
struct MultiStartMatcher : GaussNewtonMatcher {
  MultiStartMatcher() : GaussNewtonMatcher({.start_step = Angle::degrees(5)}) {}
};

template <class M>
class EveryMatchersLimits : public ::testing::Test {
 protected:
  using Map = typename M::Map;
  using Found = Result<std::optional<MatchResult>>;

  Found match(const PointSet& points, const SE2d& prior = pose_in_room(1),
              const SearchWindow& window = kSmall, const MatchOptions& options = kAll) {
    return matcher_.match(map_, points, prior, window, options);
  }
  /// A result is made of numbers, and within what was asked for.
  void expect_sound(const Found& found, const SE2d& prior, const SearchWindow& window) {
    ASSERT_TRUE(found) << found.error().to_string();
    if (!*found) return;
    const MatchResult& m = **found;
    const Eigen::Vector2d d = m.T_map_points.translation() - prior.translation();
    EXPECT_LE(std::abs(d.x()), window.half_x_m + 0.11 + 1e-9 * prior.translation().norm());
    EXPECT_LE(std::abs(d.y()), window.half_y_m + 0.11 + 1e-9 * prior.translation().norm());
    EXPECT_TRUE(std::isfinite(m.T_map_points.heading().radians()));
    EXPECT_TRUE(std::isfinite(m.mean_log_likelihood));
    EXPECT_TRUE(m.mean_log_likelihood <= 1e-9) << m.mean_log_likelihood;
    EXPECT_TRUE(m.score >= -1e-9 && m.score <= 1 + 1e-9) << m.score;
    if (!m.covariance) return;
    EXPECT_TRUE(m.covariance->allFinite()) << *m.covariance;
    EXPECT_GT(Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(*m.covariance).eigenvalues()[0], 0.0)
        << *m.covariance;
    ASSERT_TRUE(m.constraint);
    EXPECT_TRUE(m.constraint->weakest.allFinite());
    EXPECT_TRUE(m.constraint->share >= 0 && m.constraint->share <= 0.5 + 1e-9);
    EXPECT_TRUE(std::isfinite(m.constraint->displacement_cost_nats));
  }
  static inline const SearchWindow kSmall{0.3, 0.3, Angle::degrees(6)};
  static inline const MatchOptions kAll{.covariance = true};

  M matcher_;
  Map map_ = make<Map>(3);
};

using EveryMatcher = ::testing::Types<CorrelativeMatcher, BranchAndBoundMatcher, GaussNewtonMatcher,
                                      BicubicMatcher, MultiStartMatcher, IcpMatcher, NdtMatcher>;
TYPED_TEST_SUITE(EveryMatchersLimits, EveryMatcher, );

TYPED_TEST(EveryMatchersLimits, RefusesEmptyMapsAndPoints) {
  typename TypeParam::Map moved = make<typename TypeParam::Map>(1);
  const auto taken = std::move(moved);
  // NOLINTNEXTLINE(bugprone-use-after-move): what the test is about
  for (const typename TypeParam::Map& empty : {typename TypeParam::Map(), moved}) {
    const auto found =
        this->matcher_.match(empty, points_in_room(0), SE2d(), this->kSmall, this->kAll);
    ASSERT_FALSE(found);
    EXPECT_FALSE(found.error().to_string().empty());
  }
  EXPECT_FALSE(this->match(PointSet()));
  EXPECT_FALSE(this->match(points_at({{kNanF, 0}})));
  EXPECT_FALSE(this->match(points_at({{0, 0}, {0, -kInfF}})));
  for (const double bad : kNotFinite) {
    EXPECT_FALSE(this->match(points_in_room(1), SE2d(bad, 0, Angle())));
    EXPECT_FALSE(this->match(points_in_room(1), SE2d(0, 0, Angle::radians(bad))));
  }
  this->expect_sound(this->match(points_in_room(1)), pose_in_room(1), this->kSmall);
}

TYPED_TEST(EveryMatchersLimits, OnePointTwoAndEqualPoints) {
  for (const std::size_t n : {1U, 2U, 3U, 15U, 16U, 17U, 1000U})
    for (const Eigen::Vector2f& p :
         {Eigen::Vector2f(0, 0), Eigen::Vector2f(1, 1), points_in_room(1)[5]}) {
      SCOPED_TRACE(n);
      const PointSet points = points_at(std::vector<Eigen::Vector2f>(n, p));
      this->expect_sound(this->match(points), pose_in_room(1), this->kSmall);
    }
}

TYPED_TEST(EveryMatchersLimits, PointsAndPosesFarAway) {
  for (const float far : {1e3F, 1e9F, 1e20F, 3e38F}) {
    SCOPED_TRACE(far);
    const PointSet alone = points_at({{far, -far}});
    PointSet beside = points_in_room(1);
    beside.push_back({-far, far});
    // Nothing far away is in the map. Where the farthest point sets the heading steps, the window
    // may be too large for it.
    for (const PointSet& points : {alone, beside}) {
      const auto found = this->match(points);
      if (found || far < 1e6F) this->expect_sound(found, pose_in_room(1), this->kSmall);
      const SearchWindow no_turn{0.2, 0.2, Angle()};
      this->expect_sound(this->match(points, pose_in_room(1), no_turn), pose_in_room(1), no_turn);
    }
    // The pose and the points cancel, as far as numbers allow.
    const SE2d prior(static_cast<double>(far), 0.0, Angle());
    this->expect_sound(this->match(points_in_room(1), prior), prior, this->kSmall);
    const SearchWindow still{0.0, 0.0, Angle()};
    this->expect_sound(this->match(points_at({{-far, 0.0F}}), prior, still), prior, still);
  }
  for (const double far : {kHuge, -kHuge, 1e308}) {
    const SE2d prior(far, far, Angle::radians(1e9));
    this->expect_sound(this->match(points_in_room(1), prior), prior, this->kSmall);
  }
}

TYPED_TEST(EveryMatchersLimits, WindowsOfNothingAndOfEverything) {
  const PointSet points = points_in_room(1);
  const SE2d at = pose_in_room(1);
  const SearchWindow nothing{0.0, 0.0, Angle()};
  this->expect_sound(this->match(points, at, nothing), at, nothing);
  const SearchWindow tiny{kTiny, kTiny, Angle::radians(kTiny)};
  this->expect_sound(this->match(points, at, tiny), at, tiny);
  for (const double bad : {kNan, -kTiny, -1.0, -kInf}) {
    EXPECT_FALSE(this->match(points, at, {bad, 1, Angle()}));
    EXPECT_FALSE(this->match(points, at, {1, bad, Angle()}));
    EXPECT_FALSE(this->match(points, at, {1, 1, Angle::radians(bad)}));
  }
  // An exhaustive search refuses what it cannot finish; an iteration takes the limits as they are.
  for (const double huge : {1e4, 1e9, kHuge, kInf}) {
    const SearchWindow window{huge, huge, Angle::radians(huge)};
    const auto found = this->match(points, at, window);
    if (found) this->expect_sound(found, at, window);
  }
  for (const double turn : {3.15, 7.0, 1e9, kInf}) {
    const SearchWindow window{0.1, 0.1, Angle::radians(turn)};
    this->expect_sound(this->match(points, at, window), at, window);
  }
}

TYPED_TEST(EveryMatchersLimits, PriorInformation) {
  const PointSet points = points_in_room(1);
  const SE2d at = pose_in_room(1);
  MatchOptions options = this->kAll;
  const auto found = [&](const Eigen::Matrix3d& information) {
    options.prior_information = information;
    return this->match(points, at, this->kSmall, options);
  };
  using Eigen::Matrix3d, Eigen::Vector3d;
  const auto without = this->match(points), zero = found(Matrix3d::Zero());
  this->expect_sound(zero, at, this->kSmall);
  ASSERT_TRUE(without && *without && *zero);
  EXPECT_EQ((*zero)->T_map_points.translation(), (*without)->T_map_points.translation());
  EXPECT_EQ((*zero)->score, (*without)->score);
  for (const Vector3d& diagonal : {Vector3d(1, 0, 0), Vector3d(0, 0, 1e-300), Vector3d(0, 1e6, 0),
                                   Vector3d(1e12, 1e12, 1e12), Vector3d(1e150, 1, 0)})
    this->expect_sound(found(diagonal.asDiagonal()), at, this->kSmall);
  const Vector3d along(1, -1, 0.3);
  for (const double scale : {1.0, 1e12, 1e150})
    this->expect_sound(found(scale * along * along.transpose()), at, this->kSmall);
  // An information that fixes the pose gives the prior.
  const auto fixed = found(Vector3d::Constant(1e15).asDiagonal());
  ASSERT_TRUE(fixed);
  if (*fixed) {
    EXPECT_LT((*fixed)->T_map_points.minus(at).norm(), 0.01);
  }
  for (const Matrix3d& bad :
       {Matrix3d(Matrix3d::Constant(kNan)), Matrix3d(Vector3d(kInf, 1, 1).asDiagonal()),
        Matrix3d(Vector3d(1, -1, 1).asDiagonal()), Matrix3d(-1e9 * Matrix3d::Identity()),
        Matrix3d(1e308 * (Matrix3d() << 1, -1, 0, -1, 1, 0, 0, 0, 1).finished())})
    EXPECT_FALSE(found(bad)) << bad;
}

TYPED_TEST(EveryMatchersLimits, OtherOptions) {
  const PointSet points = points_in_room(1);
  const SE2d at = pose_in_room(1);
  for (const double n : {0.0, kTiny, 1e-9, 1.0, 1e9, kInf}) {
    SCOPED_TRACE(n);
    MatchOptions options = this->kAll;
    options.independent_points = n;
    this->expect_sound(this->match(points, at, this->kSmall, options), at, this->kSmall);
  }
  EXPECT_FALSE(this->match(points, at, this->kSmall, {.independent_points = kNan}));
  EXPECT_FALSE(this->match(points, at, this->kSmall, {.min_score = kNan}));
  for (const double score : {-kInf, -1.0, 0.0, 1.0}) {
    MatchOptions options = this->kAll;
    options.min_score = score;
    const auto found = this->match(points, at, this->kSmall, options);
    this->expect_sound(found, at, this->kSmall);
    EXPECT_EQ(found->has_value(), score < 1.0) << score;
  }
}

Observed numbers_of(const Result<std::optional<MatchResult>>& found) {
  if (!found) return {-2.0};
  if (!*found) return {-1.0};
  const MatchResult& m = **found;
  const SE2d& T = m.T_map_points;
  Observed out{T.x(),
               T.y(),
               T.rotation().cos(),
               T.rotation().sin(),
               m.score,
               m.mean_log_likelihood,
               static_cast<double>(m.candidates)};
  if (m.covariance) out.insert(out.end(), m.covariance->data(), m.covariance->data() + 9);
  return out;
}

/// A few matches with one matcher, a refused one among them.
template <class M>
Observed some_matches(M& matcher) {
  Observed out;
  const auto map = make<typename M::Map>(3);
  for (int k = 0; k < 4; ++k) {
    const SearchWindow window{0.1 + 0.2 * k, 0.3, Angle::degrees(3.0 + k)};
    const PointSet points = k == 2 ? points_at({{kNanF, 0}}) : points_in_room(k);
    const auto found = matcher.match(map, points, pose_in_room(k), window, {.covariance = true});
    const Observed numbers = numbers_of(found);
    out.insert(out.end(), numbers.begin(), numbers.end());
  }
  return out;
}

TYPED_TEST(EveryMatchersLimits, LifeAndThreads) {
  TypeParam used;
  const Observed expected = some_matches(used);
  EXPECT_GT(expected.size(), 20U);
  expect_value_semantics(used, [](TypeParam& m) { return some_matches(m); });
  TypeParam taken = std::move(used);
  EXPECT_EQ(some_matches(used), expected) << "moved from";  // NOLINT(bugprone-use-after-move)
  const auto both = in_two_threads([&](int) {
    TypeParam own = taken;
    return some_matches(own);
  });
  EXPECT_EQ(both[0], expected);
  EXPECT_EQ(both[1], expected);
}

/// A shared map is read by matchers of two threads.
TYPED_TEST(EveryMatchersLimits, ShareAMap) {
  const auto both = in_two_threads([&](int) {
    TypeParam own;
    return numbers_of(
        own.match(this->map_, points_in_room(1), pose_in_room(1), this->kSmall, this->kAll));
  });
  EXPECT_EQ(both[0], both[1]);
}

TEST(MatchLimits, OptionsOfIterativeMatchers) {
  const PointSet points = points_in_room(1);
  const auto tables = make<ProbabilityPyramid>(3);
  const auto surface = make<SurfaceMap>(3);
  const auto ndt = make<NdtMap>(3);
  const auto refused = [&](const auto& matcher, const auto& map) {
    return !matcher.match(map, points, pose_in_room(1), {}, {.covariance = true});
  };
  for (const double bad : {kNan, 0.0, -1.0, -kInf}) {
    SCOPED_TRACE(bad);
    EXPECT_TRUE(refused(GaussNewtonMatcher({.residual_sigma = bad}), tables));
    EXPECT_TRUE(refused(GaussNewtonMatcher({.point_sigma_m = bad}), tables));
    EXPECT_TRUE(refused(IcpMatcher({.max_correspondence_m = bad}), surface));
    EXPECT_TRUE(refused(IcpMatcher({.sigma_m = bad}), surface));
    EXPECT_TRUE(refused(IcpMatcher({.floor_probability = bad}), surface));
    EXPECT_TRUE(refused(NdtMatcher({.floor_probability = bad}), ndt));
  }
  EXPECT_TRUE(refused(IcpMatcher({.floor_probability = 1.0}), surface));
  EXPECT_TRUE(refused(NdtMatcher({.floor_probability = 1.5}), ndt));
  // No iteration, and one that never ends by its tolerance.
  for (const int iterations : {-1, 0, 500})
    for (const double tolerance : {kNan, 0.0, -1.0, kInf}) {
      EXPECT_FALSE(refused(
          GaussNewtonMatcher({.max_iterations = iterations, .tolerance = tolerance}), tables));
      EXPECT_FALSE(
          refused(IcpMatcher({.max_iterations = iterations, .tolerance = tolerance}), surface));
      EXPECT_FALSE(
          refused(NdtMatcher({.max_iterations = iterations, .tolerance = tolerance}), ndt));
    }
  for (const double step : {kNan, -1.0, kTiny, kInf})
    EXPECT_FALSE(refused(GaussNewtonMatcher({.start_step = Angle::radians(step)}), tables));
  EXPECT_FALSE(refused(IcpMatcher({.max_correspondence_m = kInf}), surface));
  ProbabilityPyramid one_empty = tables;
  one_empty.emplace_back();
  EXPECT_TRUE(refused(GaussNewtonMatcher(), one_empty));
}

/// As many candidates as a surface may have, and one window more.
TEST(MatchLimits, SurfacesOfEveryCandidate) {
  const auto field = make<LikelihoodField>(2);
  CorrelativeMatcher matcher;
  const auto surface = [&](double half, double turn_deg) {
    return matcher.surface(field, points_in_room(0), SE2d(),
                           {half, half, Angle::degrees(turn_deg)});
  };
  EXPECT_EQ(surface(0.0, 0.0)->log_score.size(), 1U);
  ASSERT_TRUE(surface(102.35, 0.0));  // 4095² ≤ 2²⁴
  EXPECT_FALSE(surface(102.45, 0.0));
  EXPECT_FALSE(surface(kInf, 0.0));
  EXPECT_FALSE(surface(10.0, kInf));
  EXPECT_FALSE(matcher.surface(field, points_in_room(0), SE2d(), {-1, 0, Angle()}));
  EXPECT_FALSE(matcher.surface(field, PointSet(), SE2d(), {}));
}

}  // namespace
}  // namespace wayfare::tests
