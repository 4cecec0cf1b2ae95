#include <gtest/gtest.h>

#include <wayfare/sensors/recording.hpp>

namespace wayfare {
namespace {

LaserScan ramp(std::size_t beams) {
  LaserScan scan;
  scan.first_bearing = Angle::degrees(-90.0);
  scan.bearing_step = Angle::degrees(180.0 / static_cast<double>(beams - 1));
  scan.max_range_m = 30.0F;
  for (std::size_t i = 0; i < beams; ++i) scan.ranges_m.push_back(static_cast<float>(i));
  return scan;
}

TEST(Thinning, KeepsBeamsAtTheirBearings) {
  LaserScan scan = ramp(19);  // every 10 deg
  thin(scan, {.beams = 2, .max_range_m = 5.0, .field_of_view_deg = 90.0});
  EXPECT_EQ(scan.ranges_m, (std::vector<float>{5.0F, 7.0F, 9.0F, 11.0F, 13.0F}));
  EXPECT_NEAR(scan.first_bearing.degrees(), -40.0, 1e-9);
  EXPECT_NEAR(scan.bearing_step.degrees(), 20.0, 1e-9);
  EXPECT_EQ(scan.max_range_m, 5.0F);
}

TEST(Thinning, KeepsOneScanOfTwo) {
  Recording recording;
  for (std::size_t i = 0; i < 5; ++i) recording.scans.push_back(ramp(3 + i));
  thin(recording, {.every = 2});
  ASSERT_EQ(recording.scans.size(), 3U);
  EXPECT_EQ(recording.scans[1].ranges_m.size(), 5U);
}

}  // namespace
}  // namespace wayfare
