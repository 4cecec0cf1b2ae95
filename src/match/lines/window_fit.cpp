#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "match/lines/candidates.hpp"

namespace wayfare::lines {
namespace {

constexpr std::size_t kWindow = 25;  // points, as in Liu 2015, section 7.1
constexpr int kDirections = 180;     // bins of 1°
constexpr double kBin_rad = std::numbers::pi / kDirections;
constexpr double kOffsetBin_m = 0.05;

struct Line {
  Segment segment;
  double direction_rad;  ///< within (−90°, 90°]
};

/// The windows whose points are on a line to within twice the noise.
std::vector<Line> window_lines(const Beams& beams, const WallOptions& options) {
  const double noise = std::hypot(options.range_noise_m, options.flatness_m);
  std::vector<Line> lines;
  for (std::size_t i = 0; i + kWindow <= beams.x_m.size(); ++i) {
    const Segment s = fit(beams, i, i + kWindow, noise);
    if (!(s.length_m > 0.0) || s.weight_m < s.length_m) continue;
    lines.push_back({s, std::remainder(std::atan2(s.uy, s.ux), std::numbers::pi)});
  }
  return lines;
}

/// Mean direction of the lines within one bin of the fullest of a histogram.
std::optional<double> most_frequent_direction(const std::vector<Line>& lines,
                                              std::optional<Angle> near) {
  constexpr double kNearDirection_rad = 25.0 * std::numbers::pi / 180.0;
  const auto off = [](double a, double b) { return std::remainder(a - b, std::numbers::pi); };
  std::array<int, kDirections> histogram{};
  for (const Line& line : lines) {
    if (near && std::abs(off(line.direction_rad, near->radians())) > kNearDirection_rad) continue;
    const auto bin = static_cast<int>(std::floor(line.direction_rad / kBin_rad)) + kDirections / 2;
    ++histogram[static_cast<std::size_t>(std::clamp(bin, 0, kDirections - 1))];
  }
  const auto fullest = std::max_element(histogram.begin(), histogram.end());
  if (*fullest == 0) return {};
  const double middle =
      (static_cast<double>(fullest - histogram.begin()) - 0.5 * kDirections + 0.5) * kBin_rad;
  double sum = 0.0, n = 0.0;
  for (const Line& line : lines) {
    const double d = off(line.direction_rad, middle);
    if (std::abs(d) <= 1.5 * kBin_rad) sum += d, n += 1.0;
  }
  return middle + sum / n;
}

/// The wall of one side: mean offset of the lines within one bin of the fullest of a histogram.
struct Side {
  std::vector<double> offsets_m;
  double begin_m = 1e9, end_m = -1e9;

  void add(double offset_m, double along_m, double length_m) {
    offsets_m.push_back(offset_m);
    begin_m = std::min(begin_m, along_m - 0.5 * length_m);
    end_m = std::max(end_m, along_m + 0.5 * length_m);
  }
  [[nodiscard]] std::optional<Wall> wall() const {
    int most = 0;
    double best = 0.0;
    for (const double center : offsets_m) {
      const auto near = [&](double x) { return std::abs(x - center) <= kOffsetBin_m; };
      const auto n = static_cast<int>(std::count_if(offsets_m.begin(), offsets_m.end(), near));
      if (n > most) most = n, best = center;
    }
    if (most == 0) return {};
    double sum = 0.0;
    for (const double x : offsets_m) sum += std::abs(x - best) <= kOffsetBin_m ? x : 0.0;
    return Wall{sum / most, most + static_cast<int>(kWindow) - 1, begin_m, end_m};
  }
};

/// Standard deviations of one window's line over the square root of the disjoint windows.
Eigen::Matrix3d covariance_of(const CorridorWalls& walls, const WallOptions& options) {
  const double noise = std::hypot(options.range_noise_m, options.flatness_m);
  Eigen::Matrix3d c = Eigen::Matrix3d::Zero();
  double weight = 0.0;
  int row = 1;
  for (const auto* wall : {&walls.left, &walls.right}) {
    if (*wall) {
      const double n = (*wall)->beams, length = std::max((*wall)->end_m - (*wall)->begin_m, 0.1);
      c(row, row) = noise * noise / n;
      weight += n * length * length / 12.0;
    }
    ++row;
  }
  c(0, 0) = noise * noise / weight;
  return c;
}

}  // namespace

std::optional<CorridorWalls> windowed_walls(const Beams& beams, std::optional<Angle> near,
                                            const WallOptions& options) {
  const std::vector<Line> lines = window_lines(beams, options);
  const auto direction = most_frequent_direction(lines, near);
  if (!direction) return {};
  const double c = std::cos(*direction), s = std::sin(*direction);
  Side left, right;
  for (const Line& line : lines) {
    if (std::abs(std::remainder(line.direction_rad - *direction, std::numbers::pi)) >
        1.5 * kBin_rad)
      continue;
    const double offset = c * line.segment.y_m - s * line.segment.x_m;
    const double along = c * line.segment.x_m + s * line.segment.y_m;
    (offset > 0.0 ? left : right).add(offset, along, line.segment.length_m);
  }
  CorridorWalls walls;
  walls.direction = Angle::radians(*direction);
  walls.left = left.wall();
  walls.right = right.wall();
  if (!walls.left && !walls.right) return {};
  walls.covariance = covariance_of(walls, options);
  walls.correlation = 1.0;
  const double about = near ? near->radians() : 0.0;
  const double away = std::remainder(*direction - about, 2.0 * std::numbers::pi);
  const bool against = std::abs(away) > 0.5 * std::numbers::pi;
  return against ? reversed(walls) : walls;
}

}  // namespace wayfare::lines
