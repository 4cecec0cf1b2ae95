#include <wayfare/match/pose_proposal.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "naive_pose_proposal.hpp"
#include "scenes.hpp"

namespace wayfare {
namespace {

Gaussian<SE2d> gaussian(const SE2d& mean, double sx, double sy, double heading, double cross = 0) {
  Gaussian<SE2d> g{mean, Eigen::Vector3d(sx * sx, sy * sy, heading * heading).asDiagonal()};
  g.covariance(0, 2) = g.covariance(2, 0) = cross * sx * heading;
  return g;
}

/// A room seen by 100 beams, and the pose's distribution before and after a match.
struct Question {
  PointSet points;
  LikelihoodField grid;
  SE2d truth{0.3, -0.2, 0.4_rad};
  Gaussian<SE2d> proposal, motion;

  explicit Question(Rng& rng) {
    const PointSet walls = rectangle(3, 2, 400, rng);
    const PlacedPoints placed{&walls, SE2d()};
    grid = *likelihood_field({&placed, 1});
    points = moved(rectangle(3, 2, 100, rng), truth.inverse());
    proposal = gaussian(truth.plus({0.02, 0.01, 0.01}), 0.05, 0.07, 0.02, 0.5);
    motion = gaussian(truth.plus({0.06, -0.05, -0.02}), 0.06, 0.05, 0.03);
  }
};

struct Draws {
  std::array<std::vector<double>, 3> offsets;  ///< of x, y, θ from the truth
  double evidence = 0.0, evidence_variance = 0.0;

  void add(const SE2d& d, double log_evidence) {
    offsets[0].push_back(d.x());
    offsets[1].push_back(d.y());
    offsets[2].push_back(d.heading().radians());
    const double e = std::exp(log_evidence);
    evidence += e;
    evidence_variance += e * e;
  }
  void end() {
    const auto n = static_cast<double>(offsets[0].size());
    evidence /= n;
    evidence_variance = (evidence_variance / n - evidence * evidence) / n;  // of the mean
  }
};

/// Largest distance between two empirical distribution functions.
double kolmogorov_smirnov(std::vector<double> a, std::vector<double> b) {
  std::sort(a.begin(), a.end());
  std::sort(b.begin(), b.end());
  double largest = 0;
  for (std::size_t i = 0, j = 0; i < a.size() && j < b.size();) {
    (a[i] <= b[j] ? i : j) += 1;
    largest = std::max(largest, std::abs(static_cast<double>(i) / static_cast<double>(a.size()) -
                                         static_cast<double>(j) / static_cast<double>(b.size())));
  }
  return largest;
}

constexpr double kIndependent = 12.0;
constexpr int kDraws = 3000;

Draws by_lattice(const Question& q, Rng& rng, const PoseProposalOptions& options) {
  Draws draws;
  PoseProposal lattice;
  for (int i = 0; i < kDraws; ++i) {
    const auto d = lattice.draw(q.grid, q.points, q.proposal, q.motion, rng, options);
    draws.add(q.truth.inverse() * d->T_map_points, d->log_evidence);
  }
  draws.end();
  return draws;
}

// Two samples of n of the same distribution differ by more than 1.95 √(2/n) once in a thousand
// times (Kolmogorov-Smirnov); for these seeds they do not.
TEST(PoseProposal, DrawsFromTheDistributionOfIndependentSamples) {
  Rng rng(3);
  const Question q(rng);
  Draws naive;
  for (int i = 0; i < kDraws; ++i) {
    const auto d = naive_draw(q.grid, q.points, q.proposal, q.motion, rng, 500, kIndependent);
    naive.add(q.truth.inverse() * d.pose, d.log_evidence);
  }
  naive.end();
  PoseProposalOptions options;
  options.independent_points = kIndependent;
  options.reach_sigmas = 3.5;
  const Draws lattice = by_lattice(q, rng, options);
  const double bound = 1.95 * std::sqrt(2.0 / kDraws);
  for (std::size_t axis = 0; axis < 3; ++axis)
    EXPECT_LT(kolmogorov_smirnov(naive.offsets[axis], lattice.offsets[axis]), bound) << axis;
  // The mean of τ is estimated without bias by both; the lattice spreads less.
  EXPECT_NEAR(lattice.evidence, naive.evidence,
              4 * std::sqrt(naive.evidence_variance + lattice.evidence_variance));
  EXPECT_LT(lattice.evidence_variance, naive.evidence_variance);
  // The test has power: it detects a proposal that is three centimetres off.
  Question off = q;
  off.proposal.mean = off.proposal.mean.plus({0.03, 0, 0});
  EXPECT_GT(kolmogorov_smirnov(naive.offsets[0], by_lattice(off, rng, options).offsets[0]), bound);
}

// With a uniform map the draws are from the product of two Gaussians, whose mean, covariance and
// integral are known.
TEST(PoseProposal, IsTheProductOfGaussiansOnAUniformMap) {
  Rng rng(5);
  Question q(rng);
  ASSERT_TRUE(q.grid.reset(0.05, {{-200, -200}, {200, 200}}, 0.5));
  PoseProposalOptions options;
  options.headings = 80;
  options.reach_sigmas = 4.5;
  options.independent_points = kIndependent;
  PoseProposal proposal;
  const auto both = product(q.proposal, q.motion);
  const auto d = proposal.draw(q.grid, q.points, q.proposal, q.motion, rng, options);
  ASSERT_TRUE(both && d);
  EXPECT_LT(d->moments.mean.minus(both->mean).norm(), 1e-3);
  EXPECT_LT((d->moments.covariance - both->covariance).norm(), 0.03 * both->covariance.norm());
  // ∫ N(x; a, A) N(x; b, B) dx = N(a; b, A + B).
  const Gaussian<SE2d> sum{q.motion.mean, q.motion.covariance + q.proposal.covariance};
  EXPECT_NEAR(d->log_evidence, kIndependent * std::log(0.5) + log_density(sum, q.proposal.mean),
              0.02);
  // Without the proposal's density only the motion's remains, whose integral is one.
  options.divide_by_proposal = true;
  q.proposal = q.motion;
  const auto alone = proposal.draw(q.grid, q.points, q.proposal, q.motion, rng, options);
  ASSERT_TRUE(alone);
  EXPECT_NEAR(alone->log_evidence, kIndependent * std::log(0.5), 0.02);
  EXPECT_LT((alone->moments.covariance - q.motion.covariance).norm(),
            0.03 * q.motion.covariance.norm());
}

// A matched scan and accurate wheels give a proposal far narrower than a cell; too few samples in
// it would make the particles' weights random. A Gaussian fills about a fifth of its box of ±3σ, so
// that 500 samples are worth a hundred: a tenth of a nat.
TEST(PoseProposal, IsAsAccurateForAProposalNarrowerThanACell) {
  Rng rng(13);
  Question q(rng);
  q.proposal = gaussian(q.truth.plus({0.003, -0.002, 0.001}), 0.006, 0.004, 0.003, 0.5);
  q.motion = gaussian(q.truth, 0.007, 0.005, 0.004);
  PoseProposalOptions options;
  options.samples = 500;
  options.headings = 20;
  options.independent_points = kIndependent;
  for (const bool divide : {false, true}) {
    options.divide_by_proposal = divide;
    PoseProposal proposal;
    double sum = 0, squares = 0;
    constexpr int kTimes = 200;
    for (int i = 0; i < kTimes; ++i) {
      const double e =
          proposal.draw(q.grid, q.points, q.proposal, q.motion, rng, options)->log_evidence;
      sum += e;
      squares += e * e;
    }
    const double mean = sum / kTimes;
    EXPECT_LT(std::sqrt(squares / kTimes - mean * mean), 0.2) << divide;
  }
  options.divide_by_proposal = false;
  options.reach_sigmas = 3.5;
  Draws naive;
  for (int i = 0; i < kDraws; ++i) {
    const auto d = naive_draw(q.grid, q.points, q.proposal, q.motion, rng, 500, kIndependent);
    naive.add(q.truth.inverse() * d.pose, d.log_evidence);
  }
  naive.end();
  const Draws lattice = by_lattice(q, rng, options);
  const double bound = 1.95 * std::sqrt(2.0 / kDraws);
  for (std::size_t axis = 0; axis < 3; ++axis)
    EXPECT_LT(kolmogorov_smirnov(naive.offsets[axis], lattice.offsets[axis]), bound) << axis;
}

TEST(PoseProposal, IsReproducibleFromTheSeed) {
  Rng rng(7);
  const Question q(rng);
  PoseProposal one, other;
  Rng a(1), b(1);
  for (int i = 0; i < 3; ++i) {
    const auto first = one.draw(q.grid, q.points, q.proposal, q.motion, a);
    const auto second = other.draw(q.grid, q.points, q.proposal, q.motion, b);
    EXPECT_EQ(first->T_map_points.translation(), second->T_map_points.translation());
    EXPECT_EQ(first->log_evidence, second->log_evidence);
  }
}

// The samples are the distribution that the pose was drawn from: their moments are its moments.
TEST(PoseProposal, GivesOutItsSamples) {
  Rng rng(8);
  const Question q(rng);
  PoseProposal proposal;
  EXPECT_TRUE(proposal.samples().empty());
  const auto drawn = proposal.draw(q.grid, q.points, q.proposal, q.motion, rng);
  ASSERT_TRUE(drawn);
  const std::vector<WeightedPose> samples = proposal.samples();
  ASSERT_EQ(static_cast<int>(samples.size()), drawn->samples);
  double sum = 0.0;
  bool is_one = false;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const WeightedPose& s : samples) {
    sum += s.weight;
    mean += s.weight * s.T_map_points.minus(drawn->moments.mean);
    is_one = is_one || s.T_map_points.minus(drawn->T_map_points).norm() < 1e-9;
  }
  EXPECT_NEAR(sum, 1.0, 1e-9);
  EXPECT_LT(mean.norm(), 1e-3);  // of second order in the spread of the headings
  EXPECT_TRUE(is_one) << "the pose drawn is one of the samples";
  EXPECT_FALSE(proposal.draw(q.grid, {}, q.proposal, q.motion, rng));
  EXPECT_TRUE(proposal.samples().empty());
}

// Σ ln p of a thousand points is outside the range of exp.
TEST(PoseProposal, DoesNotUnderflow) {
  Rng rng(9);
  Question q(rng);
  q.proposal.mean = q.motion.mean = SE2d(50, 50, Angle{});
  PoseProposal proposal;
  PointSet many;
  for (int i = 0; i < 2000; ++i) many.push_back(q.points[static_cast<std::size_t>(i) % 100]);
  const auto d = proposal.draw(q.grid, many, q.proposal, q.motion, rng);
  ASSERT_TRUE(d);
  EXPECT_TRUE(std::isfinite(d->log_evidence));
  EXPECT_LT(d->log_evidence, 2000 * q.grid.log_floor() + 20);
}

TEST(PoseProposal, ReportsInvalidInput) {
  Rng rng(11);
  const Question q(rng);
  PoseProposal proposal;
  EXPECT_FALSE(proposal.draw(q.grid, {}, q.proposal, q.motion, rng));
  EXPECT_FALSE(proposal.draw({}, q.points, q.proposal, q.motion, rng));
  Gaussian<SE2d> flat = q.motion;
  flat.covariance(2, 2) = 0;
  const auto no_density = proposal.draw(q.grid, q.points, q.proposal, flat, rng);
  ASSERT_FALSE(no_density);
  EXPECT_NE(no_density.error().message.find("motion"), std::string::npos);
  flat.covariance(2, 2) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(proposal.draw(q.grid, q.points, flat, q.motion, rng));
  PoseProposalOptions none;
  none.samples = 0;
  EXPECT_FALSE(proposal.draw(q.grid, q.points, q.proposal, q.motion, rng, none));
  PointSet bad = q.points;
  bad.push_back({std::numeric_limits<float>::quiet_NaN(), 0});
  const auto with_nan = proposal.draw(q.grid, bad, q.proposal, q.motion, rng);
  ASSERT_FALSE(with_nan);  // as the matchers do
  EXPECT_NE(with_nan.error().message.find("not finite"), std::string::npos);
}

}  // namespace
}  // namespace wayfare
