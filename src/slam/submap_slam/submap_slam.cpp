#include <wayfare/slam/submap_slam.hpp>

#include <utility>

#include "slam/submap_slam/engine.hpp"

namespace wayfare {

SubmapSlam::SubmapSlam(const SubmapSlamOptions& options)
    : engine_(std::make_unique<Engine>(options)) {}
SubmapSlam::SubmapSlam(std::unique_ptr<Engine> engine) : engine_(std::move(engine)) {}
SubmapSlam::~SubmapSlam() = default;
SubmapSlam::SubmapSlam(SubmapSlam&&) noexcept = default;
SubmapSlam& SubmapSlam::operator=(SubmapSlam&&) noexcept = default;

Result<ScanOutcome> SubmapSlam::add_scan(const LaserScan& scan, const MotionHint& hint) {
  return engine_->add_scan(scan, hint);
}
Result<void> SubmapSlam::finish() { return engine_->finish(); }
Trajectory SubmapSlam::trajectory() const { return engine_->trajectory(); }
const PoseGraph2& SubmapSlam::graph() const { return engine_->graph(); }
const SubmapSlamStatistics& SubmapSlam::statistics() const { return engine_->statistics(); }
const LocalPlacement& SubmapSlam::local() const { return engine_->local(); }
OccupancyGrid SubmapSlam::map(const OccupancyGridOptions& shape,
                              const InverseLidarModel& model) const {
  return engine_->map(shape, model);
}
std::size_t SubmapSlam::memory_bytes() const { return engine_->memory_bytes(); }
std::vector<std::uint8_t> SubmapSlam::save() const { return engine_->save(); }

Result<SubmapSlam> SubmapSlam::restore(std::span<const std::uint8_t> bytes,
                                       const SubmapSlamOptions& options) {
  auto engine = std::make_unique<Engine>(options);
  if (auto ok = engine->restore(bytes); !ok) return ok.error();
  return SubmapSlam(std::move(engine));
}

}  // namespace wayfare
