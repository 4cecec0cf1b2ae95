#pragma once

// The improved proposal of a particle's pose.

#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/gaussian.hpp>
#include <wayfare/core/random.hpp>
#include <wayfare/core/result.hpp>
#include <wayfare/core/se2.hpp>
#include <wayfare/map/likelihood_field.hpp>
#include <wayfare/sensors/point_set.hpp>

namespace wayfare {

/// Samples of a PoseProposal.
struct PoseProposalOptions {
  /// Minimum number of samples over all headings. More: smaller variance of the evidence, slower.
  int samples = 1000;
  /// Minimum number of headings.
  int headings = 40;
  /// Half extent of the samples, in standard deviations of the proposal.
  double reach_sigmas = 3.0;
  /// Errors of neighbouring beams are correlated: ln p(z | x) is scaled to this number of
  /// independent points. 0: all points are independent.
  double independent_points = 0.0;
  /// False: draws follow N(x; match, Σ) p(z | x, m) p(x | motion), like weighted samples of the
  /// proposal (Zhang 2020, 5.3.4). True: p(z | x, m) p(x | motion), within the proposal's extent
  /// (Grisetti et al. 2007, section IV).
  bool divide_by_proposal = false;
};

/// A pose drawn from the weighted samples, and their statistics.
struct PoseDraw {
  SE2d T_map_points;  ///< the pose drawn
  /// ln of the mean of τ over the proposal; with divide_by_proposal ln ∫ τ dx: the factor of a
  /// particle's weight.
  double log_evidence = 0.0;
  /// Mean and covariance of the distribution it was drawn from.
  Gaussian<SE2d> moments;
  int samples = 0;  ///< number evaluated
};

/// A sample of the proposal.
struct WeightedPose {
  SE2d T_map_points;    ///< the drawn pose
  double weight = 0.0;  ///< of the drawn poses, normalised
};

/// τ(x) = p(z | x, m) p(x | motion), with x from N(match, Σ): the improved proposal of a particle's
/// pose (Zhang 2020, 5.3.4; Grisetti et al. 2007), in the log domain.
///
/// The samples are the nodes of a lattice of whole cells, jittered about the match independently at
/// every heading and weighted by the proposal's density. They have the distribution of independent
/// draws with less variance, and one load of a row of the map scores sixteen of them. If the
/// proposal is narrower than a cell, every sample is jittered on its own, at a load each. Reuses
/// its scratch memory: one object per thread.
class PoseProposal {
 public:
  /// Largest half extent of the lattice, cells.
  static constexpr int kMaxHalf = 31;

  /// Errors: no points or some that are not finite, an empty map, covariances that are not positive
  /// definite or whose densities exceed the range of numbers, options out of range.
  Result<PoseDraw> draw(const LikelihoodField& grid, const PointSet& points,
                        const Gaussian<SE2d>& proposal, const Gaussian<SE2d>& motion, Rng& rng,
                        const PoseProposalOptions& options = {});

  /// All samples of the last successful `draw` with weights in proportion to τ, of sum 1; those
  /// below e⁻³⁰ of the largest are 0. None before it, or after an error.
  [[nodiscard]] std::vector<WeightedPose> samples() const;

 private:
  struct Quadratic;
  class LogDensity;
  struct Lattice;
  /// The samples of one heading.
  struct Slice {
    SO2d rotation;
    double heading_rad;      ///< relative to the proposal's mean
    Eigen::Vector2d corner;  ///< the lattice's first node, map, m
  };

  void score(const LikelihoodField& grid, const PointSet& points, const Slice& slice,
             const Lattice& lattice, double* out);
  PoseDraw sample_pose(const Lattice& lattice, Rng& rng);
  [[nodiscard]] std::size_t pick(double sum) const;

  std::vector<std::int32_t> u_, v_, index_;
  std::vector<Slice> slices_;
  std::vector<double> log_tau_;          ///< after a draw: τ, relative to the largest
  double cell_m_ = 0.0;                  ///< of the lattice
  std::size_t columns_ = 0, nodes_ = 0;  ///< 0 nodes: no draw
};

}  // namespace wayfare
