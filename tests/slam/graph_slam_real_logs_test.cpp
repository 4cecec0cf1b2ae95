// One set of defaults on real logs. The defaults were tuned on fr079 and intel.

#include <gtest/gtest.h>

#include <wayfare/io/carmen.hpp>
#include <wayfare/slam/graph_slam.hpp>

#include "io/support.hpp"
#include "log_relations.hpp"

namespace wayfare {
namespace {

constexpr std::size_t kScans = WAYFARE_TEST_SCANS;
constexpr bool kWholeLogs = kScans == 0;

eval::RelationsResult relations_of(const std::string& log_path, const std::string& relations_path,
                                   bool with_odometry = true) {
  const auto log = testing::read_log_with_relations(log_path, relations_path, with_odometry);
  if (!log) return {};
  const auto slam = run_graph_slam(log->recording);
  if (!slam) return {};
  EXPECT_EQ(slam->trajectory.size(), log->recording.scans.size());
  return eval::relations_error(slam->trajectory, log->relations);
}

/// Error bounds of a log.
struct Bounds {
  std::size_t relations;  ///< used of the whole log
  double translation_m, rotation_deg;
};

void expect_within(const eval::RelationsResult& error, const Bounds& bounds) {
  EXPECT_GE(error.used, kWholeLogs ? bounds.relations : 100U);
  EXPECT_LT(error.translation_m.mean, bounds.translation_m);
  EXPECT_LT(error.rotation_deg.mean, bounds.rotation_deg);
}

// Published for Cartographer on this building: 0.0452 m, 0.538 deg.
TEST(GraphSlamRealLogs, Freiburg079) {
  WAYFARE_NEEDS_RECORDING(log, "slam2d/fr079.clf.gz");
  WAYFARE_NEEDS_RECORDING(relations, "slam2d/fr079.relations.gz");
  expect_within(relations_of(log, relations), {1685, 0.0455, 0.80});
}

TEST(GraphSlamRealLogs, Freiburg079WithoutOdometry) {
  WAYFARE_NEEDS_RECORDING(log, "slam2d/fr079.clf.gz");
  WAYFARE_NEEDS_RECORDING(relations, "slam2d/fr079.relations.gz");
  expect_within(relations_of(log, relations, false), {1685, 0.05, 0.85});
}

// GMapping with 30 particles reaches 0.1025 m, 2.95 deg on this log.
TEST(GraphSlamRealLogs, Intel) {
  WAYFARE_NEEDS_RECORDING(log, "slam2d/intel.clf.gz");
  WAYFARE_NEEDS_RECORDING(relations, "slam2d/intel.relations.gz");
  expect_within(relations_of(log, relations), {2945, 0.1025, 2.95});
}

// The odometry of this log is 15 m off after its round; the relations between its end and its start
// agree only if the loop is closed.
TEST(GraphSlamRealLogs, Loop5Closes) {
  WAYFARE_NEEDS_RECORDING(path, "slam2d/loop5.log.gz");
  const auto log = io::read_carmen(path);
  ASSERT_TRUE(log);
  const auto slam = run_graph_slam(log->recording);
  ASSERT_TRUE(slam);
  EXPECT_GE(slam->statistics.loop_closures, 1U);
  EXPECT_EQ(slam->statistics.unmatched_scans, 0U);
}

}  // namespace
}  // namespace wayfare
