#pragma once

// The likelihood of a scan on a map, as Monte-Carlo localisation takes it.

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <span>

#include <wayfare/core/se2.hpp>
#include <wayfare/core/se3.hpp>
#include <wayfare/filter/particle_filter.hpp>
#include <wayfare/slam/monte_carlo.hpp>

namespace wayfare {

namespace detail {

template <class L>
struct PoseOfLikelihood {
  using Type = SE2d;
};
template <class L>
requires requires { typename L::Pose; }
struct PoseOfLikelihood<L> {
  using Type = typename L::Pose;
};

template <class L>
struct ParticlesOfLikelihood {
  using Type = Particles<typename PoseOfLikelihood<L>::Type>;
};
template <class L>
requires requires { typename L::Storage; }
struct ParticlesOfLikelihood<L> {
  using Type = typename L::Storage;
};

template <class L>
constexpr std::size_t sensors_of() {
  if constexpr (requires { L::kSensors; })
    return L::kSensors;
  else
    return 1;
}

}  // namespace detail

/// SE2d, or the likelihood's member type `Pose`.
template <class L>
using LikelihoodPose = typename detail::PoseOfLikelihood<L>::Type;

/// `log_likelihood(pose, scan, map)` is ln p(scan | pose, map), up to a constant: finite or -inf.
/// With more than one thread it is called concurrently. Optional:
/// - `using Pose = SE3d`;
/// - `search_log_likelihood(pose, scan, map)`, less peaked: until the filter has converged, when
///   particles are sparser;
/// - `agreement(pose, scan, map)` of the scan with the map, in [0, 1]: a search starts where it
///   falls below the usual. Without it, exp(ln p / n) of MonteCarloOptions, at most 1;
/// - `enough(scan)`: whether the scan can be used;
/// - `kSensors` and `sensor(scan)`, below it: agreements of different sensors differ.
template <class L, class Scan, class Map>
concept PointwiseLikelihood = requires(const L& likelihood, const LikelihoodPose<L>& pose,
                                       const Scan& scan, const Map& map) {
  { likelihood.log_likelihood(pose, scan, map) } -> std::convertible_to<double>;
};

/// `prepare(scan)` is the scan laid out for many poses, with members
/// `weigh(map, search, particles, result)`, which sets ln p of each particle,
/// `agreement(map, pose)`, `enough()` and `sensor()`.
template <class L, class Scan>
concept BatchedLikelihood = requires(const L& likelihood, const Scan& scan) {
  { likelihood.prepare(scan).enough() } -> std::convertible_to<bool>;
};

template <class L, class Scan, class Map>
concept ScanLikelihoodModel = PointwiseLikelihood<L, Scan, Map> || BatchedLikelihood<L, Scan>;

namespace detail {

/// What a type lacks to be a likelihood of scans, in words.
template <class L, class Scan, class Map>
consteval bool check_likelihood() {
  static_assert(ScanLikelihoodModel<L, Scan, Map>,
                "wayfare: a likelihood has a const member log_likelihood(pose, scan, map), which "
                "returns a double, the logarithm of a density");
  return true;
}

/// A scan weighted pose by pose.
template <class L, class Scan>
class PointwiseScan {
 public:
  using Pose = LikelihoodPose<L>;

  PointwiseScan(const L& likelihood, const Scan& scan, const MonteCarloOptions& options)
      : likelihood_(likelihood), scan_(scan), options_(options) {}

  [[nodiscard]] std::size_t sensor() const {
    std::size_t index = 0;
    if constexpr (requires { likelihood_.sensor(scan_); }) index = likelihood_.sensor(scan_);
    WAYFARE_EXPECTS(index < sensors_of<L>(), "a sensor of a likelihood is below its kSensors");
    return index;
  }
  [[nodiscard]] bool enough() const {
    if constexpr (requires { likelihood_.enough(scan_); })
      return likelihood_.enough(scan_);
    else
      return true;
  }
  template <class Map, class Set>
  void weigh(const Map& map, bool search, const Set& particles, std::span<double> result) const {
    const auto of_pose = [&](const Pose& pose) {
      if constexpr (requires { likelihood_.search_log_likelihood(pose, scan_, map); })
        if (search) return static_cast<double>(likelihood_.search_log_likelihood(pose, scan_, map));
      return static_cast<double>(likelihood_.log_likelihood(pose, scan_, map));
    };
    log_likelihoods(particles, of_pose, result, options_.threads);
  }
  template <class Map>
  [[nodiscard]] double agreement(const Map& map, const Pose& pose) const {
    double value = 0.0;
    if constexpr (requires { likelihood_.agreement(pose, scan_, map); })
      value = likelihood_.agreement(pose, scan_, map);
    else
      value = std::exp(likelihood_.log_likelihood(pose, scan_, map) /
                       options_.independent_measurements);
    return value > 0.0 ? std::min(value, 1.0) : 0.0;  // NaN is no agreement
  }

 private:
  const L& likelihood_;
  const Scan& scan_;
  const MonteCarloOptions& options_;
};

/// The scan, laid out for many poses by the means the likelihood has.
template <class Map, class L, class Scan>
[[nodiscard]] auto prepare_scan(const L& likelihood, const Scan& scan,
                                const MonteCarloOptions& options) {
  static_assert(check_likelihood<L, Scan, Map>());
  if constexpr (BatchedLikelihood<L, Scan>)
    return likelihood.prepare(scan);
  else
    return PointwiseScan<L, Scan>(likelihood, scan, options);
}

}  // namespace detail
}  // namespace wayfare
