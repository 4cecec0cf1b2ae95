#include "io/carmen/carmen_lines.hpp"

#include <algorithm>
#include <cmath>

#include "io/text/text.hpp"

namespace wayfare::io::carmen {
namespace {

struct Fan {
  double fov_deg, step_deg;
};

/// The fan of a scanner with this number of beams over 180 degrees.
Fan half_circle(std::size_t n) {
  const auto beams = static_cast<double>(n);
  return {180.0, n % 2 == 1 ? 180.0 / std::max(beams - 1.0, 1.0) : 180.0 / beams};
}

Fan fan_by_parameters(std::size_t n, const Parameters& parameters) {
  const double fov_deg = parameters["laser_frontlaser_fov"];
  const double step_deg = parameters["laser_frontlaser_resolution"];
  const bool has_fov = fov_deg > 0.0 && fov_deg <= 360.0;
  const auto beams = static_cast<double>(n);
  Fan fan = half_circle(n);
  if (step_deg > 0.0 && step_deg * (beams - 1.0) <= 361.0) {
    fan = {n % 2 == 1 ? step_deg * (beams - 1.0) : step_deg * beams, step_deg};
  } else if (has_fov) {
    fan.step_deg *= fov_deg / 180.0;
  }
  if (has_fov) fan.fov_deg = fov_deg;
  return fan;
}

/// The ranges within 2 % of the largest one below `limit`, sorted.
std::vector<float> top_ranges(const std::vector<ScanLine>& scans, float limit) {
  float largest = 0.0F;
  for (const ScanLine& scan : scans)
    for (const float r : scan.scan.ranges_m)
      if (r < limit) largest = std::max(largest, r);
  std::vector<float> top;
  for (const ScanLine& scan : scans)
    for (const float r : scan.scan.ranges_m)
      if (r >= 0.98F * largest && r < limit) top.push_back(r);
  std::sort(top.begin(), top.end());
  return top;
}

struct Run {
  std::size_t begin = 0, count = 0;
};

/// The most frequent of sorted values. Values within half a millimetre are equal: logs printed from
/// floats contain one code as 8.183000 and 8.183001.
Run most_frequent(const std::vector<float>& values) {
  Run best;
  for (std::size_t i = 0; i < values.size();) {
    std::size_t end = i;
    while (end < values.size() && values[end] - values[i] < 5e-4F) ++end;
    if (end - i > best.count) best = {i, end - i};
    i = end;
  }
  return best;
}

/// The range that a log writes for "no return", if it is below `limit`; else `limit`.
float no_return_value(const std::vector<ScanLine>& scans, float limit) {
  constexpr std::size_t kMinBeams = 10000;
  std::size_t beams = 0;
  for (const ScanLine& scan : scans) beams += scan.scan.ranges_m.size();
  const std::vector<float> top = top_ranges(scans, limit);
  const Run code = most_frequent(top);
  const bool frequent = code.count * 1000 >= beams && beams >= kMinBeams;
  // Walls are measured at many distances, a code is one value; `begin` counts ranges below it.
  const bool isolated = code.begin * 10 <= code.count;
  return frequent && isolated && code.count * 10 <= beams * 9 ? top[code.begin] : limit;
}

}  // namespace

double Parameters::operator[](const char* name) const {
  const auto found = values_.find(name);
  double value = 0.0;
  if (found != values_.end()) text::to_number(found->second, value);
  return std::isfinite(value) ? value : 0.0;
}

void set_bearings(LaserScan& scan, const Parameters& parameters) {
  const std::size_t n = scan.ranges_m.size();
  const bool usual = n == 180 || n == 181 || n == 360 || n == 361;
  Fan fan = usual ? half_circle(n) : fan_by_parameters(n, parameters);
  if (n == 1) fan.fov_deg = 0.0;
  scan.first_bearing = Angle::degrees(-0.5 * fan.fov_deg);
  scan.bearing_step = Angle::degrees(fan.step_deg);
}

float range_limit(const std::vector<ScanLine>& scans, const Parameters& parameters,
                  const CarmenOptions& options) {
  float limit = options.max_range_m;
  for (const char* name : {"laser_frontlaser_maxrange", "laser_frontlaser_max_range",
                           "laser_laser1_maxrange", "laser_laser1_max_range"}) {
    const double value = parameters[name];
    if (value > 0.5) limit = std::min(limit, static_cast<float>(std::min(value, 1e6)));
  }
  return options.find_no_return_value ? no_return_value(scans, limit) : limit;
}

SE2d mounting(const std::vector<ScanLine>& scans, const Parameters& parameters) {
  const double offset = parameters["robot_frontlaser_offset"];
  const double side = parameters["robot_frontlaser_side_offset"];
  if (offset != 0.0 || side != 0.0) return SE2d(offset, side, Angle());
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  std::optional<SE2d> first;
  for (const ScanLine& line : scans) {
    if (!line.laser_pose || !line.robot_pose) return {};
    const SE2d relative = line.robot_pose->inverse() * *line.laser_pose;
    if (!first) first = relative;
    const Eigen::Vector3d change = relative.minus(*first);
    if (!(change.cwiseAbs().maxCoeff() <= 2e-3)) return {};  // also where it is not finite
    sum += change;
  }
  if (!first || first->log().norm() < 2e-3 || !(first->translation().norm() <= 5.0)) return {};
  return first->plus(sum / static_cast<double>(scans.size()));
}

SE2d radar_mounting(const Parameters& parameters) {
  return SE2d(parameters["robot_radar_offset"], parameters["robot_radar_side_offset"],
              Angle::radians(parameters["robot_radar_angular_offset"]));
}

}  // namespace wayfare::io::carmen
