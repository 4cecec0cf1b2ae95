#include "relations_table.hpp"

#include <utility>

#include <wayfare/io/tum.hpp>
#include <wayfare/sensors/trajectory.hpp>

#include "program_files.hpp"

namespace wayfare::examples {

Result<std::vector<eval::Relation>> read_relations_or_none(const std::string& path) {
  if (path.empty()) return std::vector<eval::Relation>();
  auto file = io::read_relations(path);
  if (!file) return file.error();
  print_problems(file->problems);
  return std::move(file->relations);
}

eval::Table relations_table(const std::string& name, const Recording& recording,
                            const Trajectory& trajectory,
                            const std::vector<eval::Relation>& relations) {
  eval::Table table({{"relations"}, {"used"}, {"translation", "m"}, {"rotation", "deg"}});
  const auto row = [&](const std::string& who, const Trajectory& estimated, bool nearest = false) {
    const auto e = eval::relations_error(estimated, relations, {.nearest_pose = nearest});
    table.add_row({who, std::to_string(e.used) + " of " + std::to_string(relations.size()),
                   eval::mean_std(e.translation_m.mean, e.translation_m.std, 4),
                   eval::mean_std(e.rotation_deg.mean, e.rotation_deg.std, 3)});
  };
  if (!recording.odometry.empty()) row("odometry", as_trajectory(recording.odometry));
  row(name, trajectory);
  row(name + ", nearest scans", trajectory, true);
  return table;
}

}  // namespace wayfare::examples
