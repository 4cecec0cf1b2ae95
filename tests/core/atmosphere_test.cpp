#include <wayfare/core/atmosphere.hpp>

#include <utility>

#include <gtest/gtest.h>

namespace wayfare {
namespace {

// ISO 2533, table 1, by geopotential height above sea level, printed to 0.1 Pa.
TEST(Atmosphere, FollowsTheStandard) {
  for (const auto& [height_m, pressure_Pa] :
       {std::pair(1000.0, 89874.6), std::pair(5000.0, 54019.9), std::pair(11000.0, 22632.0)}) {
    EXPECT_NEAR(barometric_pressure_Pa(height_m, 101325.0), pressure_Pa, 0.07);
    EXPECT_NEAR(barometric_height_m(pressure_Pa, 101325.0), height_m, 0.03);
  }
}

TEST(Atmosphere, HeightAndPressureAreInverse) {
  for (const double height_m : {-400.0, 0.0, 12.5, 3000.0})
    EXPECT_NEAR(barometric_height_m(barometric_pressure_Pa(height_m, 98000.0), 98000.0), height_m,
                1e-8);
}

}  // namespace
}  // namespace wayfare
