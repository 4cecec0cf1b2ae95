// Foot-mounted recordings.

#include <algorithm>
#include <cstdio>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/core/statistics.hpp>

#include "foot_recordings.hpp"
#include "io/support.hpp"

namespace wayfare {
namespace {

// A zero-velocity filter with one threshold has 0.37 m mean and 0.145 m median on these; with a
// threshold per trial, chosen by the truth, 0.059 m. The gyros of this unit saturate at ±500 °/s.
TEST(FootRecordings, PyShoeWithOneSetting) {
  WAYFARE_NEEDS_RECORDING(file, "pdr/pyshoe_vicon/2017-11-22-11-22-46.f32.gz");
  for (const auto statistic : {StanceStatistic::shoe, StanceStatistic::ared}) {
    FootParameters p;
    p.rate_range = 8.7;
    p.statistic = statistic;
    std::vector<double> ends, horizontal;
    for (const auto& path : testing::files_in(testing::folder_of(file))) {
      const auto r = testing::read_foot(path, 200.0);
      ASSERT_TRUE(r) << path;
      const auto e = testing::end_error(testing::run_foot(r->samples, p), *r);
      ends.push_back(e.end_m);
      horizontal.push_back(e.horizontal_m);
    }
    ASSERT_EQ(ends.size(), 28U);
    const Summary s = summarise(ends), h = summarise(horizontal);
    std::printf("%s: end mean %.3f median %.3f largest %.3f; horizontal %.3f %.3f %.3f m\n",
                statistic == StanceStatistic::shoe ? "SHOE" : "ARED", s.mean, s.median, s.max,
                h.mean, h.median, h.max);
    EXPECT_LE(s.mean, 0.15);
    EXPECT_LE(s.median, 0.10);
  }
}

// Loops closed to within a centimetre. The parameters of rest were chosen on every other one (+).
TEST(FootRecordings, OpenShoeLoops) {
  WAYFARE_NEEDS_RECORDING(file, "pdr/openshoe2010/Measurement_100521_33.f32.gz");
  std::vector<double> ends;
  for (const auto& path : testing::files_in(testing::folder_of(file))) {
    const auto r = testing::read_foot(path, 250.0);
    ASSERT_TRUE(r) << path;
    ends.push_back(testing::run_foot(r->samples, {}).back().position_m.norm());
    std::printf("%s %s: %.3f m\n", ends.size() % 2 == 1 ? "+" : " ",
                std::filesystem::path(path).filename().c_str(), ends.back());
    EXPECT_LE(ends.back(), 0.25);
  }
  ASSERT_EQ(ends.size(), 6U);
  const Summary s = summarise(ends);
  std::printf("mean %.3f median %.3f largest %.3f m\n", s.mean, s.median, s.max);
}

// Not used for choosing parameters: two loops of 25 m and 60 m.
TEST(FootRecordings, XioLoops) {
  WAYFARE_NEEDS_RECORDING(file, "pdr/xio_gait/short_walk.f32.gz");
  for (const auto& path : testing::files_in(testing::folder_of(file))) {
    const auto table = io::read_float_table(path);
    ASSERT_TRUE(table) << path;
    ASSERT_EQ(table->columns, 7U);
    std::vector<ImuSample> samples;
    for (std::size_t i = 0; i < table->rows(); ++i) {
      const auto row = table->row(i);
      constexpr double kDegree = std::numbers::pi / 180.0;
      samples.push_back({LogTime::from_nanoseconds(std::llround(double(row[0]) * 1e9)),
                         kDegree * Eigen::Vector3d(row[1], row[2], row[3]),
                         9.80665 * Eigen::Vector3d(row[4], row[5], row[6])});
    }
    const auto poses = testing::run_foot(samples, {});
    double length = 0.0;
    for (std::size_t i = 1; i < poses.size(); ++i)
      length += (poses[i].position_m - poses[i - 1].position_m).head<2>().norm();
    const double end = poses.back().position_m.norm();
    std::printf("%s: %.3f m after %.1f m\n", std::filesystem::path(path).filename().c_str(), end,
                length);
    EXPECT_LT(end, 0.02 * length);
  }
}

}  // namespace
}  // namespace wayfare
