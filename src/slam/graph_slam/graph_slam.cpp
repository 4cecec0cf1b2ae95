#include <wayfare/slam/graph_slam.hpp>

#include <wayfare/slam/detail/graph_slam/engine.hpp>
#include <wayfare/slam/detail/graph_slam/field_matching.hpp>
#include <wayfare/slam/detail/graph_slam/run_over.hpp>

namespace wayfare {

class GraphSlam::Engine : public detail::GraphSlamEngine<detail::FieldMatching> {
 public:
  explicit Engine(const GraphSlamOptions& options)
      : GraphSlamEngine(
            options, [](const GraphSlamOptions& valid) { return detail::FieldMatching(valid); }) {}
};

GraphSlam::GraphSlam(const GraphSlamOptions& options)
    : engine_(detail::make_owned<Engine>(options)) {}

Result<ScanOutcome> GraphSlam::add_scan(const LaserScan& scan,
                                        const std::optional<OdomPose>& odometry) {
  return engine_->add_scan(scan, odometry);
}
Result<void> GraphSlam::finish() { return engine_->finish(); }
Trajectory GraphSlam::trajectory() const { return engine_->trajectory(); }
const PoseGraph2& GraphSlam::graph() const { return engine_->graph(); }
const GraphSlamStatistics& GraphSlam::statistics() const { return engine_->statistics(); }
OccupancyGrid GraphSlam::map(const OccupancyGridOptions& shape,
                             const InverseLidarModel& model) const {
  return engine_->map(shape, model);
}
std::vector<std::uint8_t> GraphSlam::save() const { return engine_->save(); }
Result<GraphSlam> GraphSlam::restore(std::span<const std::uint8_t> bytes,
                                     const GraphSlamOptions& options) {
  GraphSlam slam(options);
  if (auto ok = slam.engine_->restore(bytes); !ok) return ok.error();
  return slam;
}

WallCrossings GraphSlam::wall_crossings(const OccupancyGrid& map) const {
  return engine_->wall_crossings(map);
}

Result<GraphSlamRun> run_graph_slam(const Recording& recording, GraphSlamOptions options,
                                    const SlamProgress& progress,
                                    std::span<const std::uint8_t> saved,
                                    std::vector<std::uint8_t>* state) {
  options.T_base_laser = recording.T_base_laser;
  if (saved.empty()) return detail::run_over(GraphSlam(options), recording, progress, state);
  auto slam = GraphSlam::restore(saved, options);
  return slam ? detail::run_over(*std::move(slam), recording, progress, state) : slam.error();
}

}  // namespace wayfare
