// Hector-class SLAM on a recorded log: every scan matched to one map at several resolutions.

#include <string>
#include <vector>

#include <wayfare/system/hector_slam.hpp>

#include "log_program.hpp"

namespace {

using namespace wayfare;

std::vector<examples::OptionField> fields(HectorSlamOptions& o) {
  using examples::option_field;
  return {option_field("cell_m", o.map.finest.resolution_m),
          option_field("levels", o.map.levels),
          option_field("p_free", o.map.model.p_free),
          option_field("p_hit", o.map.model.p_hit),
          option_field("unknown_probability", o.map.unknown_probability),
          option_field("max_iterations", o.match.max_iterations),
          option_field("start_step_deg", o.match.start_step),
          option_field("max_range_m", o.max_range_m),
          option_field("point_spacing_m", o.point_spacing_m),
          option_field("map_travel_m", o.map_travel_m),
          option_field("map_turn_deg", o.map_turn),
          option_field("search_sigmas", o.search_sigmas),
          option_field("independent_points", o.independent_points),
          option_field("least_score", o.least_score)};
}

Result<void> check(const HectorSlamOptions& o) {
  if (o.map.levels <= 8 && o.map.model.p_free < 1 && o.map.model.p_hit < 1 &&
      o.map.unknown_probability <= 1)
    return {};
  return Error{ErrorCode::parse, "levels are at most 8, probabilities below 1"};
}

Result<examples::LogRun> run(const Recording& recording, const HectorSlamOptions& options,
                             const SlamProgress& progress) {
  auto slam = run_hector_slam(recording, options, progress);
  if (!slam) return slam.error();
  const HectorStatistics& s = slam->statistics;
  return examples::LogRun{std::move(slam->trajectory),
                          std::move(slam->map),
                          {},
                          s.scans,
                          s.unmatched_scans,
                          {{"in the map", std::to_string(s.scans_in_map)}},
                          slam->refused_scans,
                          slam->first_refusal};
}

}  // namespace

int main(int argc, char** argv) {
  HectorSlamOptions options;
  return examples::run_log_program(
      argc, argv,
      {"hector_slam", "Hector SLAM",
       "Follow a robot by matching each scan of a recorded log to one map at several resolutions; "
       "no loop closures.",
       fields(options),
       [&](const Recording& recording, const examples::SlamArguments&,
           const SlamProgress& progress) { return run(recording, options, progress); },
       [&] { return check(options); }});
}
