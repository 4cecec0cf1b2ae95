#include <gtest/gtest.h>

#include <wayfare/core/frame.hpp>
#include <wayfare/core/gaussian.hpp>

namespace wayfare {
static_assert(LieGroup<SO2d> && LieGroup<SE2d> && LieGroup<SO3d> && LieGroup<SE3d>);
static_assert(Manifold<Eigen::Vector3d>);

TEST(SE2, InverseComposesToIdentity) {
  const SE2d x(1.0, -2.0, 0.7_rad);
  EXPECT_LT((x * x.inverse()).log().norm(), 1e-15);
}
}  // namespace wayfare
