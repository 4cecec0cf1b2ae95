// Trajectories, relations and points as lines of text.

#include <algorithm>
#include <cmath>

#include <wayfare/io/map_image.hpp>
#include <wayfare/io/tum.hpp>

#include "io/text/lines.hpp"

namespace wayfare::io {
namespace {

void append_line(std::string& out, LogTime time, const Eigen::Vector3d& t,
                 const Eigen::Quaterniond& q) {
  out += format_nanoseconds(time.nanoseconds());
  append_pose(out, t, q);
  out += '\n';
}

}  // namespace

Result<TumFile> parse_tum(std::string_view all, const std::string& source) {
  TumFile file;
  const auto take = [&](const auto& times, const auto& v) -> std::string {
    const std::optional<SE3d> pose = pose_of(v.data());
    if (!pose) return "the quaternion does not have unit length";
    file.trajectory.push_back({times[0], Transform3<frame::Map, frame::Base>(*pose)});
    return {};
  };
  if (for_each_pose_line<1, 7>(all, source, file.problems, take) == 0)
    return no_content("pose", source, file.problems);
  return file;
}

Result<TumFile> read_tum(const std::string& path, const ReadOptions& options) {
  return read_and_parse(path, options, parse_tum);
}

Trajectory planar(std::span<const StampedPose3> trajectory) {
  Trajectory result;
  result.reserve(trajectory.size());
  for (const StampedPose3& sample : trajectory) {
    const SE3d& pose = sample.T_map_base.raw();
    const Eigen::Vector3d ahead = pose.rotation() * Eigen::Vector3d(1, 0, 0);
    const Angle heading = Angle::radians(std::atan2(ahead.y(), ahead.x()));
    result.push_back({sample.time, Transform2<frame::Map, frame::Base>(SE2d(
                                       pose.translation().x(), pose.translation().y(), heading))});
  }
  return result;
}

std::string format_tum(std::span<const StampedPose> trajectory) {
  std::string out;
  out.reserve(trajectory.size() * 100);
  for (const StampedPose& sample : trajectory) {
    const SE2d& pose = sample.T_map_base.raw();
    const double half = 0.5 * pose.heading().radians();
    append_line(out, sample.time, {pose.x(), pose.y(), 0.0},
                Eigen::Quaterniond(std::cos(half), 0.0, 0.0, std::sin(half)));
  }
  return out;
}

std::string format_tum(std::span<const StampedPose3> trajectory) {
  std::string out;
  out.reserve(trajectory.size() * 140);
  for (const StampedPose3& sample : trajectory) {
    const SE3d& pose = sample.T_map_base.raw();
    append_line(out, sample.time, pose.translation(), pose.rotation().quaternion());
  }
  return out;
}

Result<RelationsFile> parse_relations(std::string_view text, const std::string& source) {
  RelationsFile file;
  const auto take = [&](const auto& times, const auto& v) -> std::string {
    file.relations.push_back({times[0], times[1], SE2d(v[0], v[1], Angle::radians(v[5]))});
    return {};
  };
  if (for_each_pose_line<2, 6>(text, source, file.problems, take) == 0)
    return no_content("relation", source, file.problems);
  return file;
}

Result<RelationsFile> read_relations(const std::string& path, const ReadOptions& options) {
  return read_and_parse(path, options, parse_relations);
}

namespace {

bool is_separator(char c) { return c == '(' || c == ')' || c == ',' || c == ';'; }

bool is_skipped(std::string_view line, const text::Lines&) {
  return line.starts_with('#') || text::trimmed(line).empty();
}

}  // namespace

Result<PointText> parse_points(std::string_view all, const std::string& source) {
  PointText result;
  const auto take = [&](std::string_view whole, const text::Lines&) -> std::string {
    std::string line(whole);
    std::replace_if(line.begin(), line.end(), is_separator, ' ');
    text::Tokens tokens(line);
    Eigen::Vector3d point;
    for (int i = 0; i < 3; ++i)
      if (!tokens.number(point[i]) || !std::isfinite(point[i]))
        return "expected three finite numbers";
    if (!tokens.at_end()) return "more than three numbers";
    result.points_m.push_back(point);
    return {};
  };
  if (for_each_line(all, source, result.problems, is_skipped, take) == 0)
    return Error{ErrorCode::parse, "contains no point", source};
  return result;
}

Result<PointText> read_points(const std::string& path) {
  return read_and_parse(path, {}, parse_points);
}

}  // namespace wayfare::io
