#include <utility>

#include <wayfare/system/hector_slam.hpp>

#include "../feed_scans.hpp"

namespace wayfare {

Result<HectorRun> run_hector_slam(const Recording& recording, HectorSlamOptions options,
                                  const SlamProgress& progress) {
  options.T_base_laser = recording.T_base_laser;
  HectorSlam slam(options);
  auto refused = detail::feed_scans(slam, recording, progress);
  if (!refused) return refused.error();
  return HectorRun{slam.trajectory(), slam.map(), slam.statistics(), refused->count,
                   std::move(refused->first)};
}

}  // namespace wayfare
