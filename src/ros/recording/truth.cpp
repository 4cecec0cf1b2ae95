#include "ros/recording/truth.hpp"

#include <algorithm>
#include <utility>

namespace wayfare::ros {
namespace {

Result<StampedPose> truth_of(const Pose& pose, LogTime time) {
  const auto in_plane = plane_pose_of(pose);
  if (!in_plane) return in_plane.error();
  return StampedPose{time, Transform2<frame::Map, frame::Base>(*in_plane)};
}

}  // namespace

bool has_topic(const RecordingFile& file, const std::string& name, std::string_view type) {
  for (const Topic& topic : file.topics())
    if (topic.type == type && (name.empty() || topic.name == name)) return true;
  return false;
}

Result<std::string> choose_truth(const RecordingFile& file, const TopicNames& names) {
  if (names.truth_frames.size() == 2) return std::string();
  if (!names.truth_frames.empty())
    return Error{ErrorCode::invalid, "the true poses need two frames, parent and child"};
  const std::string name = names.truth.empty() ? RobotTopics{}.truth : names.truth;
  for (const std::string_view type : {Odometry::kType.name, PoseWithCovarianceStamped::kType.name})
    if (has_topic(file, name, type)) return name;
  if (names.truth.empty() && !has_topic(file, name, PoseStamped::kType.name)) return std::string();
  return choose_topic(file, PoseStamped::kType.name, name, "truth");
}

void add_truth(Lanes& lanes, Layout& layout, const RecordingFile& file, const std::string& topic,
               const TopicNames& names, Trajectory& truth) {
  layout.truth_frames = names.truth_frames;
  const Need need = names.truth.empty() ? Need::optional : Need::required;
  const auto with_covariance = [](const auto& m, LogTime t) { return truth_of(m.pose.pose, t); };
  if (has_topic(file, topic, Odometry::kType.name)) {
    lanes.add<Odometry>(topic, truth, with_covariance, need);
  } else if (has_topic(file, topic, PoseWithCovarianceStamped::kType.name)) {
    lanes.add<PoseWithCovarianceStamped>(topic, truth, with_covariance, need);
  } else {
    lanes.add<PoseStamped>(
        topic, truth, [](const PoseStamped& m, LogTime t) { return truth_of(m.pose, t); }, need);
  }
}

Result<void> finish_truth(Layout& layout, const RecordingFile& file, const TopicNames& names,
                          Trajectory& truth, io::Problems& problems) {
  if (!names.truth_frames.empty()) {
    truth = std::exchange(layout.truth, {});
    if (truth.empty()) {
      auto composed = layout.chain.poses(names.truth_frames[0], names.truth_frames[1]);
      if (!composed) return Error{composed.error().code, composed.error().message, file.path()};
      truth = *std::move(composed);
    }
    std::stable_sort(truth.begin(), truth.end(),
                     [](const StampedPose& a, const StampedPose& b) { return a.time < b.time; });
  }
  const auto again =
      std::unique(truth.begin(), truth.end(),
                  [](const StampedPose& a, const StampedPose& b) { return a.time == b.time; });
  if (again == truth.end()) return {};
  problems.add({ErrorCode::parse,
                std::to_string(truth.end() - again) +
                    " true poses have the time of another one: the first is used",
                file.path()});
  truth.erase(again, truth.end());
  return {};
}

Result<TruthRun> read_truth(const RecordingFile& file, const TopicNames& names) {
  TruthRun run;
  run.problems = file.problems();
  const auto topic = choose_truth(file, names);
  if (!topic) return topic.error();
  run.topic = *topic;
  Lanes lanes(file, names);
  Layout layout;
  add_truth(lanes, layout, file, *topic, names, run.truth);
  layout.listen(lanes, file, run.problems);
  if (auto done = lanes.run(run.problems); !done) return done.error();
  if (auto done = finish_truth(layout, file, names, run.truth, run.problems); !done)
    return done.error();
  return run;
}

}  // namespace wayfare::ros
