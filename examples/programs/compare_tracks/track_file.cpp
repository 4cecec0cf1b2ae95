#include "track_file.hpp"

#include <algorithm>
#include <string_view>
#include <utility>

#include <wayfare/io/nav_text.hpp>
#include <wayfare/io/tum.hpp>

namespace wayfare::examples {
namespace {

enum class Kind { tum, plane, geographic };

bool names_position_on_earth(std::string_view line) {
  return line.find("lat") != line.npos || line.find("ecef_x") != line.npos;
}

/// The first line that is no comment.
std::string_view first_line(std::string_view text, std::size_t skip) {
  while (!text.empty()) {
    const std::string_view line = text.substr(0, text.find('\n'));
    text.remove_prefix(std::min(text.size(), line.size() + 1));
    if (skip > 0) {
      --skip;
      continue;
    }
    const std::size_t begin = line.find_first_not_of(" \t\r");
    if (begin != line.npos && line[begin] != '#') return line.substr(begin);
  }
  return {};
}

Kind kind_of(std::string_view text, const io::ColumnFormat& format) {
  std::string names;
  for (const std::string& name : format.columns) names += name + ' ';
  for (const io::ColumnChoice& choice : format.choices) names += choice.name + ' ';
  if (!names.empty()) return names_position_on_earth(names) ? Kind::geographic : Kind::plane;
  const std::string_view line = first_line(text, format.skip_lines);
  const std::string_view token = line.substr(0, line.find_first_of(" \t,;"));
  if (line.find_first_of(",;") == line.npos && io::parse_nanoseconds(token)) return Kind::tum;
  const bool heading = !line.empty() && line.front() != '<' && line.front() != '%' &&
                       line.find("x_") != line.npos && !names_position_on_earth(line);
  return heading ? Kind::plane : Kind::geographic;
}

Result<void> complete(const io::Problems& problems) {
  if (problems.empty()) return {};
  return problems.first().front();
}

}  // namespace

Result<TrackFile> read_track(const std::string& path, const io::ColumnFormat& format) {
  const auto content = io::read_file(path);
  if (!content) return content.error();
  if (content->damage) return *content->damage;
  TrackFile track{path, {}, {}};
  const Kind kind = kind_of(content->bytes, format);
  if (kind == Kind::tum) {
    const auto file = io::parse_tum(content->bytes, path);
    if (!file) return file.error();
    if (auto good = complete(file->problems); !good) return good.error();
    for (const io::StampedPose3& p : file->trajectory)
      track.local.push_back({p.time, p.T_map_base.raw().translation()});
  } else if (kind == Kind::plane) {
    const auto file = io::parse_poses(content->bytes, path, format);
    if (!file) return file.error();
    if (auto good = complete(file->problems); !good) return good.error();
    track.has_height = !file->heights_m.empty();
    for (std::size_t i = 0; i < file->trajectory.size(); ++i) {
      const Eigen::Vector2d p = file->trajectory[i].T_map_base.raw().translation();
      const double z = track.has_height ? file->heights_m[i] : 0.0;
      track.local.push_back({file->trajectory[i].time, {p.x(), p.y(), z}});
    }
  } else {
    auto file = io::parse_nav(content->bytes, path, format);
    if (!file) return file.error();
    if (auto good = complete(file->problems); !good) return good.error();
    track.geographic = std::move(file->trajectory);
  }
  return track;
}

eval::Track in_local_axes(const TrackFile& file, const Geodetic& origin) {
  if (!file.is_geographic()) return file.local;
  eval::Track track;
  for (const NavState& s : file.geographic) {
    const Eigen::Vector3d ned = ned_from_geodetic(s.position, origin);
    track.push_back({s.time, {ned.y(), ned.x(), -ned.z()}});
  }
  return track;
}

}  // namespace wayfare::examples
