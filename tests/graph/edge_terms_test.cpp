#include <wayfare/graph/detail/normal_equations.hpp>

#include <gtest/gtest.h>

#include "tangle.hpp"

namespace wayfare {
namespace {

template <class G>
class EdgeTermsTest : public ::testing::Test {};
using Groups = ::testing::Types<SE2d, SE3d>;
TYPED_TEST_SUITE(EdgeTermsTest, Groups);

// The closed form equals the products of PoseError's Jacobians, with and without information
// between translation and rotation.
TYPED_TEST(EdgeTermsTest, AreTheProductsOfTheErrorsJacobians) {
  using G = TypeParam;
  constexpr int N = static_cast<int>(G::Vector::RowsAtCompileTime);
  Rng rng(31);
  for (int round = 0; round < 40; ++round) {
    auto graph = tests::tangle<G>(rng);
    for (PoseEdge<G>& edge : graph.edges) {
      // Arbitrary errors, including rotations of more than π.
      edge.measurement = G::exp(tests::random_tangent<G>(rng, 4.0));
      if (round % 2 == 0) {
        edge.information.template topRightCorner<N, G::kDof - N>().setZero();
        edge.information.template bottomLeftCorner<G::kDof - N, N>().setZero();
      }
      const G &a = graph.poses[static_cast<std::size_t>(edge.from)],
              &b = graph.poses[static_cast<std::size_t>(edge.to)];
      EdgeTerms<G> got;
      edge_terms(edge, a, b, got);
      const auto l = PoseError<G>::linearise(edge.measurement, a, b);
      const SquareOf<G>& o = edge.information;
      const auto near = [](const auto& x, const auto& y) {
        return (x - y).norm() <= 1e-13 * (1.0 + y.norm());
      };
      EXPECT_TRUE(near(got.from, SquareOf<G>(l.by_from.transpose() * o * l.by_from)));
      EXPECT_TRUE(near(got.to, SquareOf<G>(l.by_to.transpose() * o * l.by_to)));
      EXPECT_TRUE(near(got.between, SquareOf<G>(l.by_from.transpose() * o * l.by_to)));
      EXPECT_TRUE(near(got.from_gradient, TangentOf<G>(l.by_from.transpose() * o * l.error)));
      EXPECT_TRUE(near(got.to_gradient, TangentOf<G>(l.by_to.transpose() * o * l.error)));
      EXPECT_NEAR(got.squared_error, squared_error(graph, edge), 1e-13 * (1.0 + got.squared_error));
    }
  }
}

}  // namespace
}  // namespace wayfare
