#include <wayfare/io/g2o.hpp>

#include <string>
#include <tuple>
#include <variant>

#include "support.hpp"

namespace wayfare::io {
namespace {

using ::testing::HasSubstr;

GraphFile<SE2d> planar(std::string_view text) {
  Result<AnyGraphFile> file = parse_g2o(text, "test");
  EXPECT_TRUE(file) << file.error().to_string();
  return std::get<GraphFile<SE2d>>(*file);
}

Error refused(std::string_view text, const G2oOptions& options = {}) {
  const Result<AnyGraphFile> file = parse_g2o(text, "test", options);
  EXPECT_FALSE(file);
  return file ? Error{} : file.error();
}

TEST(G2o, ReadsAPlanarGraph) {
  const GraphFile<SE2d> graph = planar(
      "# comment\n"
      "EDGE_SE2 7 9 1 2 0.5 10 1 2 20 3 30\r\n"  // an edge may precede its vertices
      "VERTEX_SE2 7 0 0 0\n"
      "\n"
      "VERTEX_SE2 9 1e0 +2 -0.5\n"
      "VERTEX_SEGMENT2D 3 1 1 2 2\n"
      "FIX 7");
  ASSERT_EQ(graph.vertices.size(), 2U);
  EXPECT_EQ(graph.vertices[1].id, 9);
  EXPECT_EQ(graph.vertices[1].line, 5U);
  EXPECT_EQ(graph.vertices[1].pose.y(), 2.0);
  EXPECT_NEAR(graph.vertices[1].pose.heading().radians(), -0.5, 1e-15);
  ASSERT_EQ(graph.edges.size(), 1U);
  Eigen::Matrix3d expected;
  expected << 10, 1, 2, 1, 20, 3, 2, 3, 30;
  EXPECT_EQ(graph.edges[0].information, expected);
  EXPECT_THAT(graph.fixed, ::testing::ElementsAre(7));
  EXPECT_THAT(graph.ignored, ::testing::ElementsAre(::testing::Pair("VERTEX_SEGMENT2D", 1U)));
}

TEST(G2o, ReadsASpatialGraph) {
  const Result<AnyGraphFile> file = parse_g2o(
      "VERTEX_SE3:QUAT 0 1 2 3 0 0 0.70711 0.70711\n"
      "VERTEX_SE3:QUAT 1 0 0 0 0 0 0 1\n"
      "EDGE_SE3:QUAT 0 1 1 2 3 0 0 0 1 1 0 0 0 0 0 2 0 0 0 0 3 0 0 0 4 0 0 5 0 6\n",
      "test");
  ASSERT_TRUE(file) << file.error().to_string();
  const auto& graph = std::get<GraphFile<SE3d>>(*file);
  // A rotation by 90° about z maps x to y.
  EXPECT_TRUE((graph.vertices[0].pose * Eigen::Vector3d(1, 0, 0))
                  .isApprox(Eigen::Vector3d(1, 3, 3), 1e-12));
  EXPECT_EQ(graph.edges[0].information.diagonal(),
            (Eigen::Matrix<double, 6, 1>() << 1, 2, 3, 4, 5, 6).finished());
}

const std::string kTwo = "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 0 0\n";

const std::string kSix = " 1 0 0 0 0 0 1 0 0 0 0 1 0 0 0 1 0 0 1 0 1";
const std::string kSpace =
    "PARAMS_SE3OFFSET 7 1 0 0 0 0 0 1\nVERTEX_SE3:QUAT 0 0 0 0 0 0 0 1\nVERTEX_TRACKXYZ 1 0 0 0\n";

TEST(G2o, RejectsWithTheLine) {
  const std::tuple<std::string, std::size_t, const char*> cases[] = {
      {"", 0, "no vertex"},
      {"VERTEX_SE2 0 0 0\n", 1, "expected 3 numbers, found 2"},
      {"VERTEX_SE2 0 0 0 0 0\n", 1, "more than 3"},
      {"VERTEX_SE2 0 0 x 0\n", 1, "not a number: 'x'"},
      {"VERTEX_SE2 0 0 nan 0\n", 1, "not finite"},
      {"VERTEX_SE2 a 0 0 0\n", 1, "vertex id"},
      {kTwo + "VERTEX_SE2 1 0 0 0\n", 3, "vertex 1 is defined twice"},
      {kTwo + "EDGE_SE2 0 2 1 0 0 1 0 0 1 0 1\n", 3, "edge 0 -> 2: no vertex 2"},
      {kTwo + "EDGE_SE2 1 1 1 0 0 1 0 0 1 0 1\n", 3, "connects a vertex to itself"},
      {kTwo + "EDGE_SE2 0 1 1 0 0 1 0 0 1 0\n", 3, "edge 0 -> 1: information"},
      {kTwo + "EDGE_SE2 0 1 1 0 0 1 0 0 inf 0 1\n", 3, "not finite"},
      {kTwo + "EDGE_SE2 0 1 1 0 0 1 2 0 1 0 1\n", 3, "edge 0 -> 1: its information matrix is not"},
      {kTwo + "FIX 4\n", 3, "FIX: no vertex 4"},
      {kTwo + "VERTEX_SE3:QUAT 2 0 0 0 0 0 0 1\n", 3, "do not mix"},
      {"VERTEX_SE3:QUAT 2 0 0 0 0 0 0 2\n", 1, "unit length"},
      {kTwo + "VERTEX_TRACKXYZ 2 0 0 0\n", 3, "do not mix"},
      {kTwo + "VERTEX_XY 1 0 0\n", 3, "vertex 1 is defined twice"},
      {kTwo + "VERTEX_XY 2 0\n", 3, "landmark: expected 2 numbers, found 1"},
      {kTwo + "VERTEX_XY 2 0 1 2\n", 3, "landmark: more than 2 numbers"},
      {kTwo + "EDGE_SE2_XY 0 2 1 0 1 0 1\n", 3, "edge 0 -> 2: no landmark 2"},
      {kTwo + "EDGE_SE2_XY 0 1 1 0 1 0 1\n", 3, "edge 0 -> 1: vertex 1 is a pose"},
      {kTwo + "VERTEX_XY 2 0 0\nEDGE_SE2 0 2 1 0 0 1 0 0 1 0 1\n", 4, "vertex 2 is a landmark"},
      {kTwo + "VERTEX_XY 2 0 0\nEDGE_SE2_XY 2 0 1 0 1 0 1\n", 4, "vertex 2 is a landmark"},
      {kTwo + "EDGE_SE2_XY 0 0 1 0 1 0 1\n", 3, "connects a vertex to itself"},
      {kTwo + "VERTEX_XY 2 0 0\nEDGE_SE2_XY 0 2 1 0 1 2 1\n", 4, "not positive semi-definite"},
      {kTwo + "VERTEX_XY 2 0 0\nEDGE_SE2_XY 0 2 1 0 1 0\n", 4, "information matrix"},
      {kTwo + "VERTEX_XY 2 0 0\nEDGE_RANGE_SE2_XY 0 2 -1 4\n", 4, "the distance is negative"},
      {kTwo + "VERTEX_XY 2 0 0\nEDGE_RANGE_SE2_XY 0 2 1 -4\n", 4, "not positive semi-definite"},
      {kTwo + "EDGE_PRIOR_SE2 4 0 0 0 1 0 0 1 0 1\n", 3, "prior of vertex 4: no vertex 4"},
      {kTwo + "EDGE_PRIOR_XY 1 0 0 1 0 1\n", 3, "prior of vertex 1: vertex 1 is a pose"},
      {"ODOMETRY 0 1 1 0 0 1 0 0 1 0\n", 1, "matrix, upper triangle: expected 6 numbers"},
      {"ODOMETRY 0 1 1 0 0 0 0 0 1 0 1\n", 1, "edge 0 -> 1: its matrix has no finite inverse"},
      {"ODOMETRY 0 1 1 0 0 1 2 0 1 0 1\n", 1, "edge 0 -> 1: its information matrix is not"},
      {"ODOMETRY 0 1 1 0 0 1 0 0 1 0 1\nODOMETRY 2 3 1 0 0 1 0 0 1 0 1\n", 2, "no vertex 2"},
      {"ODOMETRY 0 1 1 0 0 1 0 0 1 0 1\nLANDMARK 0 1 1 0 1 0 1\n", 2, "vertex 1 is a pose"},
      {"LANDMARK 0 5 1 0 1 0 1\nODOMETRY 0 5 1 0 0 1 0 0 1 0 1\n", 2, "vertex 5 is a landmark"},
      {"ODOMETRY 0 1 1e308 0 0 1 0 0 1 0 1\nODOMETRY 1 2 1e308 0 0 1 0 0 1 0 1\n", 2,
       "vertex 2: the odometry's sum is not finite"},
      {"BR 0 5 0.1 -2 1 1\n", 1, "the distance is negative"},
      {"BR 0 5 0.1 2 0 1\n", 1, "standard deviations are not positive"},
      {"PARAMS_SE3OFFSET 0 0 0 0 0 0 0 1\nPARAMS_SE3OFFSET 0 0 0 0 0 0 0 1\n", 2,
       "parameter 0 is defined twice"},
      {kSpace + "EDGE_SE3_TRACKXYZ 0 1 2 1 2 3 1 0 0 1 0 1\n", 4, "edge 0 -> 1: no parameter 2"},
      {kSpace + "EDGE_SE3_PRIOR 0 7 0 0 0 0 0 0 2" + kSix + "\n", 4, "unit length"},
      {kSpace + "EDGE_SE3_PRIOR 0 x 0 0 0 0 0 0 1" + kSix + "\n", 4, "expected a parameter id"},
      {kSpace + "VERTEX_XY 2 0 0\n", 4, "VERTEX_XY in a spatial graph"},
      {kTwo + std::string("\x01\x02\xff\n"), 3, "unreadable"},
  };
  for (const auto& [text, line, message] : cases) {
    const Error error = refused(text);
    EXPECT_EQ(error.line, line) << text;
    EXPECT_THAT(error.message, HasSubstr(message)) << text;
  }
}

TEST(G2o, ProjectsAnIndefiniteInformationToTheNearest) {
  // [[1 2] [2 1]] has eigenvalues 3 along (1, 1) and -1: nearest is 1.5 everywhere.
  const Result<AnyGraphFile> file = parse_g2o(kTwo + "EDGE_SE2 0 1 1 0 0 1 2 0 1 0 7\n", "test",
                                              {.indefinite = IndefiniteInformation::project});
  ASSERT_TRUE(file) << file.error().to_string();
  const auto& graph = std::get<GraphFile<SE2d>>(*file);
  Eigen::Matrix3d expected;
  expected << 1.5, 1.5, 0, 1.5, 1.5, 0, 0, 0, 7;
  EXPECT_TRUE(graph.edges[0].information.isApprox(expected, 1e-12));
  EXPECT_EQ(graph.projected_edges, 1U);
}

TEST(G2o, AcceptsASingularInformation) {
  EXPECT_EQ(planar(kTwo + "EDGE_SE2 0 1 1 0 0 1 1 0 1 0 0\n").edges.size(), 1U);
}

TEST(G2o, RoundTripIsBitExact) {
  GraphFile<SE3d> graph;
  graph.vertices.push_back({-3, SE3d({0.1, 1.0 / 3, 1e-300}, SO3d::exp({0.3, -0.2, 0.1}))});
  graph.vertices.push_back({5, SE3d({-1e17, 2, 3}, SO3d::exp({3.0, 0.2, 0.1}))});
  Eigen::Matrix<double, 6, 6> root = Eigen::Matrix<double, 6, 6>::Identity();
  root(0, 3) = 1.0 / 3;
  graph.edges.push_back({-3, 5, graph.vertices[0].pose, root * root.transpose()});
  graph.fixed = {5};
  const testing::TemporaryFolder folder;
  ASSERT_TRUE(write_g2o(folder / "graph.g2o", graph));
  const Result<AnyGraphFile> file = read_g2o(folder / "graph.g2o");
  ASSERT_TRUE(file) << file.error().to_string();
  const auto& again = std::get<GraphFile<SE3d>>(*file);
  ASSERT_EQ(again.vertices.size(), 2U);
  EXPECT_EQ(again.vertices[0].id, -3);
  EXPECT_EQ(again.vertices[0].pose.translation(), graph.vertices[0].pose.translation());
  // Reading normalises the quaternion, which may change its last bit.
  EXPECT_TRUE(again.vertices[1].pose.rotation().quaternion().coeffs().isApprox(
      graph.vertices[1].pose.rotation().quaternion().coeffs(), 1e-15));
  EXPECT_EQ(again.edges[0].information, graph.edges[0].information);
  EXPECT_EQ(again.fixed, graph.fixed);
}

TEST(G2o, RealGraphs) {
  struct Expected {
    const char* name;
    bool spatial;
    std::size_t vertices, edges;
  };
  const Expected cases[] = {
      {"intel", false, 1728, 2512},       {"M3500", false, 3500, 5453},
      {"city10000", false, 10000, 20687}, {"MIT", false, 808, 827},
      {"sphere2500", true, 2500, 4949},   {"parking-garage", true, 1661, 6275},
      {"smallGrid3D", true, 125, 297},
  };
  for (const Expected& expected : cases) {
    WAYFARE_NEEDS_RECORDING(path, std::string("posegraph/") + expected.name + ".g2o.gz");
    const Result<AnyGraphFile> file = read_g2o(path);
    ASSERT_TRUE(file) << file.error().to_string();
    EXPECT_EQ(std::holds_alternative<GraphFile<SE3d>>(*file), expected.spatial);
    std::visit(
        [&](const auto& graph) {
          EXPECT_EQ(graph.vertices.size(), expected.vertices);
          EXPECT_EQ(graph.edges.size(), expected.edges);
        },
        *file);
  }
}

TEST(G2o, RealGraphWithIndefiniteInformationIsRefused) {
  WAYFARE_NEEDS_RECORDING(path, "posegraph/cubicle.g2o.gz");
  const Result<AnyGraphFile> file = read_g2o(path);
  ASSERT_FALSE(file);
  EXPECT_GT(file.error().line, 5750U);
  EXPECT_THAT(file.error().to_string(), HasSubstr("edge "));
  EXPECT_THAT(file.error().to_string(), HasSubstr("not positive semi-definite"));
  const Result<AnyGraphFile> projected =
      read_g2o(path, {.indefinite = IndefiniteInformation::project});
  ASSERT_TRUE(projected) << projected.error().to_string();
  EXPECT_EQ(std::get<GraphFile<SE3d>>(*projected).projected_edges, 5021U);
}

}  // namespace
}  // namespace wayfare::io
