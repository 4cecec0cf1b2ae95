// Single points of ranges that are direct or reflected.

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include <wayfare/gnss/single_point.hpp>

#include "sky.hpp"

namespace wayfare {
namespace {

class Reflections : public ::testing::Test {
 protected:
  static SinglePointOptions without_air() {
    SinglePointOptions options;
    options.corrections.ionosphere = options.corrections.troposphere = false;
    return options;
  }
  Ephemerides messages_ = testing::sky_messages();
  testing::SkyReceiver receiver_;
  /// The first satellites of GPS.
  ObservationEpoch gps(std::size_t count) const {
    ObservationEpoch e = testing::sky_epoch(messages_, receiver_);
    std::erase_if(e.satellites,
                  [](const auto& o) { return o.satellite.system != GnssSystem::gps; });
    if (e.satellites.size() > count) e.satellites.resize(count);
    return e;
  }
  double error_m(const SinglePoint& p) const {
    return (p.position_ecef_m - ecef_from_geodetic(receiver_.position)).norm();
  }
};

/// Every third satellite is seen by a reflection: weaker, and `excess_m` and up to 40 m farther.
ObservationEpoch reflected(ObservationEpoch e, double excess_m) {
  for (std::size_t i = 0; i < e.satellites.size(); ++i) {
    e.satellites[i].cn0_dbhz = i % 3 == 0 ? 28.0 : 46.0;
    if (i % 3 == 0) e.satellites[i].pseudorange_m += excess_m + static_cast<double>(7 * i % 40);
  }
  return e;
}

TEST_F(Reflections, ReflectedRangesAreToldFromDirectOnes) {
  const ObservationEpoch e = reflected(gps(9), 30.0);
  SinglePointOptions options = without_air();
  options.exclude_faults = false;
  const Result<SinglePoint> plain = single_point(e, messages_, options);
  options.reflections.emplace();
  const Result<SinglePoint> p = single_point(e, messages_, options);
  ASSERT_TRUE(plain && p);
  EXPECT_LT(error_m(*p), 3.0);  // σ of a direct range
  EXPECT_LT(error_m(*p), 0.5 * error_m(*plain));
  for (const SatelliteResidual& r : p->residuals) EXPECT_EQ(r.range_used, r.cn0_dbhz > 40.0);
  EXPECT_TRUE(p->consistent);
  EXPECT_LE(p->horizontal_protection_m, options.alert_limit_m);
  // The same covariance is not good enough for a smaller limit.
  options.alert_limit_m = 0.9 * p->horizontal_protection_m;
  EXPECT_FALSE(single_point(e, messages_, options)->consistent);
  options.answer_inconsistent = false;
  EXPECT_EQ(single_point(e, messages_, options).error().code, ErrorCode::invalid);
}

// Without a range to spare, each may be reflected: the covariance has to allow for it.
TEST_F(Reflections, RangesThatNothingChecksMayBeReflected) {
  ObservationEpoch e = gps(4);
  for (auto& o : e.satellites) o.cn0_dbhz = 28.0;
  SinglePointOptions options = without_air();
  options.reflections.emplace();
  const Result<SinglePoint> weak = single_point(e, messages_, options);
  for (auto& o : e.satellites) o.cn0_dbhz = 48.0;
  const Result<SinglePoint> strong = single_point(e, messages_, options);
  ASSERT_TRUE(weak && strong);
  EXPECT_GT(weak->horizontal_protection_m, 3.0 * strong->horizontal_protection_m);
  EXPECT_GT(weak->vertical_protection_m, 3.0 * strong->vertical_protection_m);
}

TEST_F(Reflections, AModelOfReflectionsThatIsNotUsableIsAnError) {
  for (int i = 0; i < 5; ++i) {
    SinglePointOptions options = without_air();
    ReflectionModel& m = options.reflections.emplace();
    double* const values[] = {&m.odds_at_45_dbhz, &m.decrease_dbhz, &m.excess_m, &m.excess_sigma_m,
                              &m.variance_factor};
    *values[i] = i % 2 == 0 ? std::numeric_limits<double>::quiet_NaN() : -1.0;
    const Result<SinglePoint> p = single_point(gps(9), messages_, options);
    ASSERT_FALSE(p) << i;
    EXPECT_EQ(p.error().code, ErrorCode::invalid) << i;
  }
}

}  // namespace
}  // namespace wayfare
