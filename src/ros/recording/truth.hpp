#pragma once

// True poses in a recording: of a topic, or a transform.

#include <string>

#include <wayfare/ros/recording.hpp>

#include "ros/recording/lanes.hpp"

namespace wayfare::ros {

/// Whether the file has a topic of the type; any name if `name` is empty.
[[nodiscard]] bool has_topic(const RecordingFile& file, const std::string& name,
                             std::string_view type);

/// As named, else the topic that `write_robot` uses; empty if there is none, or if a transform is
/// named. Errors: the named topic does not exist.
[[nodiscard]] Result<std::string> choose_truth(const RecordingFile& file, const TopicNames& names);

/// The poses of `topic`, and the transform named, to `truth` while the file is read. Optional
/// unless named.
void add_truth(Lanes& lanes, Layout& layout, const RecordingFile& file, const std::string& topic,
               const TopicNames& names, Trajectory& truth);

/// After the file is read: `truth` in order of time, the first pose of each time. Errors: the named
/// transform does not exist.
[[nodiscard]] Result<void> finish_truth(Layout& layout, const RecordingFile& file,
                                        const TopicNames& names, Trajectory& truth,
                                        io::Problems& problems);

}  // namespace wayfare::ros
