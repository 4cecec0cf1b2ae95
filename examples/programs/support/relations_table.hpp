#pragma once

#include <string>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/eval/relations.hpp>
#include <wayfare/eval/table.hpp>
#include <wayfare/sensors/recording.hpp>

namespace wayfare::examples {

/// Of no path: none. Says on standard error what had to be skipped.
[[nodiscard]] Result<std::vector<eval::Relation>> read_relations_or_none(const std::string& path);

/// Errors of odometry, where the recording has it, and of `name`'s trajectory: between its poses,
/// and at those nearest to the relations' times.
[[nodiscard]] eval::Table relations_table(const std::string& name, const Recording& recording,
                                          const Trajectory& trajectory,
                                          const std::vector<eval::Relation>& relations);

}  // namespace wayfare::examples
