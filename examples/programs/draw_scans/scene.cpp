#include "scene.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

namespace wayfare::examples {
namespace {

constexpr double kBreak = std::numeric_limits<double>::quiet_NaN();

void add_within(io::Series& series, const View& view, const Eigen::Vector2d& p) {
  const bool seen = view.has(p);
  series.add(seen ? p.x() : kBreak, seen ? p.y() : kBreak);
}

/// The walls in pieces, so that those at the edge of the view end there.
io::Series walls_series(const Scene& scene) {
  constexpr double kPiece_m = 0.1;
  io::Series walls{"floor plan", {}, {}};
  for (const sim::Segment& s : scene.plan->segments()) {
    const Eigen::Vector2d a = scene.T_map_plan * s.a_m, b = scene.T_map_plan * s.b_m;
    const bool whole = scene.view.has(a) && scene.view.has(b);
    const double pieces = whole ? 1.0 : std::ceil((b - a).norm() / kPiece_m);
    for (double i = 0.0; i <= pieces; i += 1.0)
      add_within(walls, scene.view, a + i / pieces * (b - a));
    walls.add(kBreak, kBreak);
  }
  return walls;
}

io::Series path_within(std::string name, const Trajectory& path, const View& view, io::Mark mark) {
  io::Series series{std::move(name), {}, {}, mark};
  for (const StampedPose& p : path) add_within(series, view, p.T_map_base.raw().translation());
  return series;
}

std::vector<Eigen::Vector2d> within(std::vector<Eigen::Vector2d> points, const View& view) {
  std::erase_if(points, [&](const Eigen::Vector2d& p) { return !view.has(p); });
  return points;
}

double extent_m(std::span<const std::vector<Eigen::Vector2d>> all) {
  Eigen::Array2d low = Eigen::Array2d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Array2d high = -low;
  for (const auto& points : all)
    for (const Eigen::Vector2d& p : points) {
      low = low.min(p.array());
      high = high.max(p.array());
    }
  return std::max(1.0, (high - low).maxCoeff());
}

}  // namespace

io::GridImage cropped(const io::GridImage& grid, const View& view) {
  if (view.half_m <= 0.0) return grid;
  const Eigen::Vector2d middle = view.middle_m - grid.origin.translation();
  const auto cell = [&](double metres, std::size_t size) {
    return static_cast<std::size_t>(
        std::clamp(std::floor(metres / grid.resolution_m), 0.0, static_cast<double>(size)));
  };
  const std::size_t left = cell(middle.x() - view.half_m, grid.width),
                    right = cell(middle.x() + view.half_m, grid.width),
                    low = cell(middle.y() - view.half_m, grid.height),
                    high = cell(middle.y() + view.half_m, grid.height);
  io::GridImage part;
  part.resolution_m = grid.resolution_m;
  part.width = right - left;
  part.height = high - low;
  const Eigen::Vector2d corner(static_cast<double>(left), static_cast<double>(low));
  part.origin =
      SE2d(Eigen::Vector2d(grid.origin.translation() + grid.resolution_m * corner), SO2d());
  for (std::size_t row = low; row < high; ++row)
    for (std::size_t column = left; column < right; ++column)
      part.occupancy.push_back(grid.occupancy[row * grid.width + column]);
  return part;
}

io::Plot scene_plot(const Scene& scene) {
  io::Plot plot = io::top_view(scene.title);
  if (scene.map) {
    const io::GridImage part = cropped(*scene.map, scene.view);
    if (part.width > 0 && part.height > 0) plot.image = io::plot_image(part);
  }
  if (scene.plan) plot.series.push_back(walls_series(scene));
  const std::array points = {within(scene.points.lidar_m, scene.view),
                             within(scene.points.radar_m, scene.view)};
  const double spacing_m = extent_m(points) / 1000.0;  // about a pixel
  const auto add_points = [&](const char* name, std::size_t i) {
    plot.series.push_back(points_series(name, points[i], spacing_m));
  };
  add_points("radar", 1);
  add_points("LiDAR", 0);  // above the radar's points, which are wider
  plot.series.push_back(path_within("path", scene.path, scene.view, io::Mark::line));
  if (!scene.truth.empty())
    plot.series.push_back(path_within("truth", scene.truth, scene.view, io::Mark::dashed));
  if (scene.at) {
    const Eigen::Vector2d p = scene.at->translation();
    plot.series.push_back({"robot", {p.x()}, {p.y()}, io::Mark::points});
  }
  return plot;
}

}  // namespace wayfare::examples
