// Solutions in RTKLIB's format, written by us, as its library reads them.

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/core/geodesy.hpp>
#include <wayfare/core/random.hpp>
#include <wayfare/gnss/gps_time.hpp>
#include <wayfare/io/text_file.hpp>
#include <wayfare/io/track_formats.hpp>
#include "io/support.hpp"
#include "rtklib.hpp"

namespace wayfare {
namespace {

std::vector<GnssFix> random_fixes(Rng& rng) {
  std::vector<GnssFix> fixes;
  for (int i = 0; i < 200; ++i) {
    GnssFix fix;
    fix.time = log_time(gps_time(2300 + i, std::chrono::milliseconds(rng.below(604'800'000))));
    fix.position = {Angle::degrees(178.0 * rng.uniform() - 89.0),
                    Angle::degrees(358.0 * rng.uniform() - 179.0), 3000.0 * rng.uniform()};
    Eigen::Matrix3d root;
    for (double& v : root.reshaped()) v = rng.normal();
    fix.position_covariance_ned_m2 = root * root.transpose() + 0.01 * Eigen::Matrix3d::Identity();
    fix.velocity_ned_mps = Eigen::Vector3d(20.0 * rng.normal(), 20.0 * rng.normal(), rng.normal());
    fixes.push_back(fix);
  }
  return fixes;
}

TEST(RtklibPos, ReadsOurSolutionsInBothAxes) {
  Rng rng(11);
  const auto fixes = random_fixes(rng);
  for (const io::PosAxes axes : {io::PosAxes::geodetic, io::PosAxes::earth_fixed}) {
    const testing::TemporaryFolder folder;
    std::string path = folder / "ours.pos";
    ASSERT_TRUE(io::write_file(path, io::format_rtklib_pos(fixes, {}, axes)));
    const std::shared_ptr<solbuf_t> theirs(new solbuf_t{}, [](solbuf_t* s) {
      freesolbuf(s);  // of its content alone
      delete s;
    });
    char* files[] = {path.data()};
    ASSERT_EQ(readsol(files, 1, theirs.get()), 1);
    ASSERT_EQ(theirs->n, 200);
    for (std::size_t i = 0; i < fixes.size(); ++i) {
      const sol_t& s = theirs->data[i];
      const WeekTime w = week_time(gps_time(fixes[i].time));
      const gtime_t t = gpst2time(w.week, to_seconds(w.of_week));
      EXPECT_EQ(s.time.time, t.time);
      EXPECT_NEAR(s.time.sec, t.sec, 1e-6);
      EXPECT_EQ(s.stat, 5);
      const Eigen::Matrix3d R = rotation_ecef_ned(fixes[i].position);
      const Eigen::Vector3d p = ecef_from_geodetic(fixes[i].position);
      EXPECT_LT((Eigen::Map<const Eigen::Vector3d>(s.rr) - p).norm(), 2e-4);
      const Eigen::Vector3d v = R * *fixes[i].velocity_ned_mps;
      EXPECT_LT((Eigen::Map<const Eigen::Vector3d>(s.rr + 3) - v).norm(), 2e-4);
      const Eigen::Matrix3d P = R * fixes[i].position_covariance_ned_m2 * R.transpose();
      const double xyz[] = {P(0, 0), P(1, 1), P(2, 2), P(0, 1), P(1, 2), P(2, 0)};
      // Six roots to 5e-5 m each: 2 σ 5e-5 m, σ below 4 m; float beyond that.
      for (int k = 0; k < 6; ++k) EXPECT_NEAR(double{s.qr[k]}, xyz[k], 2e-3) << i << ' ' << k;
    }
  }
}

}  // namespace
}  // namespace wayfare
