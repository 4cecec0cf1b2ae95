#pragma once

// Samples of a Gaussian on a manifold.

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include <wayfare/core/gaussian.hpp>
#include <wayfare/core/manifold.hpp>
#include <wayfare/core/random.hpp>

namespace wayfare {

/// Draws samples of a Gaussian, factorised once, e.g. to move a set of particles. The covariance
/// may be singular.
template <Manifold M>
class GaussianSampler {
 public:
  /// Factorises the covariance.
  explicit GaussianSampler(const Gaussian<M>& g) : mean_(g.mean) {
    const Eigen::LDLT<SquareOf<M>> ldlt(g.covariance);
    const TangentOf<M> root = ldlt.vectorD().cwiseMax(Scalar(0)).cwiseSqrt();
    const SquareOf<M> lower = ldlt.matrixL();
    root_ = ldlt.transpositionsP().transpose() * SquareOf<M>(lower * root.asDiagonal());
  }

  /// One sample.
  [[nodiscard]] M operator()(Rng& rng) const {
    TangentOf<M> white;
    for (auto& w : white) w = Scalar(rng.normal());
    return ManifoldTraits<M>::plus(mean_, root_ * white);
  }

 private:
  using Scalar = typename Gaussian<M>::Scalar;
  M mean_;
  SquareOf<M> root_;  // root · rootᵀ is the covariance
};

}  // namespace wayfare
