#include <wayfare/filter/blocks.hpp>

#include <type_traits>

#include <gtest/gtest.h>

namespace wayfare {
namespace {

using Eigen::Vector3d;

/// Φ of a step as a matrix, by the images of the axes.
template <int N, class Phi>
Eigen::Matrix<double, N, N> matrix(const Phi& phi) {
  Eigen::Matrix<double, N, N> m;
  for (int i = 0; i < N; ++i) {
    const Eigen::Matrix<double, N, 1> axis = Eigen::Matrix<double, N, 1>::Unit(i);
    if constexpr (std::is_same_v<Phi, Unchanged>)
      m.col(i) = axis;
    else if constexpr (requires { phi.cwiseProduct(axis); })
      m.col(i) = phi.cwiseProduct(axis);
    else
      m.col(i) = phi(axis);
  }
  return m;
}
template <int N, class Noise>
Eigen::Matrix<double, N, N> covariance(const Noise& noise) {
  if constexpr (std::is_same_v<Noise, NoNoise>)
    return Eigen::Matrix<double, N, N>::Zero();
  else if constexpr (Noise::ColsAtCompileTime == 1)
    return noise.asDiagonal();
  else
    return noise;
}

/// An exact discretisation does not depend on how time is divided:
/// Φ(s + t) = Φ(t) Φ(s) and Q(s + t) = Φ(t) Q(s) Φ(t)ᵀ + Q(t); nothing happens in no time.
template <class Block>
void expect_exact(const Block& block) {
  constexpr int kDof = static_cast<int>(Block::Value::RowsAtCompileTime);
  for (const double s : {0.01, 1.0, 30.0}) {
    for (const double t : {0.02, 2.0, 500.0}) {
      const auto first = block.discretise(s), second = block.discretise(t),
                 both = block.discretise(s + t);
      const auto phi_s = matrix<kDof>(first.phi), phi_t = matrix<kDof>(second.phi);
      const auto q_s = covariance<kDof>(first.noise), q_t = covariance<kDof>(second.noise);
      const auto q = covariance<kDof>(both.noise);
      EXPECT_LE((matrix<kDof>(both.phi) - phi_t * phi_s).norm(), 1e-13 * (s + t)) << s << " " << t;
      const Eigen::Matrix<double, kDof, kDof> composed = phi_t * q_s * phi_t.transpose() + q_t;
      EXPECT_LE((q - composed).norm(), 1e-13 * q.norm()) << s << " " << t;
    }
  }
  const auto none = block.discretise(0.0);
  EXPECT_TRUE(matrix<kDof>(none.phi).isIdentity(0.0));
  EXPECT_EQ(covariance<kDof>(none.noise).norm(), 0.0);
}

TEST(Blocks, StepsAreExactHoweverTimeIsDivided) {
  expect_exact(RandomConstant<2>{});
  expect_exact(RandomWalk<3>{Vector3d(0.1, 2.0, 30.0)});
  expect_exact(GaussMarkov<3>{Vector3d(0.1, 2.0, 30.0), Vector3d(0.5, 100.0, 1e6)});
  expect_exact(ReceiverClockBlock<2>{0.3, 0.1, 0.2});
}

// Long steps forget: Φ = 0 and Q = σ².
TEST(Blocks, GaussMarkovForgetsAndKeepsItsVariance) {
  const auto step = GaussMarkov<1>{3.0, 2.0}.discretise(1e4);
  EXPECT_EQ(step.phi[0], 0.0);
  EXPECT_EQ(step.noise[0], 9.0);
}

}  // namespace
}  // namespace wayfare
