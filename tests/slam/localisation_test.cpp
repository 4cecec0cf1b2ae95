#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/core/statistics.hpp>
#include <wayfare/sim/simulate_recording.hpp>
#include <wayfare/slam/detail/pose_filter.hpp>
#include <wayfare/slam/localisation.hpp>
#include <wayfare/testing/filter_laws.hpp>

#include "localisation_support.hpp"
#include "slam/localisation/particle_set.hpp"
#include "slam/localisation/scan_weigher.hpp"

namespace wayfare {
namespace {

constexpr const char* kFlat = R"(metres_per_character 0.5
route a b f d f b c g h e h g c b a
picture
#############################
#        #         #        #
# a                    d    #
#           b     f         #
#        #                  #
#        #  c      #        #
#####  ###  g  ###  ####  ###
#           h               #
#                       e   #
#                           #
#############################
)";
const Place& flat() {
  static const Place place = make_place(kFlat, 1);
  return place;
}

/// Root mean square of position, m, and heading, rad, over the outcomes from `first` on.
std::pair<double, double> rmse(const LocalisationRun& result, const Recording& recording,
                               std::size_t first = 0) {
  double position = 0.0, turn = 0.0;
  for (std::size_t i = first; i < result.outcomes.size(); ++i) {
    const Eigen::Vector3d e = error_of(result.outcomes[i], recording);
    position += e.head<2>().squaredNorm();
    turn += e[2] * e[2];
  }
  const auto n = static_cast<double>(result.outcomes.size() - first);
  return {std::sqrt(position / n), std::sqrt(turn / n)};
}

class EveryModel : public ::testing::TestWithParam<ScanLikelihood> {
 protected:
  static LocalisationOptions options() {
    LocalisationOptions options = quick();
    options.model = GetParam();
    if (options.model == ScanLikelihood::beam) options.beams = 30;  // ten times slower than a field
    return options;
  }
};

// 5 cm and 1 degree are the requirement; walls are known to half a cell of 5 cm.
TEST_P(EveryModel, TracksWithinCentimetres) {
  const Recording& recording = flat().recording;
  const auto result = run(recording, flat(), options(), known_start(recording));
  const auto [position, turn] = rmse(result, recording);
  EXPECT_LT(position, 0.05);
  EXPECT_LT(turn, 0.0175);
  for (const LocalisationOutcome& o : result.outcomes) {
    EXPECT_TRUE(o.converged);
    testing::expect_covariance(o.T_map_base.covariance);
  }
  EXPECT_EQ(result.outcomes.back().particles, options().min_particles);
}

TEST_P(EveryModel, LocalisesGlobally) {
  const auto result = run(flat().recording, flat(), options());
  EXPECT_TRUE(result.outcomes.front().searched);
  EXPECT_FALSE(result.outcomes.front().converged);
  expect_found(result, flat().recording);
}

INSTANTIATE_TEST_SUITE_P(Models, EveryModel,
                         ::testing::Values(ScanLikelihood::likelihood_field, ScanLikelihood::beam));

Recording carried(const Recording& recording) {
  const auto at = [&](double u) {
    return recording
        .truth[static_cast<std::size_t>(u * static_cast<double>(recording.truth.size()))]
        .time;
  };
  return sim::kidnapped(recording, at(0.1), at(0.5));
}

TEST(Kidnapped, OdometryContinuesAndTruthJumps) {
  const Recording& whole = flat().recording;
  const Recording r = carried(whole);
  const LogTime lifted = whole.truth[whole.truth.size() / 10].time;
  EXPECT_LT(r.scans.size(), whole.scans.size());
  double worst_odometry = 0.0, worst_truth = 0.0;
  for (std::size_t i = 1; i < r.odometry.size(); ++i) {
    EXPECT_GT(r.odometry[i].time, r.odometry[i - 1].time);
    worst_odometry = std::max(worst_odometry, (r.odometry[i - 1].T_odom_base.raw().inverse() *
                                               r.odometry[i].T_odom_base.raw())
                                                  .translation()
                                                  .norm());
  }
  for (std::size_t i = 1; i < r.truth.size(); ++i)
    worst_truth = std::max(worst_truth,
                           (r.truth[i - 1].T_map_base.raw().inverse() * r.truth[i].T_map_base.raw())
                               .translation()
                               .norm());
  EXPECT_LT(worst_odometry, 0.1);
  EXPECT_GT(worst_truth, 2.0);
  EXPECT_EQ(sim::part_of(r, LogTime{}, lifted).scans.size(),
            sim::part_of(whole, LogTime{}, lifted).scans.size());
}

TEST(Localiser, RecoversFromKidnapping) {
  const Recording recording = carried(flat().recording);
  const auto result = run(recording, flat(), quick(), known_start(recording));
  int moves = 0;
  for (const LocalisationOutcome& o : result.outcomes) moves += o.relocalised ? 1 : 0;
  EXPECT_GE(moves, 1);
  expect_found(result, recording);
}

// Ranges that fit no room: wherever the particles gather, the map contradicts them.
TEST(Localiser, DoesNotConvergeWhereNothingFits) {
  Recording recording = flat().recording;
  const std::size_t out = recording.scans.size() / 3, n = recording.scans.size();
  Rng rng(6);
  for (std::size_t i = out; i < n; ++i)
    for (float& r : recording.scans[i].ranges_m) r = static_cast<float>(rng.uniform(0.5, 5.5));
  const auto result = run(recording, flat(), quick(), known_start(recording));
  std::size_t before = 0, after = 0;
  for (std::size_t i = 0; i < n; ++i)
    (i < out ? before : after) += result.outcomes[i].converged ? 1 : 0;
  EXPECT_EQ(before, out);
  EXPECT_LT(static_cast<double>(after) / static_cast<double>(n - out), 0.1) << after;
}

TEST(Localiser, ReportsASymmetricPlaceAsAmbiguous) {
  const Place place = make_place(kSymmetric, 2);
  int ambiguous = 0;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const auto result = run(place.recording, place, quick(), {}, seed);
    const LocalisationOutcome& last = result.outcomes.back();
    ambiguous += !last.converged && last.clusters >= 2 ? 1 : 0;
  }
  EXPECT_EQ(ambiguous, 4);
}

TEST(Localiser, SameSeedSameBytesForAnyNumberOfThreads) {
  const Recording recording = carried(flat().recording);
  LocalisationOptions options = quick();
  const auto one = run(recording, flat(), options);
  options.threads = 2;
  expect_same(one, run(recording, flat(), options));
  options.threads = 1;
  const auto other = run(recording, flat(), options, {}, 2);
  EXPECT_NE(one.outcomes.back().T_map_base.mean.x(), other.outcomes.back().T_map_base.mean.x());
}

// Ten seconds, five metres and a corner, by odometry alone.
TEST(LocaliserFaults, SurvivesTenSecondsWithoutLidar) {
  Recording recording = flat().recording;
  const LogTime off = recording.scans[40].time, on = off + std::chrono::seconds(10);
  std::erase_if(recording.scans, [&](const LaserScan& s) { return s.time >= off && s.time < on; });
  const auto result = run(recording, flat(), quick(), known_start(recording));
  for (std::size_t i = 41; i < result.outcomes.size(); ++i)
    EXPECT_LT(error_of(result.outcomes[i], recording).head<2>().norm(), 0.3);
  expect_found(result, recording);
}

TEST(LocaliserFaults, IgnoresRangesThatAreNotFinite) {
  Recording recording = flat().recording;
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  for (std::size_t i = 0; i < recording.scans.size(); ++i)
    for (std::size_t k = i % 3; k < recording.scans[i].ranges_m.size(); k += 3)
      recording.scans[i].ranges_m[k] = k % 2 == 0 ? kNan : -kNan;
  for (std::size_t i = 100; i < 110; ++i)
    for (float& r : recording.scans[i].ranges_m) r = kNan;
  for (const ScanLikelihood model : {ScanLikelihood::likelihood_field, ScanLikelihood::beam}) {
    LocalisationOptions options = quick();
    options.model = model;
    const auto result = run(recording, flat(), options, known_start(recording));
    EXPECT_LT(rmse(result, recording).first, 0.05);
    for (std::size_t i = 100; i < 110; ++i) EXPECT_FALSE(result.outcomes[i].weighed);
  }
}

TEST(LocaliserFaults, OdometryThatJumpsIsRefused) {
  Recording recording = flat().recording;
  const LogTime jump = recording.odometry[200].time;
  const SE2d far(40.0, -7.0, 2.0_rad);
  for (OdometrySample& s : recording.odometry)
    if (s.time >= jump)
      s.T_odom_base = Transform2<frame::Odom, frame::Base>(far * s.T_odom_base.raw());
  recording.odometry[60].T_odom_base =
      Transform2<frame::Odom, frame::Base>(SE2d(std::nan(""), 0.0, Angle::radians(std::nan(""))));
  const auto result = run(recording, flat(), quick(), known_start(recording));
  int refused = 0;
  for (const LocalisationOutcome& o : result.outcomes) refused += o.odometry_refused ? 1 : 0;
  EXPECT_GE(refused, 2);
  EXPECT_LE(refused, 8);
  EXPECT_LT(rmse(result, recording).first, 0.06);
  expect_found(result, recording);
}

TEST(LocaliserFaults, WithoutOdometryItPredictsAtConstantVelocity) {
  Recording recording = flat().recording;
  recording.odometry.clear();
  const auto result = run(recording, flat(), quick(), known_start(recording));
  for (const LocalisationOutcome& o : result.outcomes) EXPECT_TRUE(o.odometry_refused);
  expect_found(result, recording);
}

TEST(LocaliserFaults, LateOrDuplicatedScansAreRefusedAndChangeNothing) {
  const Recording& clean = flat().recording;
  Recording recording = clean;
  recording.scans.clear();
  std::size_t extra = 0;
  for (std::size_t i = 0; i < clean.scans.size(); ++i) {
    recording.scans.push_back(clean.scans[i]);
    if (i % 10 == 5) recording.scans.push_back(clean.scans[i]), ++extra;
    if (i % 10 == 7) recording.scans.push_back(clean.scans[i - 3]), ++extra;
  }
  const auto result = run(recording, flat());
  EXPECT_EQ(result.refused_scans, extra);
  EXPECT_EQ(result.first_refusal, "scan 6: a scan not later than the last: late or duplicated");
  expect_same(result, run(clean, flat()));
}

TEST(LocaliserFaults, AnInvalidInitialPoseIsRefused) {
  Localiser localiser(flat().map, quick(), 1);
  Gaussian<SE2d> start = known_start(flat().recording);
  start.covariance(0, 0) = -1.0;
  EXPECT_FALSE(localiser.start_at(start));
  start = known_start(flat().recording);
  start.mean = SE2d(std::nan(""), 0.0, Angle{});
  EXPECT_FALSE(localiser.start_at(start));
  EXPECT_TRUE(localiser.particles().empty());
  LaserScan scan = flat().recording.scans.front();
  scan.bearing_step = Angle::radians(INFINITY);
  EXPECT_FALSE(localiser.add_scan(scan, {}));
  scan = flat().recording.scans.front();
  scan.ranges_m.clear();  // no scan, no estimate
  const auto outcome = localiser.add_scan(scan, {});
  ASSERT_TRUE(outcome);
  EXPECT_FALSE(outcome->converged);
  EXPECT_EQ(outcome->particles, 0U);
}

TEST(LocalisationMap, NeedsWallsAndFreeCells) {
  EXPECT_FALSE(LocalisationMap::make(OccupancyGrid()));
  OccupancyGrid open;
  open.update({0, 0}, LogOdds::from_probability(0.1));
  EXPECT_FALSE(LocalisationMap::make(open));
  OccupancyGrid solid;
  for (int i = 0; i < 9; ++i) solid.update({0, 0}, LogOdds::from_probability(0.9));
  EXPECT_FALSE(LocalisationMap::make(solid));
  open.update({5, 0}, LogOdds::from_probability(0.95));
  const auto map = LocalisationMap::make(open);
  ASSERT_TRUE(map) << map.error().message;
  EXPECT_EQ((*map)->free_cells(), std::vector<Cell>{Cell{}});
}

TEST(RunLocalisation, StopsOnRequestAndRefusesAnEmptyRecording) {
  LocalisationControl control;
  control.progress = [](double fraction) { return fraction < 0.25; };
  control.snapshots_at = {0.0, 0.1, 1.0};
  const auto part = run_localisation(flat().recording, flat().map, quick(), 1, {}, control);
  ASSERT_TRUE(part);
  EXPECT_NEAR(static_cast<double>(part->outcomes.size()) /
                  static_cast<double>(flat().recording.scans.size()),
              0.25, 0.01);
  ASSERT_EQ(part->snapshots.size(), 2U);
  double sum = 0.0;
  for (const PoseParticle& p : part->snapshots[1].particles) sum += p.weight;
  EXPECT_NEAR(sum, 1.0, 1e-9);
  EXPECT_FALSE(run_localisation({}, flat().map, quick(), 1));
}

// No beam returns in a room whose walls are all in reach, where the model has no beam miss one.
TEST(PoseFilter, AScanThatNoParticleCanHaveSeenKeepsTheWeights) {
  LocalisationOptions usual = quick(), sure = quick();
  for (LocalisationOptions* o : {&usual, &sure}) o->model = ScanLikelihood::beam;
  sure.beam.p_missed = 0.0;
  const LaserScan& seen = flat().recording.scans.front();
  LaserScan nothing = seen;
  nothing.ranges_m.assign(seen.ranges_m.size(), seen.max_range_m);
  detail::PoseFilter<ParticleSet, LocalisationMap> filter(flat().map, usual, Rng(1));
  filter.start_at(known_start(flat().recording));
  filter.weigh(ScanWeigher(seen, usual));
  const std::vector<double> weights = filter.particles().log_weights;
  ASSERT_LT(*std::min_element(weights.begin(), weights.end()), weights.front());
  const ScanWeigher impossible(nothing, sure);
  EXPECT_EQ(filter.log_evidence(impossible, true), -std::numeric_limits<double>::infinity());
  filter.weigh(impossible);
  EXPECT_EQ(filter.particles().log_weights, weights);
}

TEST(PoseFilter, OddsStayFiniteWhateverIsImpossible) {
  using detail::log_odds_after;
  constexpr double kInf = std::numeric_limits<double>::infinity();
  EXPECT_EQ(log_odds_after(1.5, -2.0, -3.0), 2.5);
  EXPECT_EQ(log_odds_after(1.5, -kInf, -kInf), 1.5);
  const double sure = log_odds_after(1.5, -2.0, -kInf);
  EXPECT_GT(sure, 1e300);
  EXPECT_TRUE(std::isfinite(sure));
  const double not_so = log_odds_after(sure, -kInf, -2.0);
  EXPECT_LT(not_so, -1e300);
  EXPECT_TRUE(std::isfinite(not_so));
}

// n = χ²(k − 1, 1 − δ) / 2ε, of which (7) of Fox 2003 is Wilson and Hilferty's approximation, good
// to a percent from a few degrees of freedom on.
TEST(KldBound, IsTheChiSquareQuantile) {
  const KldSampling kld;
  for (const std::size_t k : {std::size_t{5}, std::size_t{20}, std::size_t{200}}) {
    const double quantile = chi_square_quantile(0.99, static_cast<double>(k - 1));
    EXPECT_NEAR(kld_bound(k, kld) / (quantile / (2.0 * kld.error)), 1.0, 0.01) << k;
  }
  EXPECT_EQ(kld_bound(1, kld), 1.0);
}

TEST(FindClusters, JoinsAcrossTheHeadingWrapAndSeparatesDistantParticles) {
  ParticleSet set;
  for (int i = 0; i < 10; ++i) set.push_back(SE2d(0.05 * i, 0.0, Angle::degrees(175.0 + i)));
  for (int i = 0; i < 5; ++i) set.push_back(SE2d(5.0, 0.0, Angle::degrees(3.0 * i)));
  const std::vector<double> weights(15, 1.0 / 15.0);
  const auto clusters = detail::clusters_of(set, weights, PoseBins(0.5, 15.0_deg));
  ASSERT_EQ(clusters.size(), 2U);
  EXPECT_NEAR(clusters[0].mass, 10.0 / 15.0, 1e-12);
  EXPECT_EQ(clusters[1].members.size(), 5U);
}

}  // namespace
}  // namespace wayfare
