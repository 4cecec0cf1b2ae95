#pragma once

// Localisation of a whole recording by a localiser of your own:
//
//   BasicLocaliser localiser(map, MyLikelihood{}, OdometryNoise{}, MonteCarloOptions{}, 1);
//   const auto run = run_localisation(recording, localiser);  // Result<LocalisationRun>
//
// With the library's likelihoods: run_localisation of localisation.hpp.

#include <concepts>
#include <cstddef>
#include <optional>
#include <type_traits>
#include <utility>
#include <vector>

#include <wayfare/core/frame.hpp>
#include <wayfare/core/result.hpp>
#include <wayfare/core/time.hpp>
#include <wayfare/filter/particles.hpp>
#include <wayfare/sensors/point_set.hpp>
#include <wayfare/sensors/recording.hpp>
#include <wayfare/slam/detail/recorded_localiser.hpp>
#include <wayfare/slam/localisation.hpp>
#include <wayfare/slam/monte_carlo.hpp>

namespace wayfare {

namespace detail {

template <class L, class Scan>
concept AddsScan = requires(L& localiser, LogTime time, const Scan& scan,
                            const RecordedLocaliser::Odometry& odometry) {
  { localiser.add_scan(time, scan, odometry) } -> std::same_as<Result<MonteCarloOutcome<SE2d>>>;
};

/// Where a localiser says which scans it takes, as BasicLocaliser does, it is asked.
template <class L, class Scan>
constexpr bool takes_scan() {
  if constexpr (requires { L::template takes<Scan>; })
    return L::template takes<Scan>;
  else
    return AddsScan<L, Scan>;
}

}  // namespace detail

/// A localiser in the plane, such as BasicLocaliser: `add_motion(time, odometry)` moves it without
/// a scan, and `add_scan(time, scan, odometry)` returns a Result<MonteCarloOutcome<SE2d>> for a
/// LaserScan, or for a PointSet of radar detections in the base frame, or for both. Optional:
/// `takes<Scan>`, a static bool, where `add_scan` is declared for more types than it is defined
/// for; `particles()`, with `size()`, `state(i)` and `log_weights`, for snapshots.
template <class L>
concept RecordingLocaliser = requires(L& localiser, LogTime time,
                                      const detail::RecordedLocaliser::Odometry& odometry) {
  { localiser.add_motion(time, odometry) } -> std::same_as<Result<void>>;
}
&&(detail::AddsScan<L, LaserScan> || detail::AddsScan<L, PointSet>);

namespace detail {

/// Refuses scans that are not finite, or late, before the localiser sees them.
template <RecordingLocaliser L>
class RecordedLocaliserBy final : public RecordedLocaliser {
  static_assert(takes_scan<L, LaserScan>() || takes_scan<L, PointSet>(),
                "wayfare: the likelihood of a localiser for recordings has a const member "
                "log_likelihood(pose, scan, map) for a LaserScan, or for a PointSet of radar "
                "detections");

 public:
  static constexpr bool kLidar = takes_scan<L, LaserScan>(), kRadar = takes_scan<L, PointSet>();

  RecordedLocaliserBy(L& localiser, const LocalisationControlOf<L>& control)
      : localiser_(localiser), control_(control) {}

  void before(std::size_t scan) override {
    if (control_.before_scan) control_.before_scan(scan, localiser_);
  }
  Result<void> add_motion(LogTime time, const Odometry& odometry) override {
    auto moved = localiser_.add_motion(time, odometry);
    if (moved) last_ = time;
    return moved;
  }
  Result<LocalisationOutcome> add_lidar(const LaserScan& scan, const Odometry& odometry) override {
    if (auto ok = check_lidar(scan, last_); !ok) return ok.error();
    return add(scan.time, scan, odometry, RangeSensor::lidar);
  }
  Result<LocalisationOutcome> add_radar(LogTime time, const PointSet& points_base,
                                        const Odometry& odometry) override {
    if (auto ok = check_radar(time, points_base, last_); !ok) return ok.error();
    return add(time, points_base, odometry, RangeSensor::radar);
  }
  [[nodiscard]] std::vector<PoseParticle> particles() const override {
    if constexpr (requires { weighted_poses(localiser_.particles()); })
      return weighted_poses(localiser_.particles());
    else
      return {};
  }

 private:
  template <class Scan>
  Result<LocalisationOutcome> add(LogTime time, const Scan& scan, const Odometry& odometry,
                                  RangeSensor sensor) {
    if constexpr (takes_scan<L, Scan>()) {
      auto outcome = localiser_.add_scan(time, scan, odometry);
      if (!outcome) return outcome.error();
      last_ = time;
      return LocalisationOutcome{*std::move(outcome), sensor};
    } else {
      return Error{ErrorCode::unsupported, "the localiser takes no scans of this type"};
    }
  }

  L& localiser_;
  const LocalisationControlOf<L>& control_;
  std::optional<LogTime> last_;  // time of the last scan or motion
};

}  // namespace detail

/// Localises a whole recording from the localiser's state on, as run_localisation of
/// localisation.hpp: with the laser scans, where the localiser takes them, and the radar frames,
/// combined into scans, where it takes a PointSet. Scans that are not finite, or not later than the
/// last, are refused.
template <RecordingLocaliser L>
Result<LocalisationRun> run_localisation(
    const Recording& recording, L& localiser,
    const std::type_identity_t<LocalisationControlOf<L>>& control = {}) {
  using By = detail::RecordedLocaliserBy<L>;
  By recorded(localiser, control);
  return detail::run(recorded, recording, {By::kLidar, By::kRadar}, control.progress,
                     control.snapshots_at);
}

}  // namespace wayfare
