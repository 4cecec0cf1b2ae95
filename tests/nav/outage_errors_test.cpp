#include <wayfare/nav/outage.hpp>

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include <wayfare/eval/nav_error.hpp>

#include "core/at.hpp"

namespace wayfare::eval {
namespace {

using std::chrono::seconds;
using tests::at;

const Geodetic kCentre{Angle::degrees(48.0), Angle::degrees(9.0), 250.0};

/// Around a circle of 50 m in 20 s.
NavState on_circle(LogTime t) {
  const double phase = 2.0 * std::numbers::pi * t.seconds() / 20.0;
  NavState s;
  s.time = t;
  s.position = geodetic_from_ned({50.0 * std::cos(phase), 50.0 * std::sin(phase), 0.0}, kCentre);
  return s;
}

TEST(OutageWindow, BeginsAndEndsWithWholeEpochs) {
  const OutageWindow w{at(10), at(20), 2};
  EXPECT_FALSE(w.contains(at(10)));
  EXPECT_TRUE(w.contains(at(10) + Duration(1)));
  EXPECT_TRUE(w.contains(at(20) - Duration(1)));
  EXPECT_FALSE(w.contains(at(20)));
}

TEST(DriftDuring, MeasuresDistanceAndErrorFromTheBeginning) {
  NavTrajectory estimates;
  for (int i = 0; i <= 400; ++i) {
    NavState s = on_circle(at(0.1 * i));
    s.position = geodetic_from_ned({3.0, -4.0, 100.0}, s.position);  // the height is ignored
    estimates.push_back(s);
  }
  const auto drift = drift_during({at(4.95), at(25.05), 0}, estimates, on_circle);
  ASSERT_EQ(drift.size(), 201U);  // 5.0 … 25.0
  EXPECT_NEAR(drift.front().time_s, 0.05, 1e-12);
  EXPECT_NEAR(drift.back().time_s, 20.05, 1e-12);
  // Chords of 1.8°, 1 − θ²/24 of the arc: 13 mm on 315 m; the first is half as long.
  EXPECT_NEAR(drift.back().distance_m, 100.0 * std::numbers::pi * 20.05 / 20.0, 0.02);
  for (const DriftPoint& p : drift) EXPECT_NEAR(p.error_m, 5.0, 1e-3);
}

// Errors 2, 1, 5 m: √((4 + 1)/2) over the first two, √10 over all.
TEST(ErrorOf, IsOfTheDriftBeforeTheDuration) {
  const std::vector<DriftPoint> drift = {{1.0, 10.0, 2.0}, {2.0, 21.0, 1.0}, {3.0, 33.0, 5.0}};
  const OutageError two = error_of(drift, seconds(3));  // the third is at its end
  EXPECT_DOUBLE_EQ(two.rmse_m, std::sqrt(2.5));
  EXPECT_EQ(two.max_m, 2.0);
  EXPECT_EQ(two.end_m, 1.0);
  EXPECT_EQ(two.distance_m, 21.0);
  const OutageError all = error_of(drift, seconds(100));
  EXPECT_DOUBLE_EQ(all.rmse_m, std::sqrt(10.0));
  EXPECT_EQ(all.max_m, 5.0);
  EXPECT_EQ(all.end_m, 5.0);
}

TEST(OutageReport, FindsTheMeanOfADurationAndSatelliteCount) {
  OutageReport report;
  for (const int s : {10, 20})
    for (const std::size_t left : {0U, 3U})
      report.cells.push_back({seconds(s), left, {0.1 * s, 0.0, s + 0.5 * double(left), 0.0}});
  EXPECT_EQ(report.mean(seconds(20), 3).end_m, 21.5);
  EXPECT_EQ(report.mean(seconds(10), 0).end_m, 10.0);
  const Table table = outage_table(report, &OutageError::end_m, 1);
  ASSERT_EQ(table.rows().size(), 2U);
  EXPECT_EQ(table.rows()[1], (std::vector<std::string>{"20", "20.0", "21.5"}));
  EXPECT_DEATH((void)report.mean(seconds(15), 0), "no such outage");
}

}  // namespace
}  // namespace wayfare::eval
