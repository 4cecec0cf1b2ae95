#include "support/slam_outputs.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <wayfare/io/g2o.hpp>
#include <wayfare/io/map_image.hpp>
#include <wayfare/io/text_file.hpp>
#include <wayfare/io/tum.hpp>
#include <wayfare/map/inverse_lidar.hpp>

#include "sim/support.hpp"

namespace wayfare::examples {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
namespace fs = std::filesystem;

// A simulated run with the truth as estimate: the result of SLAM without errors.
class FinishedRun : public ::testing::Test {
 protected:
  FinishedRun() {
    sim::RobotParams robot;
    robot.wheels.right_scale = 1.01;
    simulated_ = simulate(kOffice, robot, 2);
    const SE2d T_map_plan = simulated_.truth.front().T_map_base.raw().inverse();
    ScanRaster raster;
    for (const LaserScan& scan : simulated_.recording.scans) {
      const SE2d pose = T_map_plan * sim::true_pose_at(simulated_.truth, scan.time);
      trajectory_.push_back({scan.time, Transform2<frame::Map, frame::Base>(pose)});
      graph_.add_pose(pose);
      EXPECT_TRUE(insert_scan(map_, pose, scan, InverseLidarModel{}, raster).has_value());
    }
    for (int i = 1; i < graph_.size(); ++i) {
      const auto at = [&](int k) { return graph_.poses[static_cast<std::size_t>(k)]; };
      graph_.edges.push_back({i - 1, i, at(i - 1).inverse() * at(i)});
    }
    graph_.edges.push_back({0, graph_.size() - 1,
                            graph_.poses.front().inverse() * graph_.poses.back(),
                            Eigen::Matrix3d::Identity(), true});
    truth_ = {simulated_.truth, "the <simulation>"};
    folder_ = fs::path(::testing::TempDir()) /
              ::testing::UnitTest::GetInstance()->current_test_info()->name();
    fs::remove_all(folder_);
  }
  ~FinishedRun() override { fs::remove_all(folder_); }

  [[nodiscard]] SlamOutputs outputs() const {
    return {"A <test> run", simulated_.recording, trajectory_, map_, graph_,
            truth_,         {{"scans", "45"}}};
  }
  [[nodiscard]] std::string file(const char* name) const { return (folder_ / name).string(); }

  sim::SimulatedRun simulated_;
  Truth truth_;
  Trajectory trajectory_;
  OccupancyGrid map_;
  PoseGraph2 graph_;
  fs::path folder_;
};

TEST_F(FinishedRun, ErrorsAreThoseOfTheTrajectoriesWhateverTheReferencesFrame) {
  const auto errors = trajectory_errors(outputs());
  ASSERT_EQ(errors.size(), 2U);
  EXPECT_EQ(errors[1].name, "SLAM");
  for (const eval::AbsoluteError* e : {&errors[1].errors.start, &errors[1].errors.rigid}) {
    EXPECT_LT(e->translation_m.rmse, 1e-9);
    EXPECT_LT(e->end_m, 1e-9);
  }
  // The right wheel reports 1 % too much, with a wheel base of 0.4 m: after L metres the heading
  // error is 0.01 L / 0.4 and the position error about L times half of that on a straight path.
  const eval::AbsoluteError& odometry = errors[0].errors.start;
  const double length = odometry.path_length_m;
  EXPECT_GT(odometry.end_m, 0.1 * length * 0.01 * length / 0.4 / 2);
  EXPECT_LT(odometry.end_m, 2.0 * length * 0.01 * length / 0.4 / 2);
  EXPECT_NEAR(odometry.end_percent, 100 * odometry.end_m / length, 1e-9);
}

TEST_F(FinishedRun, TheReportHasTheErrorsAndTheTruePath) {
  ASSERT_TRUE(write_slam_outputs(folder_.string(), outputs()).has_value());
  const std::string with = io::read_file(file("report.html"))->bytes;
  EXPECT_THAT(with, HasSubstr("Errors against the truth of the &lt;simulation&gt;"));
  EXPECT_THAT(with,
              HasSubstr("<td>SLAM, same start</td><td>0.000</td><td>0.000</td><td>0.00</td>"));
  EXPECT_THAT(with, HasSubstr("</svg>truth</span>"));
  EXPECT_THAT(with, HasSubstr("in green, the true path"));
  truth_ = {};
  ASSERT_TRUE(write_slam_outputs(folder_.string(), outputs(), {io::Existing::replace}).has_value());
  const std::string without = io::read_file(file("report.html"))->bytes;
  EXPECT_THAT(without, Not(HasSubstr("truth")));
}

TEST_F(FinishedRun, TheTruePathIsDrawnInTheMapsFrame) {
  const auto errors = trajectory_errors(outputs());
  const io::Series path = truth_series(truth_, errors[1].errors);
  ASSERT_EQ(path.x.size(), simulated_.truth.size());
  // The trajectory is the truth in the map's frame, whose first pose is the origin.
  EXPECT_NEAR(path.x.front(), 0.0, 1e-9);
  EXPECT_NEAR(path.y.front(), 0.0, 1e-9);
}

TEST_F(FinishedRun, WithoutAReferenceThereAreNoErrors) {
  truth_ = {};
  const SlamOutputs run = outputs();
  EXPECT_TRUE(trajectory_errors(run).empty());
  EXPECT_TRUE(tables_of(run).empty());
  EXPECT_TRUE(write_slam_outputs(folder_.string(), run).has_value());
}

TEST_F(FinishedRun, FilesReadBack) {
  const auto report = write_slam_outputs(folder_.string(), outputs());
  ASSERT_TRUE(report.has_value()) << report.error().to_string();
  const auto tum = io::read_tum(file("trajectory.tum"));
  ASSERT_TRUE(tum.has_value());
  ASSERT_EQ(tum->trajectory.size(), trajectory_.size());
  EXPECT_EQ(tum->trajectory.back().time, trajectory_.back().time);
  const auto graph = io::read_g2o(file("graph.g2o"));
  ASSERT_TRUE(graph.has_value());
  EXPECT_EQ(std::get<io::GraphFile<SE2d>>(*graph).edges.size(), graph_.edges.size());
  EXPECT_TRUE(fs::exists(file("map.png")));
  const auto html = io::read_file(*report);
  ASSERT_TRUE(html.has_value());
  EXPECT_THAT(html->bytes, HasSubstr("A &lt;test&gt; run"));
}

// Another estimate has a row in the tables of errors and of paths, a curve and a file of its own.
TEST_F(FinishedRun, OtherEstimatesAreShownBesideSlam) {
  SlamOutputs run = outputs();
  run.others = {{"dead reckoning", "dead_reckoning.tum", trajectory_}};
  for (StampedPose& pose : run.others[0].trajectory) {
    const SE2d& at = pose.T_map_base.raw();
    pose.T_map_base =
        Transform2<frame::Map, frame::Base>(SE2d(2.0 * at.translation(), at.rotation()));
  }
  const auto errors = trajectory_errors(run);
  ASSERT_EQ(errors.size(), 3U);
  EXPECT_EQ(errors[1].name, "dead reckoning");
  EXPECT_GT(errors[1].errors.start.end_m,
            0.5 * trajectory_.back().T_map_base.raw().translation().norm());
  EXPECT_LT(errors[2].errors.start.end_m, 1e-9);
  const auto tables = tables_of(run);
  const auto paths = std::find_if(tables.begin(), tables.end(),
                                  [](const auto& table) { return table.first == "Paths"; });
  ASSERT_NE(paths, tables.end());
  EXPECT_THAT(paths->second.to_text(), HasSubstr("dead reckoning"));
  EXPECT_THAT(paths->second.to_text(), HasSubstr("SLAM"));
  const auto report = write_slam_outputs(folder_.string(), run);
  ASSERT_TRUE(report.has_value()) << report.error().to_string();
  const auto tum = io::read_tum(file("dead_reckoning.tum"));
  ASSERT_TRUE(tum.has_value());
  EXPECT_EQ(tum->trajectory.size(), trajectory_.size());
  EXPECT_THAT(io::read_file(*report)->bytes, HasSubstr("dead reckoning"));
  EXPECT_FALSE(write_slam_outputs(folder_.string(), run).has_value());
}

TEST_F(FinishedRun, TheMapImageLiesWhereTheWallsAre) {
  ASSERT_TRUE(write_slam_outputs(folder_.string(), outputs()).has_value());
  const auto map = io::read_map(file("map.yaml"));
  ASSERT_TRUE(map.has_value()) << map.error().to_string();
  // The first wall straight ahead, and the floor half way to it.
  const LaserScan& scan = simulated_.recording.scans.front();
  const auto at = [&](double x_m) {
    const Eigen::Vector2d cell =
        (Eigen::Vector2d(x_m, 0) - map->origin.translation()) / map->resolution_m;
    return map->occupancy[static_cast<std::size_t>(cell.y()) * map->width +
                          static_cast<std::size_t>(cell.x())];
  };
  ASSERT_TRUE(scan.returned(90));
  EXPECT_LT(at(0.5 * static_cast<double>(scan.ranges_m[90])), 0.5F);
  float wall = 0.0F;
  for (const double offset_m : {-0.05, 0.0, 0.05})
    wall = std::max(wall, at(static_cast<double>(scan.ranges_m[90]) + offset_m));
  EXPECT_GT(wall, 0.5F);
}

TEST_F(FinishedRun, NothingIsOverwrittenUnlessAsked) {
  fs::create_directories(folder_);
  ASSERT_TRUE(io::write_file(file("graph.g2o"), "mine").has_value());
  const auto refused = write_slam_outputs(folder_.string(), outputs());
  ASSERT_FALSE(refused.has_value());
  EXPECT_THAT(refused.error().to_string(), HasSubstr("graph.g2o"));
  EXPECT_FALSE(fs::exists(file("trajectory.tum")));
  EXPECT_EQ(io::read_file(file("graph.g2o"))->bytes, "mine");
  EXPECT_TRUE(write_slam_outputs(folder_.string(), outputs(), {io::Existing::replace}).has_value());
}

TEST_F(FinishedRun, FilesOfTheCallersOwnAreRefusedBeforeTheWork) {
  fs::create_directories(folder_);
  ASSERT_TRUE(io::write_file(file("robot.log"), "mine").has_value());
  EXPECT_TRUE(prepare_folder(folder_.string()).has_value());
  const auto refused = prepare_folder(folder_.string(), {}, {"robot.log"});
  ASSERT_FALSE(refused.has_value());
  EXPECT_THAT(refused.error().to_string(), HasSubstr("robot.log"));
  EXPECT_TRUE(prepare_folder(folder_.string(), {io::Existing::replace}, {"robot.log"}).has_value());
}

// -28 cells of 0.05 m are -1.4 m, but the product in doubles is -1.4000000000000001.
TEST_F(FinishedRun, TheMapsOriginIsPrintedInRoundFigures) {
  map_ = OccupancyGrid();
  map_.update(Cell{-28, -56}, LogOdds::from_nats(1.0));
  ASSERT_TRUE(write_slam_outputs(folder_.string(), outputs()).has_value());
  const auto yaml = io::read_file(file("map.yaml"));
  ASSERT_TRUE(yaml.has_value());
  EXPECT_THAT(yaml->bytes, HasSubstr("origin: [-1.4, -2.8, 0]"));
}

TEST_F(FinishedRun, AFolderThatCannotBeMadeIsAnError) {
  const auto refused = write_slam_outputs("/dev/null/folder", outputs());
  ASSERT_FALSE(refused.has_value());
  EXPECT_THAT(refused.error().to_string(), HasSubstr("/dev/null/folder"));
}

TEST_F(FinishedRun, AnEmptyMapIsNoCrash) {
  SlamOutputs run = outputs();
  const OccupancyGrid empty;
  const SlamOutputs bare{run.title, run.recording, run.trajectory, empty, run.graph, run.truth};
  const auto written = write_slam_outputs(folder_.string(), bare);
  EXPECT_TRUE(written.has_value()) << written.error().to_string();
}

}  // namespace
}  // namespace wayfare::examples
