#include <wayfare/graph/detail/validate.hpp>

#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tangle.hpp"

namespace wayfare {
namespace {

using ::testing::HasSubstr;
using tests::tangle;

template <class G>
class ValidateTest : public ::testing::Test {
 protected:
  Rng rng_{5};
  PoseGraph<G> graph_ = tangle<G>(rng_);

  std::string fault() const {
    const auto checked = validate(graph_);
    return checked ? "" : checked.error().message;
  }
};
using Groups = ::testing::Types<SE2d, SE3d>;
TYPED_TEST_SUITE(ValidateTest, Groups);

TYPED_TEST(ValidateTest, NamesTheFirstOfSeveralFaultyEdges) {
  EXPECT_EQ(this->fault(), "");
  auto& edges = this->graph_.edges;
  edges[5].information.setZero();
  EXPECT_THAT(this->fault(), HasSubstr("edge 5 (1 -> 4) has zero information"));
  edges[3].information(0, 1) += 1.0;
  EXPECT_THAT(this->fault(), HasSubstr("edge 3 (1 -> 4) has an information matrix that is not "
                                       "symmetric"));
  edges[2].to = 17;
  EXPECT_THAT(this->fault(), HasSubstr("edge 2 (3 -> 17) names pose 17"));
  edges[1].from = -1;
  EXPECT_THAT(this->fault(), HasSubstr("edge 1 (-1 -> 1) names pose -1"));
  this->graph_.fixed.push_back(5);
  EXPECT_THAT(this->fault(), HasSubstr("fixed pose 5 is not in the graph"));
  this->graph_.poses.clear();
  EXPECT_THAT(this->fault(), HasSubstr("no poses"));
}

TYPED_TEST(ValidateTest, UsesTheLabelsOfThePoses) {
  this->graph_.labels = {"40", "41", "42", "43", "dock"};
  this->graph_.edges[3].information.setZero();
  EXPECT_THAT(this->fault(), HasSubstr("edge 3 (41 -> dock)"));
}

// Zero information in a direction is valid; negative information is not.
TYPED_TEST(ValidateTest, AcceptsInformationOfEveryRankButNotIndefinite) {
  using G = TypeParam;
  Rng& rng = this->rng_;
  SquareOf<G>& information = this->graph_.edges[0].information;
  for (int rank = 1; rank <= G::kDof; ++rank) {
    for (const double scale : {1e-12, 1.0, 1e12}) {
      information.setZero();
      for (int k = 0; k < rank; ++k) {
        const TangentOf<G> v = tests::random_tangent<G>(rng, 1.0);
        information += scale * v * v.transpose();
      }
      EXPECT_EQ(this->fault(), "") << "rank " << rank << " of size " << scale;
      // More than the smallest eigenvalue.
      const double less = rank < G::kDof ? 0.1 : 10.0;
      information -= less * information.diagonal().maxCoeff() * SquareOf<G>::Identity();
      EXPECT_THAT(this->fault(), HasSubstr("not positive semi-definite"));
    }
  }
}

TYPED_TEST(ValidateTest, EveryPartNeedsAFixedPose) {
  using G = TypeParam;
  PoseGraph<G> graph;
  for (int i = 0; i < 6; ++i) graph.add_pose(G());
  for (const auto& [a, b] : {std::pair{0, 1}, {1, 2}, {3, 4}, {5, 4}})
    graph.edges.push_back({a, b, G(), SquareOf<G>::Identity(), false});
  EXPECT_THAT(validate(graph).error().message, HasSubstr("pose 3 is not connected to pose 0"));
  graph.fixed = {1, 5};
  EXPECT_TRUE(validate(graph));
  graph.fixed = {4};
  EXPECT_THAT(validate(graph).error().message, HasSubstr("pose 0 is not connected to pose 4"));
  graph.fixed = {1, 2};
  EXPECT_THAT(validate(graph).error().message,
              HasSubstr("pose 3 is not connected to pose 1 or any other fixed pose"));
}

TYPED_TEST(ValidateTest, NamesTheEdgeThatOverflows) {
  auto& edge = this->graph_.edges[4];
  edge.measurement = TypeParam::exp(1e200 * TangentOf<TypeParam>::Unit(0));
  EXPECT_EQ(this->fault(), "");  // the edge itself is valid
  EXPECT_THAT(cost_overflow(this->graph_).message,
              HasSubstr("edge 4 (4 -> 3) has an error too large to square"));
  for (auto& e : this->graph_.edges) {
    e.information *= 1e307;
    e.measurement = TypeParam();
  }
  EXPECT_THAT(cost_overflow(this->graph_).message, HasSubstr("overflows"));
}

// A chain of a hundred thousand poses, connected from its far end: no recursion, no quadratic time.
TEST(Validate, LongChains) {
  PoseGraph2 graph;
  constexpr int kPoses = 100'000;
  for (int i = 0; i < kPoses; ++i) graph.add_pose(SE2d());
  for (int i = kPoses - 1; i > 0; --i)
    graph.edges.push_back({i, i - 1, SE2d(), Eigen::Matrix3d::Identity(), false});
  EXPECT_TRUE(validate(graph));
  graph.edges.erase(graph.edges.begin() + kPoses / 2);
  EXPECT_FALSE(validate(graph));
}

}  // namespace
}  // namespace wayfare
