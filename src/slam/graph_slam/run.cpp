#include <utility>

#include <wayfare/slam/graph_slam.hpp>

#include "slam/feed_scans.hpp"

namespace wayfare {

Result<GraphSlamRun> run_graph_slam(const Recording& recording, GraphSlamOptions options,
                                    const SlamProgress& progress) {
  options.T_base_laser = recording.T_base_laser;
  GraphSlam slam(options);
  auto refused = detail::feed_scans(slam, recording, progress);
  if (!refused) return refused.error();
  if (auto ok = slam.finish(); !ok) return ok.error();
  return GraphSlamRun{slam.trajectory(), slam.graph(),   slam.map(),
                      slam.statistics(), refused->count, std::move(refused->first)};
}

}  // namespace wayfare
