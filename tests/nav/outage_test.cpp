#include <wayfare/nav/outage.hpp>

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <wayfare/eval/nav_error.hpp>

#include "core/at.hpp"

namespace wayfare::eval {
namespace {

using std::chrono::seconds;
using tests::at;

const Geodetic kOrigin{Angle::degrees(50.0), Angle::degrees(10.0), 100.0};

// North at 10 m/s.
NavState truth(LogTime t) {
  NavState s;
  s.time = t;
  s.position = geodetic_from_ned({10.0 * t.seconds(), 0, 0}, kOrigin);
  s.velocity_ned_mps = {10, 0, 0};
  return s;
}

// Drifts east by half t² divided by one more than the satellites left; the height error is ignored.
Result<NavTrajectory> drifting(const OutageWindow& w) {
  NavTrajectory result;
  for (LogTime t = at(0); t <= at(200); t += from_seconds(0.1)) {
    NavState s = truth(t);
    const double since = std::max(0.0, to_seconds(t - w.begin));
    const double east = 0.5 * since * since / static_cast<double>(w.satellites_left + 1);
    s.position = geodetic_from_ned({0, east, -7.0}, s.position);
    result.push_back(s);
  }
  return result;
}

OutagePlan plan() {
  OutagePlan p;
  p.starts = outage_starts(at(10), at(130), seconds(30), 10);
  return p;
}

TEST(OutageStarts, AreEvenlySpacedAndEndInTime) {
  const auto starts = outage_starts(at(10), at(130), seconds(30), 10);
  ASSERT_EQ(starts.size(), 10U);
  EXPECT_EQ(starts.front(), at(10));
  EXPECT_EQ(starts.back() + seconds(30), at(130));
  for (std::size_t i = 1; i < starts.size(); ++i) EXPECT_EQ(starts[i] - starts[i - 1], seconds(10));
  EXPECT_EQ(outage_starts(at(1), at(90), seconds(30), 1).front(), at(1));
}

TEST(RunOutages, MeasuresADriftInClosedForm) {
  const auto report = run_outages(plan(), drifting, truth);
  ASSERT_TRUE(report) << report.error().to_string();
  for (const double duration : {10.0, 15.0, 20.0, 25.0, 30.0}) {
    for (std::size_t left = 0; left <= 4; ++left) {
      const OutageError& mean = report->mean(from_seconds(duration), left);
      // The last estimate before the end is 0.1 s before it.
      const double t = duration - 0.1, scale = 1.0 / static_cast<double>(left + 1);
      EXPECT_NEAR(mean.end_m, 0.5 * t * t * scale, 1e-3);
      EXPECT_NEAR(mean.max_m, mean.end_m, 1e-12);
      EXPECT_NEAR(mean.distance_m, 10.0 * t, 1e-3);
      // √(mean of t⁴/4) = t²/(2√5), to the order of the sampling.
      EXPECT_NEAR(mean.rmse_m / (0.5 * t * t * scale / std::sqrt(5.0)), 1.0, 0.03);
    }
  }
  EXPECT_EQ(report->courses.size(), 50U);
  EXPECT_EQ(report->cells.size(), 25U);
}

TEST(RunOutages, IsTheSameForAnyNumberOfThreads) {
  OutagePlan one = plan(), four = plan();
  four.threads = 4;
  double last = 0.0;
  const auto a = run_outages(one, drifting, truth);
  const auto b = run_outages(four, drifting, truth, [&](double f) { last = std::max(last, f); });
  for (std::size_t i = 0; i < a->cells.size(); ++i)
    EXPECT_EQ(a->cells[i].mean.rmse_m, b->cells[i].mean.rmse_m);
  EXPECT_EQ(last, 1.0);
}

TEST(RunOutages, PassesErrorsOnAndNeedsEstimates) {
  const auto failing = run_outages(
      plan(),
      [](const OutageWindow& w) -> Result<NavTrajectory> {
        if (w.satellites_left == 2) return Error{ErrorCode::numerical, "broke down"};
        return drifting(w);
      },
      truth);
  ASSERT_FALSE(failing);
  EXPECT_EQ(failing.error().message, "broke down");
  const auto silent = run_outages(
      plan(), [](const OutageWindow&) { return Result<NavTrajectory>(NavTrajectory{}); }, truth);
  ASSERT_FALSE(silent);
  EXPECT_EQ(silent.error().code, ErrorCode::not_found);
}

TEST(OutageTable, HasRowsOfDurationsAndColumnsOfSatelliteCounts) {
  const auto report = run_outages(plan(), drifting, truth);
  const Table table = outage_table(*report, &OutageError::end_m, 1);
  EXPECT_EQ(table.rows().size(), 5U);
  EXPECT_EQ(table.columns().size(), 6U);
  EXPECT_EQ(table.rows()[0][0], "10");
  EXPECT_EQ(table.rows()[0][1], "49.0");  // 9.9² / 2
  EXPECT_EQ(table.rows()[4][1], "447.0");
}

// Satellite n has an elevation of 10°·n at the given azimuth.
CorrectedRange satellite(int number, double elevation_deg) {
  const double e = elevation_deg * M_PI / 180, a = number;
  CorrectedRange r;
  r.satellite = {GnssSystem::gps, static_cast<std::uint8_t>(number)};
  r.position_ecef_m =
      ecef_from_geodetic(kOrigin) +
      rotation_ecef_ned(kOrigin) *
          Eigen::Vector3d(2e7 * Eigen::Vector3d(std::cos(e) * std::cos(a),
                                                std::cos(e) * std::sin(a), -std::sin(e)));
  return r;
}

std::vector<int> numbers(const RangeEpoch& epoch) {
  std::vector<int> result;
  for (const CorrectedRange& r : epoch.satellites) result.push_back(r.satellite.number);
  return result;
}

TEST(MaskSatellites, KeepsTheHighestThroughout) {
  using testing::ElementsAre;
  std::vector<RangeEpoch> epochs;
  for (int t = 0; t <= 4; ++t) {
    // 3 descends from the top, 5 is the second and is missing in one epoch.
    RangeEpoch e{at(t), {satellite(1, 20), satellite(2, 40), satellite(3, 80 - 15 * t)}};
    if (t != 3) e.satellites.push_back(satellite(5, 60));
    epochs.push_back(e);
  }
  const auto left = mask_satellites(epochs, {at(0), at(4), 2}, kOrigin);
  EXPECT_THAT(numbers(left[0]), ElementsAre(1, 2, 3, 5));  // the begin is outside the window
  EXPECT_THAT(numbers(left[1]), ElementsAre(3, 5));
  EXPECT_THAT(numbers(left[2]), ElementsAre(3, 5));
  EXPECT_THAT(numbers(left[3]), ElementsAre(3, 2));
  EXPECT_THAT(numbers(left[4]), ElementsAre(1, 2, 3, 5));
  const auto none = mask_satellites(epochs, {at(0), at(4), 0}, kOrigin);
  EXPECT_TRUE(none[2].satellites.empty());
}

}  // namespace
}  // namespace wayfare::eval
