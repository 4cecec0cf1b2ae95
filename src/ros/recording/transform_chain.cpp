#include "ros/recording/transform_chain.hpp"

#include <algorithm>
#include <optional>
#include <span>
#include <utility>

#include "ros/transform_parts.hpp"

namespace wayfare::ros {
namespace {

Result<SE2d> in_plane(const SE3d& pose) {
  const auto& q = pose.rotation().quaternion();
  return plane_pose_of(
      {{pose.translation().x(), pose.translation().y(), 0.0}, {q.x(), q.y(), q.z(), q.w()}});
}

std::string in_quotes(std::string_view name) { return "'" + std::string(name) + "'"; }

/// A transform over time, from its parent.
class Step {
 public:
  Step(std::string name, bool is_static, std::vector<TimedPose> poses)
      : name_(std::move(name)), poses_(std::move(poses)), moves_(!is_static && poses_.size() > 1) {
    std::ranges::stable_sort(poses_, {}, &TimedPose::time);
  }

  /// The times at which it is known; none if it is constant.
  [[nodiscard]] std::span<const TimedPose> changes() const {
    return moves_ ? std::span<const TimedPose>(poses_) : std::span<const TimedPose>();
  }
  /// None outside its times, and in long gaps.
  [[nodiscard]] std::optional<SE3d> at(LogTime time) const {
    constexpr Duration kLongest = std::chrono::seconds(2);
    if (!moves_) return poses_.front().pose;
    const auto next = std::ranges::lower_bound(poses_, time, {}, &TimedPose::time);
    if (next == poses_.end()) return std::nullopt;
    if (next->time == time) return next->pose;
    if (next == poses_.begin()) return std::nullopt;
    const TimedPose& before = *(next - 1);
    if (next->time - before.time > kLongest) return std::nullopt;
    const double u = to_seconds(time - before.time) / to_seconds(next->time - before.time);
    return interpolate(before.pose, next->pose, u);
  }
  [[nodiscard]] std::string span() const {
    return name_ + " is from " + std::to_string(poses_.front().time.seconds()) + " to " +
           std::to_string(poses_.back().time.seconds()) + " s";
  }

 private:
  std::string name_;
  std::vector<TimedPose> poses_;
  bool moves_;
};

using Way = std::vector<Step>;

/// Pose of the beginning of a way in its end.
std::optional<SE3d> at(const Way& way, LogTime time) {
  SE3d pose;
  for (const Step& step : way) {
    const auto up = step.at(time);
    if (!up) return std::nullopt;
    pose = *up * pose;
  }
  return pose;
}

/// The times of the most frequent step.
std::vector<LogTime> times_of(const Way& frame, const Way& base) {
  std::span<const TimedPose> most;
  for (const Way* way : {&frame, &base})
    for (const Step& step : *way)
      if (step.changes().size() > most.size()) most = step.changes();
  std::vector<LogTime> times;
  for (const TimedPose& pose : most) times.push_back(pose.time);
  return times;
}

std::string spans_of(const Way& frame, const Way& base) {
  std::string text;
  for (const Way* way : {&frame, &base})
    for (const Step& step : *way)
      if (!step.changes().empty()) text += (text.empty() ? "" : ", ") + step.span();
  return text;
}

}  // namespace

void TransformChain::add(const TransformStamped& t, bool is_static, io::Problems& problems) {
  const auto pose = rigid(t.transform);
  const auto time = is_static ? Result<LogTime>(LogTime()) : time_of(t.header.stamp);
  if (!pose || !time) {
    problems.add({ErrorCode::parse, pose ? time.error().message : "is no rigid transform",
                  "transform " + t.child_frame_id});
    return;
  }
  Link& link = links_[std::string(without_slash(t.child_frame_id))];
  if (is_static || link.parent != frame_of(t.header)) link.poses.clear();
  link.parent = frame_of(t.header), link.is_static = is_static;
  link.poses.push_back({*time, *pose});
}

std::vector<TransformChain::Named> TransformChain::way_up(std::string_view frame) const {
  std::vector<Named> way;
  for (auto up = links_.find(frame); up != links_.end() && way.size() < links_.size();
       up = links_.find(up->second.parent))
    way.push_back(&*up);
  return way;
}

Error TransformChain::broken(std::string_view base, std::string_view frame) const {
  const auto end = [&](std::string_view from) {
    const auto way = way_up(from);
    return way.empty() ? in_quotes(from) + " has no parent"
                       : in_quotes(from) + " leads up to " + in_quotes(way.back()->second.parent);
  };
  return {ErrorCode::not_found, "has no transform from " + in_quotes(base) + " to " +
                                    in_quotes(frame) + ": the chain is broken, " + end(frame) +
                                    ", " + end(base)};
}

Result<Trajectory> TransformChain::poses(std::string_view base, std::string_view frame) const {
  base = without_slash(base), frame = without_slash(frame);
  std::vector<Named> up_frame = way_up(frame), up_base = way_up(base);
  while (!up_frame.empty() && !up_base.empty() && up_frame.back() == up_base.back())
    up_frame.pop_back(), up_base.pop_back();
  const auto top = [](const std::vector<Named>& way, std::string_view start) {
    return way.empty() ? start : std::string_view(way.back()->second.parent);
  };
  if (top(up_frame, frame) != top(up_base, base)) return broken(base, frame);

  const auto steps = [](const std::vector<Named>& way) {
    Way result;
    for (const Named link : way)
      result.emplace_back(in_quotes(link->second.parent) + " -> " + in_quotes(link->first),
                          link->second.is_static, link->second.poses);
    return result;
  };
  const Way of_frame = steps(up_frame), of_base = steps(up_base);
  const std::string between = " from " + in_quotes(base) + " to " + in_quotes(frame);
  const std::vector<LogTime> times = times_of(of_frame, of_base);
  if (times.empty()) return Error{ErrorCode::degenerate, "has only constant transforms" + between};
  Trajectory result;
  for (const LogTime time : times) {
    const auto T_top_frame = at(of_frame, time), T_top_base = at(of_base, time);
    if (!T_top_frame || !T_top_base) continue;
    const auto pose = in_plane(T_top_base->inverse() * *T_top_frame);
    if (pose) result.push_back({time, Transform2<frame::Map, frame::Base>(*pose)});
  }
  if (!result.empty()) return result;
  return Error{ErrorCode::degenerate, "has no time at which all transforms" + between +
                                          " are known: " + spans_of(of_frame, of_base)};
}

}  // namespace wayfare::ros
