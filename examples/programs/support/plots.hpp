#pragma once

#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <utility>

#include <wayfare/io/report.hpp>
#include <wayfare/sensors/recording.hpp>

namespace wayfare::examples {

/// An empty plot over time.
[[nodiscard]] inline io::Plot time_plot(std::string title, std::string y_label) {
  return {std::move(title), "time [s]", std::move(y_label), {}};
}

/// An empty plot of the plane.
[[nodiscard]] inline io::Plot top_view(std::string title) {
  return {std::move(title), "x [m]", "y [m]", {}, true};
}

/// The positions of a trajectory, moved by `T`.
[[nodiscard]] inline io::Series path_series(std::string name, const Trajectory& trajectory,
                                            const SE2d& T = {}, io::Mark mark = io::Mark::line) {
  io::Series series{std::move(name), {}, {}, mark};
  for (const StampedPose& pose : trajectory) {
    const Eigen::Vector2d p = T * pose.T_map_base.raw().translation();
    series.add(p.x(), p.y());
  }
  return series;
}

/// A curve of angles in degrees, with a gap at each jump from 180 to -180.
[[nodiscard]] inline io::Series broken_at_wraps(const io::Series& series) {
  io::Series broken{series.name, {}, {}, series.mark};
  for (std::size_t i = 0; i < series.y.size(); ++i) {
    if (i > 0 && std::abs(series.y[i] - series.y[i - 1]) > 180.0)
      broken.add(series.x[i], std::numeric_limits<double>::quiet_NaN());
    broken.add(series.x[i], series.y[i]);
  }
  return broken;
}

/// The curves y = ±`factor` sigma as one series with a gap, so that both share a colour and a line
/// of the legend.
[[nodiscard]] inline io::Series bounds_series(const io::Series& upper) {
  io::Series bounds = upper;
  bounds.mark = io::Mark::dashed;
  if (upper.x.empty()) return bounds;
  bounds.add(upper.x.back(), std::numeric_limits<double>::quiet_NaN());
  for (std::size_t i = 0; i < upper.x.size(); ++i) bounds.add(upper.x[i], -upper.y[i]);
  return bounds;
}

}  // namespace wayfare::examples
