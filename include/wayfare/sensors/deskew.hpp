#pragma once

// A range finder that turns measures the points of a scan one after the other: 182 ms for a
// revolution at 5.5 Hz, in which a laser on a moving carrier goes on. `deskew` moves each point to
// where a laser that measures all of them at one instant would have seen it: p' = T(t)⁻¹ T(tᵢ) p.

#include <cmath>
#include <concepts>
#include <cstddef>
#include <limits>
#include <numbers>
#include <optional>
#include <span>
#include <string>
#include <type_traits>

#include <Eigen/Core>

#include <wayfare/core/result.hpp>
#include <wayfare/core/se2.hpp>
#include <wayfare/core/se3.hpp>
#include <wayfare/core/time.hpp>
#include <wayfare/sensors/scans.hpp>

namespace wayfare {

namespace detail {

template <class P>
struct SweepPose : std::type_identity<P> {};
template <class P>
struct SweepPose<std::optional<P>> : std::type_identity<P> {};

template <class P>
concept PoseOfSweep = std::same_as<typename SweepPose<std::remove_cvref_t<P>>::type, SE2d> ||
    std::same_as<typename SweepPose<std::remove_cvref_t<P>>::type, SE3d>;

}  // namespace detail

/// The pose of a laser at a time, in any frame that stands still: a callable that returns SE2d (in
/// the plane) or SE3d (in space), or an optional one, empty at times it does not cover.
template <class M>
concept SweepMotion = requires(const M& motion, LogTime time) {
  { motion(time) } -> detail::PoseOfSweep;
};

/// SE2d or SE3d, which a motion gives.
template <SweepMotion M>
using SweepPoseOf =
    typename detail::SweepPose<std::remove_cvref_t<std::invoke_result_t<const M&, LogTime>>>::type;

/// A motion in the plane.
template <class M>
concept PlanarSweepMotion = SweepMotion<M> && std::same_as<SweepPoseOf<M>, SE2d>;
/// A motion in space.
template <class M>
concept SpatialSweepMotion = SweepMotion<M> && std::same_as<SweepPoseOf<M>, SE3d>;

namespace detail {

inline bool finite_pose(const SE2d& pose) {
  return pose.translation().allFinite() && std::isfinite(pose.heading().radians());
}
inline bool finite_pose(const SE3d& pose) {
  return pose.translation().allFinite() && pose.rotation().quaternion().coeffs().allFinite();
}

/// "beam 17, 12.3 ms before the instant"
inline std::string place_in_sweep(const std::string& what, LogTime time, LogTime at) {
  const double ms = 1e3 * to_seconds(time - at);
  const std::string side = ms < 0.0 ? " ms before" : " ms after";
  return what + ", " + std::to_string(std::abs(ms)) + side + " the instant";
}

/// The motion at `time`, finite; otherwise an Error that names `what()` was measured then.
template <SweepMotion M, class What>
Result<SweepPoseOf<M>> pose_in_sweep(const M& motion, LogTime time, LogTime at, const What& what) {
  const std::optional<SweepPoseOf<M>> pose = motion(time);
  if (!pose)
    return Error{ErrorCode::not_found, "the motion does not cover the sweep: not known at " +
                                           place_in_sweep(what(), time, at)};
  if (!finite_pose(*pose))
    return Error{ErrorCode::invalid,
                 "the motion is not finite at " + place_in_sweep(what(), time, at)};
  return *pose;
}

inline std::string scan_itself() { return "the scan's instant"; }

/// Bitwise: equal poses move nothing, not even by rounding.
inline bool same_pose(const SE2d& a, const SE2d& b) {
  return a.translation() == b.translation() && a.rotation().matrix() == b.rotation().matrix();
}
inline bool same_pose(const SE3d& a, const SE3d& b) {
  return a.translation() == b.translation() &&
         a.rotation().quaternion().coeffs() == b.rotation().quaternion().coeffs();
}

/// Refuses a sweep that takes 10 s or more, and bearings that are not finite.
inline Result<void> check_sweep(const LaserScan& scan) {
  constexpr double kLongest_s = 10.0;
  if (!(scan.sweep_s() < kLongest_s))
    return Error{ErrorCode::invalid,
                 "the sweep takes " + std::to_string(scan.sweep_s()) + " s: 10 s or more"};
  for (std::size_t i = 0; i < scan.ranges_m.size(); ++i)
    if (!std::isfinite(scan.bearing(i).radians()))
      return Error{ErrorCode::invalid,
                   "the bearing of beam " + std::to_string(i) + " is not finite"};
  return {};
}

/// Calls `visit(i, T)` for every beam, T from the laser's axes then to those at `at`; none where
/// the pose is the same.
template <SweepMotion M, class Visit>
Result<void> for_each_beam(const LaserScan& scan, const M& motion, LogTime at, const Visit& visit) {
  if (auto ok = check_sweep(scan); !ok) return ok;
  const auto then = pose_in_sweep(motion, at, at, scan_itself);
  if (!then) return then.error();
  const auto from_fixed = then->inverse();
  for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
    const LogTime time = scan.beam_time(i);
    const auto pose = pose_in_sweep(motion, time, at, [&] { return "beam " + std::to_string(i); });
    if (!pose) return pose.error();
    using Pose = SweepPoseOf<M>;
    visit(i, same_pose(*pose, *then) ? std::optional<Pose>()
                                     : std::optional<Pose>(from_fixed * *pose));
  }
  return {};
}

}  // namespace detail

/// Moves `points_m`, measured at `times` in the laser's axes of their time, to its axes at `at`.
/// The points of one sweep, in order of time; Errors name the first point that is not finite, is
/// earlier than the one before it, or that the motion does not cover. Points before it are then
/// moved already. Does not allocate.
template <SweepMotion M>
[[nodiscard]] Result<void> deskew(std::span<const LogTime> times, const M& motion, LogTime at,
                                  std::span<typename SweepPoseOf<M>::Vector> points_m) {
  if (times.size() != points_m.size())
    return Error{ErrorCode::invalid, std::to_string(points_m.size()) + " points with " +
                                         std::to_string(times.size()) + " times"};
  const auto then = detail::pose_in_sweep(motion, at, at, detail::scan_itself);
  if (!then) return then.error();
  const auto from_fixed = then->inverse();
  for (std::size_t i = 0; i < times.size(); ++i) {
    const auto name = [&] { return "point " + std::to_string(i); };
    if (!points_m[i].allFinite()) return Error{ErrorCode::invalid, name() + " is not finite"};
    if (i > 0 && times[i] < times[i - 1])
      return Error{ErrorCode::invalid, name() + " is earlier than the one before it"};
    const auto pose = detail::pose_in_sweep(motion, times[i], at, name);
    if (!pose) return pose.error();
    if (!detail::same_pose(*pose, *then)) points_m[i] = (from_fixed * *pose) * points_m[i];
  }
  return {};
}

/// `scan` as the laser would have measured it at the instant `at`: each beam that returned
/// with the bearing and range of its point as seen from there, in the same order. A point that
/// comes to lie outside the limits of the range is dropped (NaN); beams without return keep their
/// range. `instant` is another object; its memory is used again. Errors: a sweep of 10 s or more,
/// bearings or a motion that are not finite, and a motion that does not cover the sweep, with the
/// beam and its time; `instant` is then of no use.
template <PlanarSweepMotion M>
[[nodiscard]] Result<void> deskew(const LaserScan& scan, const M& motion, LogTime at,
                                  LaserScan& instant) {
  instant.time = at;
  instant.first_bearing = scan.first_bearing;
  instant.bearing_step = scan.bearing_step;
  instant.min_range_m = scan.min_range_m;
  instant.max_range_m = scan.max_range_m;
  instant.ranges_m.assign(scan.ranges_m.begin(), scan.ranges_m.end());
  instant.time_increment = Duration::zero();
  instant.bearings.clear();
  for (std::size_t i = 0; i < scan.ranges_m.size(); ++i)
    instant.bearings.push_back(scan.bearing(i));
  return detail::for_each_beam(scan, motion, at, [&](std::size_t i, const std::optional<SE2d>& T) {
    if (!T) return;
    if (!scan.returned(i)) {
      instant.bearings[i] += T->heading();
      return;
    }
    const Eigen::Vector2d p = *T * Eigen::Vector2d(detail::beam_end(scan, i).head<2>());
    // The turn is added to the bearing, which keeps its revolution.
    const Angle turned = scan.bearing(i) + T->heading();
    const double off =
        std::remainder(std::atan2(p.y(), p.x()) - turned.radians(), 2.0 * std::numbers::pi);
    instant.bearings[i] = turned + Angle::radians(off);
    instant.ranges_m[i] = static_cast<float>(p.norm());
    if (!instant.returned(i)) instant.ranges_m[i] = std::numeric_limits<float>::quiet_NaN();
  });
}

/// The level scan (see above) that a range finder on a swaying carrier would have taken at the
/// instant `at`. The motion's frame is level, z up; its axes are those of the result, whose origin
/// is the laser's position at `at`. Errors as for `deskew`.
template <SpatialSweepMotion M>
[[nodiscard]] Result<void> level_scan(const LaserScan& scan, const M& motion, LogTime at,
                                      LaserScan& level, const LevelScanOptions& options = {}) {
  detail::begin_level_scan(scan, options, level);
  level.time = at;
  const auto then = detail::pose_in_sweep(motion, at, at, detail::scan_itself);
  if (!then) return then.error();
  const SO3d& q = then->rotation();
  return detail::for_each_beam(scan, motion, at, [&](std::size_t i, const std::optional<SE3d>& T) {
    if (!scan.returned(i)) return;
    const Eigen::Vector3d end = detail::beam_end(scan, i);
    detail::add_to_level_scan(q * (T ? Eigen::Vector3d(*T * end) : end), options, level);
  });
}

}  // namespace wayfare
