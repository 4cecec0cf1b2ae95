#include <wayfare/filter/pose_bins.hpp>

#include <limits>

#include <gtest/gtest.h>

namespace wayfare {
namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

TEST(PoseBins, OfHalfAMetreAndAQuarterTurn) {
  const PoseBins bins(0.5, Angle::degrees(90.0));
  EXPECT_EQ(bins.turns(), 4);
  EXPECT_EQ(bins.of(0.2, -0.2, -3.0), (PoseBins::Key{0, -1, 0}));
  EXPECT_EQ(bins.of(1.2, 0.5, 3.0), (PoseBins::Key{2, 1, 3}));
}

TEST(PoseBins, HaveASideWhateverIsAskedFor) {
  for (const double none : {0.0, -1.0, 1e-12, kNan, -kInf}) {
    const PoseBins bins(none, Angle::radians(none));
    EXPECT_EQ(bins.turns(), 3600) << none;
    EXPECT_EQ(bins.of(0.0, 0.0015, 0.0), (PoseBins::Key{0, 1, 1800})) << none;
  }
  const PoseBins all(kInf, Angle::radians(kInf));
  EXPECT_EQ(all.turns(), 1);
  EXPECT_EQ(all.of(7.0, 1e9, 3.0), (PoseBins::Key{0, 0, 0}));
}

}  // namespace
}  // namespace wayfare
