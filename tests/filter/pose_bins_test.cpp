#include <wayfare/filter/pose_bins.hpp>

#include <limits>
#include <vector>

#include <gmock/gmock.h>
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

// Of 1 m and a quarter turn: bins that touch at a corner, the two beside half a turn, and two
// beyond an empty bin.
TEST(PoseBins, AdjacentBinsFormAClusterTheHeaviestFirst) {
  const PoseBins bins(1.0, Angle::degrees(90.0));
  const std::vector<PoseBins::Key> keys{bins.of(3.5, 1.5, 0.1), bins.of(1.5, 1.5, 0.1),
                                        bins.of(0.5, 0.5, 0.1), bins.of(3.5, 0.5, 0.1),
                                        bins.of(8.0, 8.0, 3.0), bins.of(8.0, 8.0, -3.0)};
  const std::vector<double> weights{0.1, 0.2, 0.3, 0.05, 0.15, 0.2};
  const std::vector<Cluster> clusters = find_clusters<PoseBins>(keys, weights, bins);
  ASSERT_EQ(clusters.size(), 3U);
  EXPECT_NEAR(clusters[0].mass, 0.5, 1e-15);
  EXPECT_NEAR(clusters[1].mass, 0.35, 1e-15);
  EXPECT_NEAR(clusters[2].mass, 0.15, 1e-15);
  EXPECT_THAT(clusters[0].members, ::testing::UnorderedElementsAre(1U, 2U));
  EXPECT_THAT(clusters[1].members, ::testing::UnorderedElementsAre(4U, 5U));
  EXPECT_THAT(clusters[2].members, ::testing::UnorderedElementsAre(0U, 3U));
}

}  // namespace
}  // namespace wayfare
