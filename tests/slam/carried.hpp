#pragma once

// Simulated robots that are lost: carried to another place, or without data for a while.

#include <string_view>
#include <vector>

#include "support.hpp"

namespace wayfare {

/// Rooms of different sizes along a corridor, 20 m × 11 m; driven twice.
inline constexpr std::string_view kFlat = R"(metres_per_character 0.5
route a b c e f e c b a b c e f e
picture
########################################
#        #              #              #
#        #              #      ##      #
#        #              #      ##      #
#   a    #              #              #
#        #              #         f    #
##       #          #####              #
###      ###  ###########              #
#        ###             ##            #
#                                      #
#   b          c                e      #
#                                      #
##  #############  ###########         #
#           #            ###   #########
#           #            ###   #       #
#                              #       #
#    #             d          #       #
#                      #       #       #
########################################
)";

/// The same from both ends, 14 m × 7 m: turned by 180° it covers itself.
inline constexpr std::string_view kSymmetric = R"(metres_per_character 0.5
route a b c d a b c d a
picture
############################
#                          #
#                          #
#   a                  b   #
#                          #
#      ##                  #
#      ##                  #
#                  ##      #
#                  ##      #
#                          #
#   d                  c   #
#                          #
#                          #
############################
)";

/// A stretch of a run, of shares of its length.
struct Stretch {
  double from = 0.0, to = 1.0;
};

/// The stretches one after another: between them the robot is carried. Its odometry leaps, or, if
/// `lifted`, continues as if nothing had happened.
inline sim::SimulatedRun carried(const sim::SimulatedRun& run,
                                 const std::vector<Stretch>& stretches, bool lifted = false) {
  sim::SimulatedRun result = run;
  result.recording.scans.clear();
  result.recording.odometry.clear();
  result.truth.clear();
  const LogTime begin = run.recording.scans.front().time;
  const double length_s = to_seconds(run.recording.scans.back().time - begin);
  double placed_s = 0.0;
  for (const Stretch& s : stretches) {
    const double from_s = s.from * length_s, to_s = s.to * length_s;
    const auto moved = [&](LogTime t) { return t + from_seconds(placed_s - from_s); };
    const auto is_in = [&](LogTime t) {
      return to_seconds(t - begin) >= from_s && to_seconds(t - begin) < to_s;
    };
    for (const LaserScan& scan : run.recording.scans)
      if (is_in(scan.time)) result.recording.scans.emplace_back(scan).time = moved(scan.time);
    SE2d by;
    bool first = true;
    for (const OdometrySample& o : run.recording.odometry) {
      if (!is_in(o.time)) continue;
      if (first && lifted && !result.recording.odometry.empty())
        by = result.recording.odometry.back().T_odom_base.raw() * o.T_odom_base.raw().inverse();
      first = false;
      OdometrySample& at = result.recording.odometry.emplace_back(o);
      at.time = moved(o.time);
      at.T_odom_base = Transform2<frame::Odom, frame::Base>(by * o.T_odom_base.raw());
    }
    for (const StampedPose& pose : run.truth)
      if (is_in(pose.time)) result.truth.emplace_back(pose).time = moved(pose.time);
    placed_s += to_s - from_s + 0.2;
  }
  return result;
}

/// Without the scans and odometry of these seconds.
inline sim::SimulatedRun with_hole(sim::SimulatedRun run, double from_s, double length_s) {
  const LogTime begin = run.recording.scans.front().time;
  const auto is_in = [&](const auto& x) {
    const double t = to_seconds(x.time - begin);
    return t >= from_s && t < from_s + length_s;
  };
  std::erase_if(run.recording.scans, is_in);
  std::erase_if(run.recording.odometry, is_in);
  return run;
}

}  // namespace wayfare
