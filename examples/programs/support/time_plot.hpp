#pragma once

#include <string>
#include <utility>

#include <wayfare/io/report.hpp>

namespace wayfare::examples {

/// An empty plot of something over seconds.
[[nodiscard]] inline io::Plot time_plot(std::string title, std::string y_label) {
  io::Plot plot;
  plot.title = std::move(title);
  plot.x_label = "time [s]";
  plot.y_label = std::move(y_label);
  return plot;
}

}  // namespace wayfare::examples
