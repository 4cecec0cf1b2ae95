#pragma once

// Why the result of a run on a robot's log is in doubt.

#include <cstddef>
#include <string>

#include <wayfare/sensors/recording.hpp>
#include <wayfare/sensors/trajectory.hpp>
#include <wayfare/slam/scan_outcome.hpp>

#include "command_line.hpp"
#include "slam_outputs.hpp"

namespace wayfare::examples {

/// That `count` of `all` are `what`, if they are more than `share` of them.
void doubt_share(Doubt& doubt, std::size_t count, std::size_t all, const std::string& what,
                 double share = 0.5);

/// That odometry contradicts the estimated path in most stretches of 2 m, by more than half of the
/// longer of the two, or in most turns of 45 degrees, by more than half of the larger. Less than
/// five stretches or turns do not count.
void doubt_odometry(Doubt& doubt, const Recording& recording, const Trajectory& path);

/// That odometry leaps, for systems that do not begin a new piece of the trajectory there: by more
/// than 1.5 m and what a robot drives at 3 m/s.
void doubt_leaps(Doubt& doubt, const Recording& recording);

/// That the path leaps where odometry, if there is one, does not: from one scan to the next by more
/// than a metre and twice what it moves at its usual highest speed, that of nine in ten steps.
/// Scans before were placed wrong, or the robot was carried.
void doubt_path_leaps(Doubt& doubt, const Recording& recording, const Trajectory& path);

/// That without odometry no scan was taken for four seconds and five usual steps, for systems that
/// go on where they were: the robot may be elsewhere.
void doubt_gaps(Doubt& doubt, const Recording& recording);

/// That rays cross walls: more than `share` of all, or `of_stretch` of those of the worst stretch.
void doubt_walls(Doubt& doubt, const WallCrossings& crossings, double share, double of_stretch);

/// Of the pieces of a trajectory, where there are several.
[[nodiscard]] Facts piece_facts(const PieceStatistics& pieces);
/// Why a map of pieces is in doubt; empty if it is not: pieces not joined, more than a few per cent
/// of the scans in short ones, rays through walls. With odometry in one piece people cross them,
/// too: `crossings` are then 0.
[[nodiscard]] std::string piece_doubt(const PieceStatistics& pieces, const WallCrossings& crossings,
                                      std::size_t scans);

}  // namespace wayfare::examples
