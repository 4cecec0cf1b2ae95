// What a finished run of the filter tells of its recording.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <string>

#include <wayfare/gnss/single_point.hpp>
#include <wayfare/nav/check_drive.hpp>

namespace wayfare {
namespace {

using Cause = DriveFinding::Cause;
using Kind = InnovationRecord::Kind;

/// A heading that is known at least to one side: the filter's equations hold.
constexpr float kKnownHeading_rad = 0.6F;

struct Offered {
  std::size_t count = 0, rejected = 0;
  [[nodiscard]] double share() const {
    return count == 0 ? 0.0 : static_cast<double>(rejected) / static_cast<double>(count);
  }
};

/// Share of the epochs whose ranges agree with each other; one without ranges.
double consistent_share(const std::vector<RangeEpoch>& epochs) {
  std::size_t solved = 0, consistent = 0;
  for (const RangeEpoch& epoch : epochs) {
    const auto point = single_point(epoch);
    if (!point) continue;
    ++solved, consistent += point->consistent ? 1 : 0;
  }
  return solved == 0 ? 1.0 : static_cast<double>(consistent) / static_cast<double>(solved);
}

DriveFinding rejected_finding(const GnssInsRecording& recording, const char* what, double share) {
  char line[240];
  const double alone = consistent_share(recording.ranges);
  const bool receiver = alone < 0.7;
  std::snprintf(line, sizeof line,
                receiver ? "the filter rejects %.0f %% of the %s, and only %.0f %% of the epochs "
                           "agree by themselves"
                         : "the filter rejects %.0f %% of the %s, though %.0f %% of the epochs "
                           "agree by themselves",
                100.0 * share, what, 100.0 * alone);
  return {Cause::rejected, line,
          receiver ? "min_cn0_dbhz, elevation_mask_deg or range_sigma_scale"
                   : "mounting_deg, imu_time_offset_s, units and signs of the unit, imu_noise"};
}

}  // namespace

std::vector<DriveFinding> check_run(const GnssInsRecording& recording,
                                    const GnssInsResult& result) {
  // Of good drives, at most a twentieth is rejected.
  constexpr double kRejectedLimit = 0.1;
  // A phone in a city loses its solution once.
  constexpr std::ptrdiff_t kLostLimit = 3;
  std::vector<DriveFinding> findings;
  std::array<Offered, 6> offered{};
  for (const InnovationRecord& r : result.innovations) {
    Offered& o = offered[static_cast<std::size_t>(r.kind)];
    ++o.count, o.rejected += r.accepted ? 0 : 1;
  }
  Offered worst;
  const char* name = "";
  for (const auto& [kind, text] : {std::pair{Kind::range, "ranges"},
                                   {Kind::range_rate, "range rates"},
                                   {Kind::position, "positions"},
                                   {Kind::velocity, "velocities"}}) {
    const Offered& o = offered[static_cast<std::size_t>(kind)];
    if (o.count > 20 && o.share() > worst.share()) worst = o, name = text;
  }
  if (worst.share() > kRejectedLimit)
    findings.push_back(rejected_finding(recording, name, worst.share()));
  const auto lost = std::ranges::count_if(result.notices, &GnssInsNotice::lost);
  if (lost >= kLostLimit)
    findings.push_back(
        {Cause::reinitialised,
         "the solution was lost and reinitialised " + std::to_string(lost) + " times",
         "mounting_deg, imu_time_offset_s, units and signs of the unit"});
  const bool known = std::any_of(result.points.begin(), result.points.end(), [](const auto& p) {
    return p.sigma[ins_state::kAttitude + 2] < kKnownHeading_rad;
  });
  if (!known && !result.points.empty())
    findings.push_back({Cause::unknown_heading,
                        "the heading stayed unknown: the vehicle did not "
                        "move fast enough to show it",
                        "\"start\" with the heading in the description, or start_speed_mps"});
  return findings;
}

}  // namespace wayfare
