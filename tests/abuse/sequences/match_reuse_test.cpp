// Matchers that are reused for other maps, points and windows, with refusals, copies and moves in
// between, give what new ones give; the two exhaustive searches agree with each other and with the
// score surface.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>
#include <wayfare/match/correlative.hpp>
#include <wayfare/match/lines.hpp>
#include <wayfare/match/pose_proposal.hpp>

#include "abuse/abuse.hpp"
#include "abuse/map_cases.hpp"
#include "match/scenes.hpp"

namespace wayfare::tests {
namespace {

struct Question {
  LikelihoodField field;
  PointSet points;
  SE2d prior;
  SearchWindow window;
  MatchOptions options;
  bool refused = false;
  std::string text;
};

Question question(Rng& rng) {
  Question q;
  const Cell origin{static_cast<int>(rng.below(40)) - 20, static_cast<int>(rng.below(40)) - 20};
  q.field = random_grid(rng, 1 + static_cast<int>(rng.below(90)),
                        1 + static_cast<int>(rng.below(90)), origin);
  const double reach = rng.uniform(0.1, 3);
  for (std::uint64_t n = 1 + rng.below(rng.below(4) == 0 ? 700 : 40); n > 0; --n)
    q.points.push_back(
        Eigen::Vector2d(rng.uniform(-reach, reach), rng.uniform(-reach, reach)).cast<float>());
  q.prior = SE2d(rng.uniform(-2, 3), rng.uniform(-2, 3), Angle::radians(rng.uniform(-4, 4)));
  q.window = {rng.uniform(0, rng.below(5) == 0 ? 4.0 : 0.8), rng.uniform(0, 0.8),
              Angle::radians(rng.uniform(0, 0.15))};
  q.options.covariance = rng.below(3) == 0;
  if (rng.below(3) == 0) q.options.min_score = rng.uniform(0, 0.5);
  if (rng.below(3) == 0) {
    const Eigen::Matrix3d a = Eigen::Matrix3d::NullaryExpr([&] { return rng.normal(0, 3); });
    q.options.prior_information = a * a.transpose();
    q.options.independent_points = 10;
  }
  const std::uint64_t fault = rng.below(14);
  q.refused = fault < 6;
  if (fault == 0) q.points = PointSet();
  if (fault == 1) q.points.push_back({static_cast<float>(kNan), 0.0F});
  if (fault == 2) q.prior = SE2d(kInf, 0, Angle());
  if (fault == 3) q.window.half_x_m = kInf;
  if (fault == 4) q.field = LikelihoodField();
  if (fault == 5) q.options.prior_information = -Eigen::Matrix3d::Identity();
  std::ostringstream text;
  text << q.points.size() << " points, fault " << fault << ", window " << q.window.half_x_m << " "
       << q.window.half_y_m;
  q.text = text.str();
  return q;
}

Observed numbers_of(const Result<std::optional<MatchResult>>& found) {
  if (!found) return {-2.0};
  if (!*found) return {-1.0};
  const MatchResult& m = **found;
  Observed out{m.T_map_points.x(),
               m.T_map_points.y(),
               m.T_map_points.rotation().sin(),
               m.score,
               1.0 * m.candidate.offset.x,
               1.0 * m.candidate.offset.y,
               1.0 * m.candidate.heading_step,
               static_cast<double>(m.candidates)};
  if (m.covariance) out.insert(out.end(), m.covariance->data(), m.covariance->data() + 9);
  return out;
}

/// Leaves the scratch memory of the next call as a copy has it, as a moved-from object, or as it
/// is.
template <class T>
void copy_or_move_from(T& object, Rng& rng) {
  const std::uint64_t how = rng.below(6);
  if (how == 0) {
    const T copy = object;
    object = copy;
  }
  if (how == 1) const T taken = std::move(object);
}

TEST(MatchSequences, ReusedSearchesAreAsNew) {
  int matched = 0;
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    Rng rng(seed);
    CorrelativeMatcher correlative;
    BranchAndBoundMatcher bounded;
    PrecomputationGrids grids;
    std::string calls;
    for (int call = 0; call < 6; ++call) {
      const Question q = question(rng);
      calls += q.text + "; ";
      SCOPED_TRACE("seed " + std::to_string(seed) + ": " + calls);
      grids.build(q.field);
      const auto one = correlative.match(q.field, q.points, q.prior, q.window, q.options);
      const auto two = bounded.match(grids, q.points, q.prior, q.window, q.options);
      ASSERT_EQ(one.has_value(), !q.refused);
      ASSERT_EQ(two.has_value(), !q.refused);
      ASSERT_EQ(numbers_of(one), numbers_of(CorrelativeMatcher().match(q.field, q.points, q.prior,
                                                                       q.window, q.options)));
      ASSERT_EQ(numbers_of(two),
                numbers_of(BranchAndBoundMatcher().match(PrecomputationGrids(q.field), q.points,
                                                         q.prior, q.window, q.options)));
      if (!q.refused) {
        ASSERT_EQ(one->has_value(), two->has_value());
        if (*one) {
          ASSERT_EQ((*one)->candidate, (*two)->candidate);
        }
        const auto surface = correlative.surface(q.field, q.points, q.prior, q.window, q.options);
        ASSERT_TRUE(surface);
        const double best = *std::max_element(surface->log_score.begin(), surface->log_score.end());
        if (*one && q.options.min_score == 0) {
          ASSERT_NEAR(surface->at((*one)->candidate), best, 1e-9 * (1 + std::abs(best)));
        }
        matched += one->has_value() ? 1 : 0;
      }
      copy_or_move_from(correlative, rng);
      copy_or_move_from(bounded, rng);
    }
  }
  EXPECT_GT(matched, 300);
}

TEST(MatchSequences, ReusedProposalsAreAsNew) {
  for (std::uint64_t seed = 0; seed < 150; ++seed) {
    Rng rng(seed);
    PoseProposal reused;
    for (int call = 0; call < 5; ++call) {
      const Question q = question(rng);
      SCOPED_TRACE("seed " + std::to_string(seed) + ": " + q.text);
      const auto around = [&](double least) {
        const Eigen::Vector3d sigma(least + rng.uniform(0, 0.2), least + rng.uniform(0, 0.2), 0.05);
        return Gaussian<SE2d>{q.prior, sigma.cwiseAbs2().asDiagonal()};
      };
      const auto proposal = around(rng.below(3) == 0 ? 1e-6 : 0.01), motion = around(0.1);
      const PoseProposalOptions options{
          .samples = 100, .headings = 5, .divide_by_proposal = rng.below(2) == 0};
      Rng a = rng.stream(1), b = rng.stream(1);
      PoseProposal fresh;
      const auto got = reused.draw(q.field, q.points, proposal, motion, a, options);
      const auto want = fresh.draw(q.field, q.points, proposal, motion, b, options);
      ASSERT_EQ(got.has_value(), want.has_value());
      if (got) {
        ASSERT_EQ(got->log_evidence, want->log_evidence);
        ASSERT_EQ(got->T_map_points.translation(), want->T_map_points.translation());
        ASSERT_EQ(got->moments.covariance, want->moments.covariance);
        ASSERT_EQ(a(), b()) << "as many numbers drawn";
      }
      copy_or_move_from(reused, rng);
    }
  }
}

TEST(MatchSequences, ReusedDetectorsAreAsNew) {
  for (std::uint64_t seed = 0; seed < 150; ++seed) {
    Rng rng(seed);
    WallDetector reused;
    for (int call = 0; call < 6; ++call) {
      SCOPED_TRACE("seed " + std::to_string(seed) + ", call " + std::to_string(call));
      const Walls walls =
          rng.below(2) == 0 ? Walls::room() : Walls::corridor(Angle::radians(rng.uniform(-3, 3)));
      LaserScan scan = walls.scan(
          SE2d(rng.uniform(-0.5, 0.5), rng.uniform(-0.5, 0.5), Angle::radians(rng.uniform(-3, 3))),
          rng);
      if (rng.below(3) == 0) scan.ranges_m.resize(rng.below(360));
      if (rng.below(6) == 0) scan.bearing_step = Angle::radians(kNotFinite[rng.below(3)]);
      if (rng.below(6) == 0) scan.first_bearing = Angle();
      for (std::uint64_t n = rng.below(30); n > 0 && !scan.ranges_m.empty(); --n)
        scan.ranges_m[rng.below(scan.ranges_m.size())] = static_cast<float>(kNotFinite[n % 3]);
      const std::uint64_t which = rng.below(3);
      CorridorWalls predicted;
      predicted.direction = Angle::radians(rng.uniform(-3, 3));
      predicted.left = Wall{rng.uniform(0.1, 2)};
      const auto look = [&](WallDetector& d) {
        if (which == 0) return d.acquire(scan);
        return which == 1 ? d.search(scan) : d.track(scan, predicted);
      };
      WallDetector fresh;
      const auto got = look(reused), want = look(fresh);
      ASSERT_EQ(got.has_value(), want.has_value());
      if (got) {
        ASSERT_EQ(got->direction, want->direction);
        ASSERT_EQ(got->covariance, want->covariance);
        ASSERT_TRUE(got->covariance.allFinite());
      }
      copy_or_move_from(reused, rng);
    }
  }
}

}  // namespace
}  // namespace wayfare::tests
