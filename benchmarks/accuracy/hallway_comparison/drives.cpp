#include "drives.hpp"

#include <algorithm>
#include <utility>

#include <wayfare/sim/worlds.hpp>

namespace wayfare::examples {

Result<SeedRuns> run_seed(std::uint64_t seed, const DriveOptions& o) {
  const Rng rng(seed);
  const auto world = sim::make_world("corridor_loop", rng);
  if (!world) return world.error();
  const auto recording = sim::simulate_world(*world, sim::turtlebot(rng), rng);
  if (!recording) return recording.error();
  SyncParams sync = sync_params(*recording);
  sync.scans = o.frames;
  sync.min_scans = std::min(sync.min_scans, o.frames);
  const auto steps = synchronise(*recording, sync);
  MatchingOptions options;
  options.window.half_x_m = options.window.half_y_m = o.window_m;
  // Half way along the first corridor, where LiDAR sees nothing but two walls.
  options.surface_at = LogTime::from_seconds(60.0);
  SeedRuns result;
  result.truth = recording->truth;
  for (std::size_t s = 0; s < kSensors.size(); ++s) {
    auto run = localise_by_matching(steps, *recording, kSensors[s],
                                    recording->truth.front().T_map_base.raw(), options);
    if (!run) return run.error();
    result.runs[s] = std::move(run).value();
    result.errors[s] = errors_of(result.runs[s].trajectory, result.truth);
  }
  return result;
}

}  // namespace wayfare::examples
