#pragma once

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

struct PoseProposalOptions {
  /// At least this many samples, over all headings. More: a steadier evidence, slower.
  int samples = 1000;
  /// Headings the samples are spread over.
  int headings = 40;
  /// How far the samples reach, in standard deviations of the proposal.
  double reach_sigmas = 3.0;
  /// Neighbouring beams err together: ln p(z | x) is scaled as if only this many points were
  /// independent. 0: every point counts.
  double independent_points = 0.0;
  /// False: draws follow N(x; match, Σ) p(z | x, m) p(x | motion), what weighted samples of the
  /// proposal do (Zhang 2020, 5.3.4). True: p(z | x, m) p(x | motion) alone, within the proposal's
  /// reach (Grisetti et al. 2007, section IV).
  bool divide_by_proposal = false;
};

/// A pose drawn from the weighted samples, and what they say together.
struct PoseDraw {
  SE2d T_map_points;
  /// ln of the mean of τ over the proposal; with divide_by_proposal ln ∫ τ dx. The factor a
  /// particle's weight is multiplied by.
  double log_evidence = 0.0;
  /// Mean and covariance of what is drawn from.
  Gaussian<SE2d> moments;
  int samples = 0;
};

/// τ(x) = p(z | x, m) p(x | motion), with x from N(match, Σ): the improved proposal of a particle's
/// pose (Zhang 2020, 5.3.4; Grisetti et al. 2007), in the log domain.
///
/// The samples are the nodes of a lattice with whole cells between them, thrown about the match
/// anew at every heading and weighted by the proposal's density: the same distribution as of
/// independent draws, with less noise, and one load of a row of the map scores sixteen of them. Of
/// a proposal narrower than a cell every sample is thrown by itself, which costs a load each. Keeps
/// its scratch memory between calls: one object a thread.
class PoseProposal {
 public:
  /// The lattice reaches this many cells at most.
  static constexpr int kMaxHalf = 31;

  /// Errors: no points, an empty map, covariances that are not positive definite.
  Result<PoseDraw> draw(const LikelihoodField& grid, const PointSet& points,
                        const Gaussian<SE2d>& proposal, const Gaussian<SE2d>& motion, Rng& rng,
                        const PoseProposalOptions& options = {});

 private:
  struct Quadratic;
  class LogDensity;
  struct Lattice;
  /// The samples of one heading.
  struct Slice {
    SO2d rotation;
    double turn;             ///< from the proposal's heading
    Eigen::Vector2d corner;  ///< the lattice's first node, map, m
  };

  static Slice thrown(const Lattice& lattice, int k, Rng& rng);
  static void finish(const Quadratic& f, double per_value, const Lattice& lattice, double* out);
  void score(const LikelihoodField& grid, const PointSet& points, const Slice& slice,
             const Lattice& lattice, double* out);
  PoseDraw drawn(const Lattice& lattice, Rng& rng);
  [[nodiscard]] std::size_t pick(double sum) const;
  [[nodiscard]] Eigen::Vector3d offset(const Lattice& lattice, std::size_t i) const;

  std::vector<std::int32_t> u_, v_, index_;
  std::vector<Slice> slices_;
  std::vector<double> log_tau_;
};

}  // namespace wayfare
