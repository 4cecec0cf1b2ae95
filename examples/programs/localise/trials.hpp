#pragma once

// Trials of localisation whose truth is known: found from nowhere, carried away, tracked.

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/slam/localisation.hpp>

namespace wayfare::examples {

/// A pose is right within this.
inline constexpr double kRight_m = 0.5;
inline constexpr double kRight_deg = 10.0;
/// Way within which a robot is to be found, where nothing else is asked for.
inline constexpr double kWay_m = 20.0;

/// A place, the robot's run through it, and its map.
struct Course {
  std::string name;
  Recording recording;  ///< with truth, in the map's frame
  std::shared_ptr<const LocalisationMap> map;
  /// What takes the place to itself, but for small things: a robot may be found there as well.
  std::optional<SE2d> symmetry = {};
};

/// corridor_loop, room, cluttered_room and, as VOXELS,WAY, the files of a real building's map and
/// of a way through it, with a Turtlebot's LiDAR (360 beams, 5 Hz, 3.5 m); `building`, the
/// demonstration's, with 180 beams of 30 m.
struct CourseOptions {
  std::string world;
  std::uint64_t seed = 1;
  /// With an AWR1843 at its front as well, and a map of what that saw from another robot's known
  /// places on the same way.
  bool radar = false;
  double cell_m = 0.05;
  LocalisationMapOptions map{};
};
[[nodiscard]] Result<Course> make_course(const CourseOptions& options);

/// How a search for the robot went.
struct Search {
  bool found = false;             ///< believed and right after the way, or at the end of the log
  bool mirrored = false;          ///< believed where the place looks the same by its symmetry
  bool wrongly_believed = false;  ///< believed and wrong then
  /// The heaviest place is right, or would be but for the symmetry, believed or not.
  bool narrowed = false;
  double way_m = 0.0;        ///< to where it was right and stayed so; NaN where it was not found
  std::size_t clusters = 0;  ///< places still possible then
  double share_wrong = 0.0;  ///< of all scans on the way, those where it was believed and wrong
};
/// From nowhere, at a place along the course that `seed` decides.
[[nodiscard]] Result<Search> try_global(const Course& course, const LocalisationOptions& options,
                                        std::uint64_t seed, double way_m = kWay_m);
/// Tracked over some metres, then carried away to another place `seed` decides.
[[nodiscard]] Result<Search> try_kidnapped(const Course& course, const LocalisationOptions& options,
                                           std::uint64_t seed, double way_m = kWay_m);

/// The whole course from a known pose.
struct Tracking {
  double rmse_m = 0.0, rmse_deg = 0.0, worst_m = 0.0;
  double believed = 0.0;     ///< fraction of the scans
  double ns_per_beam = 0.0;  ///< of a particle, motion and all
  double particles = 0.0;    ///< mean
};
[[nodiscard]] Result<Tracking> try_tracking(const Course& course,
                                            const LocalisationOptions& options, std::uint64_t seed);

/// Distance and angle between two poses.
struct PoseError {
  double m = 0.0, deg = 0.0;
  [[nodiscard]] bool right() const { return m <= kRight_m && deg <= kRight_deg; }
};
[[nodiscard]] PoseError pose_error(const SE2d& estimate, const SE2d& truth);

}  // namespace wayfare::examples
