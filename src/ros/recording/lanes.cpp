#include "ros/recording/lanes.hpp"

#include <cmath>

#include <wayfare/core/statistics.hpp>

namespace wayfare::ros {

Result<std::string> choose_topic(const RecordingFile& file, std::string_view type,
                                 const std::string& named, const char* what,
                                 const std::string& except) {
  std::vector<std::string> fitting;
  std::string list;
  for (const Topic& topic : file.topics())
    if (topic.type == type && (topic.name != except || topic.name == named)) {
      fitting.push_back(topic.name);
      list += (list.empty() ? "" : ", ") + topic.name;
    }
  const std::string of_type = " of " + std::string(type);
  if (named.empty() && fitting.size() > 1)
    return Error{ErrorCode::invalid,
                 "has several topics" + of_type + ": name the " + what + " among " + list,
                 file.path()};
  if (named.empty()) return fitting.empty() ? std::string() : fitting.front();
  if (std::find(fitting.begin(), fitting.end(), named) != fitting.end()) return named;
  return Error{ErrorCode::not_found,
               "has no topic " + named + of_type + (fitting.empty() ? "" : "; there is " + list),
               file.path()};
}

Result<void> Lanes::run(io::Problems& problems) {
  std::set<std::string> topics;
  for (const auto& [topic, lane] : lanes_) topics.insert(topic);
  const io::Problems met = file_.read(topics, [&](const RecordedMessage& raw) {
    Lane& lane = lanes_[raw.topic.name];
    ++lane.messages;
    if (auto taken = lane.take(raw, lane); !taken) {
      Error fault = taken.error();
      fault.message = fault.source + (fault.source.empty() ? "" : " ") + fault.message;
      fault.source = raw.topic.name, fault.line = lane.messages;
      if (!lane.first_fault) lane.first_fault = fault;
      problems.add(std::move(fault));
    }
    return true;
  });
  for (const Error& error : met.first()) problems.add(error);
  for (const auto& sort : sort_) sort();
  for (const auto& [topic, lane] : lanes_)
    if (lane.stamped && lane.late.empty() && lane.first_fault) {
      Error fault = *lane.first_fault;
      fault.message += " (the same for all " + std::to_string(lane.messages) + " messages)";
      if (auto done = refuse(lane, std::move(fault), problems); !done) return done;
    }
  return check_clocks(problems);
}

Result<void> Lanes::refuse(const Lane& lane, Error fault, io::Problems& problems) {
  if (!lane.leave_out) return fault;
  lane.leave_out();
  fault.message += "; left out";
  problems.add(std::move(fault));
  return {};
}

Result<void> Lanes::check_clocks(io::Problems& problems) {
  const std::string* first = nullptr;
  Duration reference{0};
  std::vector<std::pair<const std::string, Lane>*> all;
  for (auto& lane : lanes_) all.push_back(&lane);
  // The required ones determine the clock.
  std::stable_partition(all.begin(), all.end(),
                        [](const auto* lane) { return !lane->second.leave_out; });
  for (auto* named : all) {
    auto& [topic, lane] = *named;
    if (lane.late.empty()) continue;
    const Duration middle = upper_median_of(lane.late);
    if (first == nullptr) {
      first = &topic;
      reference = middle;
    } else if (const Duration apart = wayfare::detail::saturated_difference(middle, reference);
               apart > names_.clock_tolerance || apart < -names_.clock_tolerance) {
      Error fault{ErrorCode::invalid,
                  "is stamped " + std::to_string(to_seconds(apart)) + " s from " + *first +
                      " relative to the times of receipt: their clocks differ; use the times "
                      "of receipt instead",
                  topic};
      if (auto done = refuse(lane, std::move(fault), problems); !done) return done;
    }
  }
  return {};
}

void Layout::listen(Lanes& lanes, const RecordingFile& file, io::Problems& problems) {
  for (const Topic& topic : file.topics())
    if (topic.type == TfMessage::kType.name || topic.type == "tf/tfMessage")
      lanes.visit<TfMessage>(topic.name,
                             [this, &problems, is_static = topic.name.ends_with("tf_static")](
                                 const TfMessage& m) { take(m, is_static, problems); });
}

void Layout::take(const TfMessage& message, bool is_static, io::Problems& problems) {
  for (const TransformStamped& t : message.transforms) {
    tree.add(t);
    if (!truth_frames.empty()) chain.add(t, is_static, problems);
    take(t, problems);
  }
}

void Layout::take(const TransformStamped& t, io::Problems& problems) {
  constexpr std::string_view kOdomFrame = "odom";
  const std::string_view parent = frame_of(t.header);
  std::string_view child = t.child_frame_id;
  if (child.starts_with('/')) child.remove_prefix(1);
  const bool is_truth =
      truth_frames.size() == 2 && parent == truth_frames[0] && child == truth_frames[1];
  if (!is_truth && parent != kOdomFrame) return;
  const auto time = time_of(t.header.stamp);
  const auto pose = plane_pose_of(
      {{t.transform.translation.x, t.transform.translation.y, 0.0}, t.transform.rotation});
  if (!time || !pose) {
    problems.add({ErrorCode::parse, time ? pose.error().message : time.error().message,
                  "transform " + t.child_frame_id});
    return;
  }
  if (is_truth) truth.push_back({*time, Transform2<frame::Map, frame::Base>(*pose)});
  if (parent != kOdomFrame) return;
  by_transforms.push_back({*time, Transform2<frame::Odom, frame::Base>(*pose)});
  odometry_child = t.child_frame_id;
}

std::string Layout::base_frame(const TopicNames& names) const {
  if (!names.base_frame.empty()) return names.base_frame;
  return odometry_child.empty() ? "base_link" : odometry_child;
}

Result<void> take_frame(const Header& header, std::optional<std::string>& frame) {
  if (!frame) frame = frame_of(header);
  return check_frame(header, *frame);
}

Result<LevelMounting> mounting_of(const FrameTree& tree, const std::string& base,
                                  const std::string& frame, io::Problems& problems) {
  const auto found = tree.find(base, frame);
  if (found) return level_mounting_of(*found);
  problems.add(
      {ErrorCode::not_found,
       found.error().message + ": the sensor is assumed at the origin of the robot's frame",
       "frame " + frame});
  return LevelMounting{};
}

}  // namespace wayfare::ros
