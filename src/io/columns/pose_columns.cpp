// Trajectories in the plane, as columns or as TUM text.

#include <cmath>
#include <string>
#include <string_view>

#include <wayfare/io/tum.hpp>

#include "io/columns/column_rows.hpp"

namespace wayfare::io {
namespace {

constexpr Quantity kPose[] = {
    {"x", Dimension::length},  {"y", Dimension::length}, {"heading", Dimension::angle},
    {"yaw", Dimension::angle}, {"qx", Dimension::none},  {"qy", Dimension::none},
    {"qz", Dimension::none},   {"qw", Dimension::none},  {"z", Dimension::length}};
enum Column : std::size_t { kX, kY, kHeading, kYaw, kQx, kQw = 7, kZ };

/// TUM text has lines of numbers separated by blanks, and comments.
bool is_tum(std::string_view all) {
  text::Lines lines(all);
  for (std::string_view line; lines.next(line);) {
    const std::string_view first = text::Tokens(line).next();
    if (first.empty() || first.front() == '#') continue;
    return line.find_first_of(",;") == line.npos && parse_nanoseconds(first).has_value();
  }
  return true;
}

std::string take_pose(const ColumnRow& row, const ColumnRows& rows, PoseFile& file) {
  const std::span<const double> v = row.numbers;
  double heading = 0.0;
  if (rows.has(kHeading) || rows.has(kYaw)) {
    heading = v[rows.has(kHeading) ? kHeading : kYaw];
  } else if (rows.has(kQw)) {
    const double pose[] = {v[kX], v[kY], 0.0, v[kQx], v[kQx + 1], v[kQx + 2], v[kQw]};
    const auto in_space = pose_of(pose);
    if (!in_space) return "the quaternion does not have unit length";
    const Eigen::Vector3d ahead = in_space->rotation() * Eigen::Vector3d(1, 0, 0);
    heading = std::atan2(ahead.y(), ahead.x());
  }
  const double z = rows.has(kZ) ? v[kZ] : 0.0;
  if (!std::isfinite(v[kX] + v[kY] + z + heading)) return "not a finite pose";
  if (rows.has(kZ)) file.heights_m.push_back(z);
  file.trajectory.push_back(
      {row.time, Transform2<frame::Map, frame::Base>(SE2d(v[kX], v[kY], Angle::radians(heading)))});
  return {};
}

Result<PoseFile> parse_pose_columns(std::string_view all, const std::string& source,
                                    const ColumnFormat& format) {
  const auto rows = ColumnRows::open(all, source, format, kPose, 2);
  if (!rows) return rows.error();
  if (rows->has(kQw))
    if (auto whole = rows->require(kQx, kQw); !whole) return whole.error();
  PoseFile file;
  file.has_heading = rows->has(kHeading) || rows->has(kYaw) || rows->has(kQw);
  const auto take = [&](const ColumnRow& row) { return take_pose(row, *rows, file); };
  if (rows->for_each(take, file.problems) == 0) return no_content("pose", source, file.problems);
  return file;
}

}  // namespace

Result<PoseFile> parse_poses(std::string_view all, const std::string& source,
                             const ColumnFormat& format) {
  if (format.named() || !is_tum(all)) return parse_pose_columns(all, source, format);
  auto tum = parse_tum(all, source);
  if (!tum) return tum.error();
  PoseFile file{planar(tum->trajectory), {}, true, std::move(tum->problems)};
  for (const StampedPose3& pose : tum->trajectory)
    file.heights_m.push_back(pose.T_map_base.raw().translation().z());
  return file;
}

Result<PoseFile> read_poses(const std::string& path, const ColumnFormat& format) {
  return read_and_parse(path, {}, parse_poses, format);
}

}  // namespace wayfare::io
