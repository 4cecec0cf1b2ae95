#pragma once

#include <cmath>
#include <cstddef>
#include <limits>

#include <wayfare/io/report.hpp>

namespace wayfare::examples {

/// A curve of angles in degrees with a gap where it leaves at 180 and comes back at -180: what is
/// drawn between the two is no motion.
[[nodiscard]] inline io::Series broken_at_wraps(const io::Series& series) {
  io::Series broken{series.name, {}, {}, series.mark};
  for (std::size_t i = 0; i < series.y.size(); ++i) {
    if (i > 0 && std::abs(series.y[i] - series.y[i - 1]) > 180.0) {
      broken.x.push_back(series.x[i]);
      broken.y.push_back(std::numeric_limits<double>::quiet_NaN());
    }
    broken.x.push_back(series.x[i]);
    broken.y.push_back(series.y[i]);
  }
  return broken;
}

}  // namespace wayfare::examples
