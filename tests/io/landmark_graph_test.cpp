#include <wayfare/io/landmark_graph.hpp>

#include <string>
#include <variant>

#include <wayfare/graph/optimise.hpp>

#include "support.hpp"

namespace wayfare::io {
namespace {

template <class G>
GraphFile<G> read(std::string_view text, const G2oOptions& options = {}) {
  const Result<AnyGraphFile> file = parse_g2o(text, "test", options);
  EXPECT_TRUE(file) << file.error().to_string();
  return file && std::holds_alternative<GraphFile<G>>(*file) ? std::get<GraphFile<G>>(*file)
                                                             : GraphFile<G>();
}

/// Every kind of line, in the order they are written.
const std::string kPlane =
    "VERTEX_SE2 0 0 0 0\n"
    "VERTEX_SE2 4 3 1 0.5\n"
    "VERTEX_XY 2 1 -2\n"
    "VERTEX_XY -7 5 0.25\n"
    "FIX 0\n"
    "FIX 2\n"
    "EDGE_SE2 0 4 3 1 0.5 2 0.5 0.25 3 0.125 4\n"
    "EDGE_SE2_XY 0 2 1 -2 2 0.5 3\n"
    "EDGE_BEARING_SE2_XY 4 2 -2.5 9\n"
    "EDGE_RANGE_SE2_XY 4 -7 2 16\n"
    "EDGE_PRIOR_SE2 4 3 1 0.5 2 0.5 0.25 3 0.125 4\n"
    "EDGE_PRIOR_SE2_XY 0 0.5 0.75 2 0.5 3\n"
    "EDGE_PRIOR_XY -7 5 1 2 0.5 3\n";
const std::string kSpaceFile =
    "PARAMS_SE3OFFSET 0 0 0 0 0 0 0 1\n"
    "PARAMS_SE3OFFSET 3 0.5 0 0.25 0 0 1 0\n"
    "VERTEX_SE3:QUAT 0 0 0 0 0 0 0 1\n"
    "VERTEX_SE3:QUAT 1 2 0 0 0 0 0 1\n"
    "VERTEX_TRACKXYZ 2 1 -2 3\n"
    "FIX 0\n"
    "EDGE_SE3:QUAT 0 1 2 0 0 0 0 0 1 1 0 0 0 0 0 2 0 0 0 0 3 0 0 0 4 0 0 5 0 6\n"
    "EDGE_SE3_TRACKXYZ 0 2 3 -0.5 2 2.75 4 1 0.5 5 0.25 6\n"
    "EDGE_SE3_PRIOR 1 3 2.5 0 0.25 0 0 1 0 1 0 0 0 0 0 2 0 0 0 0 3 0 0 0 4 0 0 5 0 6\n"
    "EDGE_SE3_XYZ_PRIOR 1 0 2 0 0 4 1 0.5 5 0.25 6\n"
    "EDGE_POINTXYZ_PRIOR 2 1 -2 4 4 1 0.5 5 0.25 6\n";

// Numbers are written as the shortest text that reads back to them, so the texts are equal.
TEST(LandmarkFile, WhatIsReadIsWritten) {
  EXPECT_EQ(format_g2o(read<SE2d>(kPlane)), kPlane);
  EXPECT_EQ(format_g2o(read<SE3d>(kSpaceFile)), kSpaceFile);
}

TEST(LandmarkFile, PlanarLinesAreWhatG2oWrites) {
  const auto file = read<SE2d>(kPlane);
  EXPECT_FALSE(file.only_poses());
  ASSERT_EQ(file.landmarks.size(), 2U);
  EXPECT_EQ(file.landmarks[1].id, -7);
  EXPECT_EQ(file.landmarks[1].position, Eigen::Vector2d(5, 0.25));
  EXPECT_EQ(file.landmarks[1].line, 4U);
  const auto& seen = file.all<LandmarkPosition<SE2d>>().at(0);
  EXPECT_THAT(seen.ids, ::testing::ElementsAre(0, 2));
  EXPECT_EQ(seen.edge.measurement, Eigen::Vector2d(1, -2));
  EXPECT_EQ(seen.edge.information, (Eigen::Matrix2d() << 2, 0.5, 0.5, 3).finished());
  const auto& bearing = file.all<BearingRange>().at(0).edge;
  EXPECT_EQ(bearing.bearing.radians(), -2.5);
  EXPECT_EQ(bearing.information, (Eigen::Matrix2d() << 9, 0, 0, 0).finished());
  EXPECT_EQ(file.all<RangeTo<SE2d>>().at(0).edge.range_m, 2.0);
  EXPECT_EQ(file.all<RangeTo<SE2d>>().at(0).edge.information(0, 0), 16.0);
  EXPECT_EQ(file.all<PositionOf<SE2d>>().at(0).edge.measurement, Eigen::Vector2d(0.5, 0.75));
  EXPECT_THAT(file.all<Prior<Eigen::Vector2d>>().at(0).ids, ::testing::ElementsAre(-7));
  EXPECT_EQ(file.all<PoseOf<SE2d>>().at(0).edge.information(0, 2), 0.25);
}

// Each term by hand, with the poses and landmarks of the file:
// EDGE_SE2, EDGE_SE2_XY and EDGE_PRIOR_SE2 are exact: 0.
// EDGE_BEARING_SE2_XY: from (3, 1, 0.5) to (1, -2): atan2(-3, -2) - 0.5 = -2.658799; error
//   -0.158799, 9 e² = 0.226954.
// EDGE_RANGE_SE2_XY: |(2, -0.75)| - 2 = 0.136001; 16 e² = 0.295940.
// EDGE_PRIOR_SE2_XY: (-0.5, -0.75): 2·0.25 + 3·0.5625 + 2·0.5·0.375 = 2.5625.
// EDGE_PRIOR_XY: (0, -0.75): 3·0.5625 = 1.6875.
TEST(LandmarkFile, PlanarErrorsAreThoseOfG2o) {
  auto graph = to_factor_graph(read<SE2d>(kPlane));
  EXPECT_EQ(graph.edge_count(), 7);
  FactorEquations<decltype(graph)> equations;
  EXPECT_NEAR(equations.cost(graph), 0.226954 + 0.295940 + 2.5625 + 1.6875, 2e-6);
  EXPECT_EQ(graph.fixed(), (std::vector<int>{0, 2}));
}

// The sensor 3 is at (0.5, 0, 0.25) on the robot, turned by 180° about z: it sees the landmark
// (1, -2, 3) of a robot at the origin at (-(1 - 0.5), -(-2), 3 - 0.25), as measured; and it is at
// (2.5, 0, 0.25) for a robot at (2, 0, 0), as its prior says. What is left is the last line's
// prior: the landmark is (0, 0, -1) off, 6 · 1². Moved by (0.1, 0, 0), the landmark is seen by the
// sensor at -0.1 in x: 4 · 0.01; and the prior of the landmark is 4·0.01 + 2·0.5·(0.1·-1) + 6
// = 5.94.
TEST(LandmarkFile, SensorsAreWhereTheirParametersSay) {
  auto graph = to_factor_graph(read<SE3d>(kSpaceFile));
  FactorEquations<decltype(graph)> equations;
  EXPECT_NEAR(equations.cost(graph), 6.0, 1e-12);
  graph[VariableId<Eigen::Vector3d>{2}].x() += 0.1;
  EXPECT_NEAR(equations.cost(graph), 0.04 + 5.94, 1e-12);
}

// g2o's prior of a position is of the robot, wherever its sensor is.
TEST(LandmarkFile, PositionPriorsAreOfTheRobot) {
  auto graph = to_factor_graph(
      read<SE3d>("PARAMS_SE3OFFSET 3 0.5 0 0.25 0 0 1 0\nVERTEX_SE3:QUAT 1 2 0 0 0 0 0 1\n"
                 "EDGE_SE3_XYZ_PRIOR 1 3 2 0 1 1 0 0 1 0 1\n"));
  EXPECT_NEAR(FactorEquations<decltype(graph)>().cost(graph), 1.0, 1e-12);
}

TEST(LandmarkFile, AFileThatFixesNothingHoldsItsFirstPose) {
  const std::string two = "VERTEX_SE2 5 0 0 0\nVERTEX_XY 6 1 1\nEDGE_SE2_XY 5 6 1 1 1 0 1\n";
  EXPECT_EQ(to_factor_graph(read<SE2d>(two)).fixed(), std::vector<int>{0});
  EXPECT_TRUE(
      to_factor_graph(read<SE2d>(two + "EDGE_PRIOR_SE2 5 0 0 0 1 0 0 1 0 1\n")).fixed().empty());
}

// One metre ahead, then a quarter turn to the left and one metre: (1, 1). The landmark is seen
// first from pose 1 at (1, 0): one metre to its left, (1, 1), and from pose 2 half a metre ahead.
const std::string kLog =
    "ODOMETRY 0 1 1 0 1.5707963267948966 0.25 0 0 4 0 0.0625\n"
    "LANDMARK 1 9 1 0 0.25 0 0.5\n"
    "ODOMETRY 1 2 1 0 0 0.25 0 0 4 0 0.0625\n"
    "BR 2 9 0 0.5 0.5 0.25\n";

TEST(LandmarkLog, DefinesPosesAndLandmarks) {
  const auto file = read<SE2d>(kLog);
  ASSERT_EQ(file.vertices.size(), 3U);
  EXPECT_TRUE(file.vertices[2].pose.translation().isApprox(Eigen::Vector2d(1, 1), 1e-12));
  ASSERT_EQ(file.landmarks.size(), 1U);
  EXPECT_TRUE(file.landmarks[0].position.isApprox(Eigen::Vector2d(1, 1), 1e-12));
  EXPECT_EQ(file.landmarks[0].line, 2U);
  // Covariances: 1/0.25, 1/4, 1/0.0625; standard deviations 0.5 and 0.25.
  EXPECT_EQ(file.edges[1].information.diagonal(), Eigen::Vector3d(4, 0.25, 16));
  EXPECT_EQ(file.all<LandmarkPosition<SE2d>>().at(0).edge.information.diagonal(),
            Eigen::Vector2d(4, 2));
  EXPECT_EQ(file.all<BearingRange>().at(0).edge.information(0, 0), 4.0);
  EXPECT_EQ(file.all<RangeTo<SE2d>>().at(0).edge.information(0, 0), 16.0);
}

// [[2 1 0] [. 3 0] [. . 4]] as information; as a root RᵀR = [[4 2 0] [2 10 0] [0 0 16]]; as a
// covariance its inverse has 3/5, -1/5, 2/5 and 1/4.
TEST(LandmarkLog, MatricesAreWhatTheOptionSays) {
  const std::string line = "ODOMETRY 0 1 1 0 0 2 1 0 3 0 4\n";
  const auto with = [&](LogMatrix kind) {
    return read<SE2d>(line, {.log_matrix = kind}).edges.at(0).information;
  };
  Eigen::Matrix3d expected;
  expected << 2, 1, 0, 1, 3, 0, 0, 0, 4;
  EXPECT_EQ(with(LogMatrix::information), expected);
  expected << 4, 2, 0, 2, 10, 0, 0, 0, 16;
  EXPECT_EQ(with(LogMatrix::root_information), expected);
  expected << 0.6, -0.2, 0, -0.2, 0.4, 0, 0, 0, 0.25;
  EXPECT_TRUE(with(LogMatrix::covariance).isApprox(expected, 1e-14));
}

TEST(LandmarkLog, LinesOfToroHaveTheirOwnOrder) {
  const auto file = read<SE2d>("VERTEX2 0 0 0 0\nVERTEX2 1 1 0 0\nEDGE2 0 1 1 0 0 4 1 5 6 2 3\n");
  Eigen::Matrix3d expected;  // xx xy yy θθ xθ yθ
  expected << 4, 1, 2, 1, 5, 3, 2, 3, 6;
  EXPECT_EQ(file.edges.at(0).information, expected);
}

// A log becomes a file of g2o with the same graph.
TEST(LandmarkLog, IsWrittenAsG2o) {
  const auto log = read<SE2d>(kLog);
  const std::string text = format_g2o(log);
  EXPECT_THAT(
      text, ::testing::HasSubstr("\nEDGE_BEARING_SE2_XY 2 9 0 4\nEDGE_RANGE_SE2_XY 2 9 0.5 16\n"));
  EXPECT_EQ(format_g2o(read<SE2d>(text)), text);
}

// Five exact sightings of one landmark on a straight drive: it moves from where it is put to where
// it was seen.
TEST(LandmarkGraph, IsOptimisedAndCopiedBack) {
  auto file = read<SE2d>(
      "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1.3 -0.2 0.1\nVERTEX_XY 2 7 7\n"
      "EDGE_SE2 0 1 1 0 0 100 0 0 100 0 100\n"
      "EDGE_SE2_XY 0 2 3 4 10 0 10\nEDGE_SE2_XY 1 2 2 4 10 0 10\n");
  auto graph = to_factor_graph(file);
  const auto report = optimise(graph);
  ASSERT_TRUE(report) << report.error().to_string();
  take_values(graph, file);
  EXPECT_LT((file.landmarks[0].position - Eigen::Vector2d(3, 4)).norm(), 1e-6);
  EXPECT_LT((file.vertices[1].pose.translation() - Eigen::Vector2d(1, 0)).norm(), 1e-6);
}

TEST(LandmarkGraph, RealLogOfAPark) {
  WAYFARE_NEEDS_RECORDING(path, "landmarks/victoria_park.txt.gz");
  const Result<AnyGraphFile> any = read_g2o(path);
  ASSERT_TRUE(any) << any.error().to_string();
  const auto& file = std::get<GraphFile<SE2d>>(*any);
  EXPECT_EQ(file.vertices.size(), 6969U);
  EXPECT_EQ(file.edges.size(), 6968U);
  EXPECT_EQ(file.landmarks.size(), 151U);
  EXPECT_EQ(file.all<LandmarkPosition<SE2d>>().size(), 3640U);
  EXPECT_TRUE(file.ignored.empty());
}

// Poses along a circle of 8 m, vertex 1 of the file halfway; exact measurements, values of no use.
TEST(LandmarkGraph, GrowsFromMeasurementsAlone) {
  GraphFile<SE2d> truth;
  const SE2d step(1.0, 0.0, Angle::radians(0.125));
  SE2d pose(3.0, -1.0, Angle::radians(2.0));
  const std::vector<Eigen::Vector2d> trees{{2, 3}, {-4, 1}, {-9, -3}};
  for (int i = 0; i < 50; ++i, pose = pose * step) {
    truth.vertices.push_back({i, pose});
    if (i > 0) truth.edges.push_back({i - 1, i, step});
    for (std::size_t k = 0; k < trees.size(); ++k)
      if ((i + static_cast<int>(k)) % 3 == 0)
        truth.all<LandmarkPosition<SE2d>>().push_back(
            {{i, 100 + static_cast<int>(k)}, {pose.inverse() * trees[k]}});
  }
  for (std::size_t k = 0; k < trees.size(); ++k)
    truth.landmarks.push_back({100 + static_cast<int>(k), trees[k]});
  auto file = truth;
  for (std::size_t i = 1; i < file.vertices.size(); ++i) file.vertices[i].pose = SE2d();
  for (auto& landmark : file.landmarks) landmark.position.setZero();
  const auto started = start_from_growth(file, 7);
  ASSERT_TRUE(started) << started.error().to_string();
  for (std::size_t i = 0; i < file.vertices.size(); ++i)
    EXPECT_LT(file.vertices[i].pose.minus(truth.vertices[i].pose).norm(), 1e-9) << i;
  for (std::size_t k = 0; k < trees.size(); ++k) {
    EXPECT_EQ(file.landmarks[k].id, truth.landmarks[k].id);
    EXPECT_LT((file.landmarks[k].position - trees[k]).norm(), 1e-9);
  }
  file.fixed = {3};
  EXPECT_EQ(start_from_growth(file).error().code, ErrorCode::unsupported);
}

// 6184.12 for 7280 numbers of sightings and 302 unknowns beyond the odometry's: with the log's
// matrices as covariances χ² is 0.89 per degree of freedom. As information it would be 2e-5.
TEST(LandmarkGraph, MatricesOfARealLogAreCovariances) {
  WAYFARE_NEEDS_RECORDING(path, "landmarks/victoria_park.txt.gz");
  const Result<AnyGraphFile> any = read_g2o(path);
  ASSERT_TRUE(any) << any.error().to_string();
  auto file = std::get<GraphFile<SE2d>>(*any);
  ASSERT_TRUE(start_from_growth(file, 100));
  auto graph = to_factor_graph(file);
  const auto report = optimise(graph);
  ASSERT_TRUE(report) << report.error().to_string();
  EXPECT_NEAR(report->final_chi2, 6184.12, 0.01);
}

}  // namespace
}  // namespace wayfare::io
