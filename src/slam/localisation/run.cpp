#include <algorithm>
#include <utility>

#include <wayfare/sync/odometry_track.hpp>
#include <wayfare/system/localisation.hpp>

namespace wayfare {
namespace {

// Odometry through a gap between scans, in steps short enough that each is one arc.
void drive_through_gap(Localiser& localiser, const OdometryTrack& odometry, LogTime from,
                       LogTime to) {
  constexpr Duration kStep{500'000'000};
  if (to - from <= 2 * kStep) return;
  const auto steps = std::min<std::int64_t>((to - from) / kStep, 7200);
  for (std::int64_t k = 1; k < steps; ++k) {
    const LogTime time = from + (to - from) / steps * k;
    // Refused only where time does not advance, which the next step makes good.
    static_cast<void>(localiser.add_motion(time, odometry.at(time)).has_value());
  }
}

}  // namespace

Trajectory LocalisationRun::trajectory(bool converged_only) const {
  Trajectory result;
  for (const LocalisationOutcome& o : outcomes)
    if (o.particles > 0 && (o.converged || !converged_only))
      result.push_back({o.time, Transform2<frame::Map, frame::Base>(o.T_map_base.mean)});
  return result;
}

Result<LocalisationRun> run_localisation(const Recording& recording,
                                         std::shared_ptr<const LocalisationMap> map,
                                         LocalisationOptions options, std::uint64_t seed,
                                         const std::optional<Gaussian<SE2d>>& start,
                                         const LocalisationControl& control) {
  options.T_base_laser = recording.T_base_laser;
  Localiser localiser(std::move(map), options, seed);
  if (start)
    if (auto ok = localiser.start_at(*start); !ok) return ok.error();
  const OdometryTrack odometry(recording.odometry);
  std::vector<std::size_t> snapshots;
  const std::size_t n = recording.scans.size();
  for (const double u : control.snapshots_at)
    snapshots.push_back(
        static_cast<std::size_t>(std::clamp(u, 0.0, 1.0) * static_cast<double>(n > 0 ? n - 1 : 0)));
  LocalisationRun run;
  for (std::size_t i = 0; i < n; ++i) {
    const LaserScan& scan = recording.scans[i];
    if (control.before_scan) control.before_scan(i, localiser);
    if (!run.outcomes.empty())
      drive_through_gap(localiser, odometry, run.outcomes.back().time, scan.time);
    auto outcome = localiser.add_scan(scan, odometry.at(scan.time));
    if (outcome) {
      run.outcomes.push_back(*outcome);
    } else if (run.refused_scans++ == 0) {
      run.first_refusal = "scan " + std::to_string(i) + ": " + outcome.error().message;
    }
    if (std::find(snapshots.begin(), snapshots.end(), i) != snapshots.end())
      run.snapshots.push_back({scan.time, localiser.particles()});
    if (control.progress && !control.progress(static_cast<double>(i + 1) / static_cast<double>(n)))
      break;
  }
  if (run.outcomes.empty())
    return Error{ErrorCode::invalid, n == 0 ? "the recording has no scan" : run.first_refusal};
  return run;
}

}  // namespace wayfare
