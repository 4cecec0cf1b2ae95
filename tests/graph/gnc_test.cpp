#include <wayfare/graph/gnc.hpp>

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <wayfare/core/statistics.hpp>
#include <wayfare/graph/optimise.hpp>
#include <wayfare/io/g2o.hpp>

#include "io/support.hpp"
#include "tangle.hpp"

namespace wayfare {
namespace {

using ::testing::HasSubstr;
using tests::random_tangent;

double rms_distance(const auto& a, const auto& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i)
    sum += (a[i].translation() - b[i].translation()).squaredNorm();
  return std::sqrt(sum / static_cast<double>(a.size()));
}

/// A walk over the crossings of a grid of streets, measured with consistent noise, with a loop
/// wherever it returns to within a street's length.
template <class G>
class Streets {
 public:
  static constexpr int kDof = G::kDof;
  static constexpr double kNoise_m = 0.02, kNoise_rad = 0.01;

  explicit Streets(std::uint64_t seed) : rng_(seed) {
    G pose;
    for (int i = 0; i < 250; ++i) {
      truth_.push_back(pose);
      pose = pose * ahead();
    }
    for (int i = 1; i < size(); ++i) join(i - 1, i, false);
    for (int i = 0; i < size(); ++i) {
      for (int j = i + 5; j < size(); j += 3) {
        if (near(i, j)) join(i, j, true);
      }
    }
    graph_.poses = truth_;
  }

  [[nodiscard]] const PoseGraph<G>& graph() const { return graph_; }

  /// Appends false loops between distant positions, up to a fraction `share` of all loops.
  [[nodiscard]] PoseGraph<G> with_false_loops(double share) {
    PoseGraph<G> graph = graph_;
    const auto loops = graph.edges.size() - truth_.size() + 1;
    for (auto count = std::lround(share / (1.0 - share) * double(loops)); count > 0;) {
      const int i = any(), j = any();
      if (std::abs(i - j) < 2 || near(i, j)) continue;
      auto edge = graph.edges.back();
      edge.from = i, edge.to = j;
      edge.measurement = G::exp(random_tangent<G>(rng_, 0.3));
      graph.edges.push_back(edge);
      --count;
    }
    return graph;
  }

 private:
  [[nodiscard]] int size() const { return static_cast<int>(truth_.size()); }
  const G& at(int i) const { return truth_[static_cast<std::size_t>(i)]; }
  int any() { return static_cast<int>(rng_.below(truth_.size())); }
  bool near(int i, int j) const { return (at(i).translation() - at(j).translation()).norm() < 1.5; }

  G ahead() {
    TangentOf<G> step = TangentOf<G>::Zero(), turn = TangentOf<G>::Zero();
    step[0] = 1.0;
    const double which = rng_.uniform(0, 1);
    turn[kDof - 1] = which < 0.25  ? std::numbers::pi / 2.0
                     : which < 0.5 ? -std::numbers::pi / 2.0
                                   : 0.0;
    return G::exp(step) * G::exp(turn);
  }

  void join(int i, int j, bool loop) {
    TangentOf<G> noise;
    SquareOf<G> information = SquareOf<G>::Zero();
    for (int k = 0; k < kDof; ++k) {
      const bool turn = k >= static_cast<int>(G::Vector::RowsAtCompileTime);
      const double sigma = turn ? kNoise_rad : kNoise_m;
      noise[k] = rng_.normal(0.0, sigma);
      // A quaternion's vector part is half the angle.
      information(k, k) = (turn && kDof == 6 ? 4.0 : 1.0) / (sigma * sigma);
    }
    graph_.edges.push_back({i, j, (at(i).inverse() * at(j)).plus(noise), information, loop});
  }

  Rng rng_;
  std::vector<G> truth_;
  PoseGraph<G> graph_;
};

template <class G>
class GncTest : public ::testing::Test {};
using Groups = ::testing::Types<SE2d, SE3d>;
TYPED_TEST_SUITE(GncTest, Groups);

void expect_only_false_rejected(const auto& rejected, std::size_t true_edges, std::size_t edges) {
  std::vector<int> want;
  for (std::size_t k = true_edges; k < edges; ++k) want.push_back(static_cast<int>(k));
  EXPECT_EQ(rejected, want);
}

TYPED_TEST(GncTest, FindsTheFalseLoopsAmongTrueOnes) {
  for (const std::uint64_t seed : {1U, 2U}) {
    Streets<TypeParam> streets(seed);
    auto clean = streets.graph();
    ASSERT_TRUE(optimise(clean));
    for (const double share : {0.1, 0.3, 0.5}) {
      auto graph = streets.with_false_loops(share);
      ASSERT_GT(graph.edges.size(), clean.edges.size());
      const auto report = optimise_gnc(graph);
      ASSERT_TRUE(report) << report.error().to_string();
      expect_only_false_rejected(report->rejected, clean.edges.size(), graph.edges.size());
      EXPECT_LT(rms_distance(graph.poses, clean.poses), 1e-3) << share;
      EXPECT_NEAR(report->optimisation.final_chi2, chi2(clean), 1e-3 * chi2(clean));
      EXPECT_GT(report->rounds, 0);
      EXPECT_GT(report->optimisation.iterations, 0);
      EXPECT_GE(report->iterations, report->optimisation.iterations);
    }
  }
}

// Beside an edge that determines the pose, an edge of σ = 1 cm is an outlier where its error
// exceeds the square root of the quantile of χ² of as many degrees of freedom as its information
// has: directions with less than 1e-9 of the largest are none. The five pairs move the pose by 1e-5
// of their errors.
TYPED_TEST(GncTest, TheGateIsTheQuantileOfTheEdgesDegreesOfFreedom) {
  using G = TypeParam;
  const auto ahead = [](double x) { return G(G::Vector::Unit(0) * x, G().rotation()); };
  for (const double probability : {GncOptions{}.inlier_probability, 0.9}) {
    PoseGraph<G> graph{{G(), ahead(1.0)}, {}, {}, {}};
    graph.edges.push_back({0, 1, ahead(1.0), 1e10 * SquareOf<G>::Identity(), false});
    const auto add = [&](const TangentOf<G>& weights, int freedom) {
      const double limit_m = 0.01 * std::sqrt(chi_square_quantile(probability, freedom));
      const SquareOf<G> information = 1e4 * SquareOf<G>(weights.asDiagonal());
      for (const double part : {0.99, 1.01})
        graph.edges.push_back({0, 1, ahead(1.0 + part * limit_m), information, true});
    };
    const TangentOf<G> one = TangentOf<G>::Unit(0), second = TangentOf<G>::Unit(1);
    add(TangentOf<G>::Ones(), G::kDof);
    add(one, 1);
    add(one + second, 2);
    add(one + 1.5e-9 * second, 2);
    add(one + 0.7e-9 * second, 1);
    const auto report = optimise_gnc(graph, {.inlier_probability = probability});
    ASSERT_TRUE(report) << report.error().to_string();
    EXPECT_EQ(report->rejected, (std::vector<int>{2, 4, 6, 8, 10})) << probability;
  }
}

TYPED_TEST(GncTest, GemanMcClureFindsThemAmongFewer) {
  Streets<TypeParam> streets(3);
  auto clean = streets.graph();
  ASSERT_TRUE(optimise(clean));
  auto graph = streets.with_false_loops(0.1);
  const auto report = optimise_gnc(graph, {.loss = GncLoss::geman_mcclure});
  ASSERT_TRUE(report) << report.error().to_string();
  expect_only_false_rejected(report->rejected, clean.edges.size(), graph.edges.size());
  EXPECT_LT(rms_distance(graph.poses, clean.poses), 1e-3);
}

TYPED_TEST(GncTest, WithoutFalseLoopsNothingChanges) {
  Streets<TypeParam> streets(4);
  auto clean = streets.graph(), graph = clean;
  ASSERT_TRUE(optimise(clean));
  const auto report = optimise_gnc(graph);
  ASSERT_TRUE(report);
  EXPECT_TRUE(report->rejected.empty());
  EXPECT_LT(rms_distance(graph.poses, clean.poses), 1e-3);
  // Trusted edges are never rejected.
  for (auto& edge : graph.edges) edge.robust = false;
  const auto trusting = optimise_gnc(graph, {.inlier_probability = 0.1});
  ASSERT_TRUE(trusting);
  EXPECT_TRUE(trusting->rejected.empty());
}

// The relaxation cannot determine a pose from edges with partial information only.
TYPED_TEST(GncTest, SkipsTheRelaxationIfEdgesHaveTooLittleInformation) {
  using G = TypeParam;
  Streets<G> streets(5);
  auto graph = streets.with_false_loops(0.1);
  const auto loops = graph.edges.size();
  const int last = graph.add_pose(graph.poses.back());
  SquareOf<G> first = SquareOf<G>::Identity(), second = first;
  for (int k = 0; k < G::kDof; ++k) (k % 2 == 0 ? first : second)(k, k) = 0.0;
  graph.edges.push_back({last - 1, last, G(), 1e3 * first, false});
  graph.edges.push_back({last - 1, last, G(), 1e3 * second, false});
  const auto report = optimise_gnc(graph);
  ASSERT_TRUE(report) << report.error().to_string();
  expect_only_false_rejected(report->rejected, streets.graph().edges.size(), loops);
}

// Two edges contradict each other and nothing supports either.
TYPED_TEST(GncTest, NamesAPoseWithRejectedEdgesOnly) {
  using G = TypeParam;
  PoseGraph<G> graph{{G(), G()}, {}, {}, {}};
  for (const double x : {10.0, -10.0}) {
    const G z = G::exp(x * TangentOf<G>::Unit(0));
    graph.edges.push_back({0, 1, z, SquareOf<G>::Identity(), true});
  }
  const auto report = optimise_gnc(graph, {.start_from_trusted = false});
  ASSERT_FALSE(report);
  EXPECT_THAT(report.error().message,
              HasSubstr("pose 1 is not connected to pose 0 by edges that agree with the others"));
  EXPECT_EQ(graph.poses[1].minus(G()).norm(), 0.0);
}

TYPED_TEST(GncTest, AGraphWithoutFreePosesIsValid) {
  PoseGraph<TypeParam> graph;
  EXPECT_THAT(optimise_gnc(graph).error().message, HasSubstr("no poses"));
  graph.add_pose(TypeParam());
  EXPECT_TRUE(optimise_gnc(graph));
  graph.add_pose(TypeParam());
  EXPECT_THAT(optimise_gnc(graph).error().message, HasSubstr("pose 1 is not connected"));
}

TEST(GncWeight, FallsFromOneToZeroAndBecomesTheLoss) {
  for (const auto loss : {GncLoss::truncated_least_squares, GncLoss::geman_mcclure}) {
    for (const double mu : {1e-6, 1e-3, 0.3, 1.0, 30.0, 1e5}) {
      double last = 1.0;
      EXPECT_EQ(gnc_weight(loss, 0.0, mu), 1.0);
      for (double u = 1e-8; u < 1e9; u *= 1.3) {
        const double w = gnc_weight(loss, u, mu);
        EXPECT_GE(w, 0.0);
        EXPECT_LE(w, last);
        last = w;
      }
      EXPECT_LT(last, 1e-3);
    }
  }
  // The weight is continuous between the pieces of the loss.
  for (const double mu : {1e-3, 1.0, 30.0}) {
    for (const double border : {mu / (mu + 1.0), (mu + 1.0) / mu}) {
      const double step = 1e-9 * border;
      EXPECT_NEAR(gnc_weight(GncLoss::truncated_least_squares, border - step, mu),
                  gnc_weight(GncLoss::truncated_least_squares, border + step, mu), 1e-6);
    }
  }
  EXPECT_EQ(gnc_weight(GncLoss::truncated_least_squares, 0.999, 1e4), 1.0);
  EXPECT_EQ(gnc_weight(GncLoss::truncated_least_squares, 1.001, 1e4), 0.0);
  const RobustKernel kernel{RobustKernelKind::geman_mcclure, 3.0};
  for (const double u : {0.1, 1.0, 7.0})
    EXPECT_NEAR(gnc_weight(GncLoss::geman_mcclure, u, 1.0), kernel(9.0 * u).weight, 1e-12);
}

class RealOutliers : public ::testing::TestWithParam<std::pair<const char*, const char*>> {};

TEST_P(RealOutliers, AllFalseLoopsAreFoundAndNoOther) {
  const auto read = [](const std::string& path) {
    return io::to_pose_graph(std::get<io::GraphFile<SE2d>>(*io::read_g2o(path)));
  };
  const std::string folder = "posegraph/";
  WAYFARE_NEEDS_RECORDING(clean_path, folder + GetParam().first + ".g2o.gz");
  WAYFARE_NEEDS_RECORDING(path, folder + GetParam().second + ".g2o.gz");
  auto clean = read(clean_path), graph = read(path);
  ASSERT_TRUE(optimise(clean));
  const auto report = optimise_gnc(graph);
  ASSERT_TRUE(report) << report.error().to_string();
  expect_only_false_rejected(report->rejected, clean.edges.size(), graph.edges.size());
  EXPECT_LT(rms_distance(graph.poses, clean.poses), 1e-2);
}

INSTANTIATE_TEST_SUITE_P(Published, RealOutliers,
                         ::testing::Values(std::pair("M3500", "M3500_out100"),
                                           std::pair("intel_943_odo", "intel_943_odo_out100")),
                         [](const auto& instance) {
                           const std::string name = instance.param.first;
                           return name.substr(0, name.find('_'));
                         });

}  // namespace
}  // namespace wayfare
