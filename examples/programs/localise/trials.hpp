#pragma once

// Trials of localisation with known truth: global localisation, kidnapping, tracking.

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/slam/localisation.hpp>

namespace wayfare::examples {

/// Largest errors of a correct pose.
inline constexpr double kCorrect_m = 0.5;
inline constexpr double kCorrect_deg = 10.0;
/// Default distance within which a robot is to be localised.
inline constexpr double kDistance_m = 20.0;

/// A building, the robot's run through it, and its map.
struct Course {
  std::string name;
  Recording recording;  ///< with truth, in the map's frame
  std::shared_ptr<const LocalisationMap> map;
  /// Maps the building to itself, except for details: a robot may be localised there as well.
  std::optional<SE2d> symmetry = {};
};

/// Worlds corridor_loop, room, cluttered_room and, as VOXELS,PATH, the files of a real building's
/// map and of a path through it, with a Turtlebot's LiDAR (360 beams, 5 Hz, 3.5 m); `building`,
/// that of the demo, with 180 beams of 30 m.
struct CourseOptions {
  std::string world;
  std::uint64_t seed = 1;
  /// With an AWR1843 at its front as well, and a map of its detections from the known poses of
  /// another robot on the same path.
  bool radar = false;
  double cell_m = 0.05;
  LocalisationMapOptions map{};
};
[[nodiscard]] Result<Course> make_course(const CourseOptions& options);

/// Result of a search for the robot.
struct Search {
  bool found = false;            ///< converged and correct after the distance, or at the log's end
  bool mirrored = false;         ///< converged at the symmetric pose
  bool wrong = false;            ///< converged and incorrect at the end
  bool best_is_correct = false;  ///< the best cluster, up to symmetry, converged or not
  double distance_m = 0.0;       ///< until it stayed correct; NaN if not found
  std::size_t clusters = 0;      ///< at the end
  double share_wrong = 0.0;      ///< of all scans, those converged and incorrect
};
/// Global localisation from a position on the course given by `seed`.
[[nodiscard]] Result<Search> try_global(const Course& course, const LocalisationOptions& options,
                                        std::uint64_t seed, double distance_m = kDistance_m);
/// Tracked over some metres, then kidnapped to another position given by `seed`.
[[nodiscard]] Result<Search> try_kidnapped(const Course& course, const LocalisationOptions& options,
                                           std::uint64_t seed, double distance_m = kDistance_m);

/// Tracking over the whole course from a known pose.
struct Tracking {
  double rmse_m = 0.0, rmse_deg = 0.0, worst_m = 0.0;
  double converged = 0.0;    ///< fraction of the scans
  double ns_per_beam = 0.0;  ///< and particle, including the motion update
  double particles = 0.0;    ///< mean
};
[[nodiscard]] Result<Tracking> try_tracking(const Course& course,
                                            const LocalisationOptions& options, std::uint64_t seed);

/// Distance and angle between two poses.
struct PoseError {
  double m = 0.0, deg = 0.0;
  [[nodiscard]] bool correct() const { return m <= kCorrect_m && deg <= kCorrect_deg; }
};
[[nodiscard]] PoseError pose_error(const SE2d& estimate, const SE2d& truth);

}  // namespace wayfare::examples
