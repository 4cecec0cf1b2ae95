#pragma once

#include <cstddef>
#include <cstdio>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <wayfare/eval/relations.hpp>
#include <wayfare/io/carmen.hpp>
#include <wayfare/io/tum.hpp>

namespace wayfare::testing {

/// A recorded log with true relative poses; cut short where WAYFARE_TEST_SCANS is not 0.
struct LogWithRelations {
  Recording recording;
  std::vector<eval::Relation> relations;
};

inline std::optional<LogWithRelations> read_log_with_relations(const std::string& log_path,
                                                               const std::string& relations_path,
                                                               bool with_odometry) {
  auto log = io::read_carmen(log_path);
  auto relations = io::read_relations(relations_path);
  if (!log || !relations) return std::nullopt;
  if (!with_odometry) log->recording.odometry.clear();
  constexpr std::size_t kScans = WAYFARE_TEST_SCANS;
  if (kScans > 0 && kScans < log->recording.scans.size()) {
    log->recording.scans.resize(kScans);
    std::printf("the first %zu scans only (WAYFARE_TEST_SCANS)\n", kScans);
  }
  return LogWithRelations{std::move(log->recording), std::move(relations->relations)};
}

}  // namespace wayfare::testing
