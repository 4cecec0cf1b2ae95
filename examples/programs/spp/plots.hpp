#pragma once

// The plots of spp's report.

#include <vector>

#include <wayfare/io/report.hpp>

#include "outputs.hpp"

namespace wayfare::examples {

[[nodiscard]] io::Plot track_plot(const SppRun& run);
/// `axis`: north, east, down. `errors` must not be empty.
[[nodiscard]] io::Plot errors_plot(const SppRun& run, const std::vector<PositionError>& errors,
                                   int axis);
[[nodiscard]] io::Plot satellites_plot(const SppRun& run);
[[nodiscard]] io::Plot residuals_plot(const SppRun& run);
/// The zenith in the middle, the horizon at 90.
[[nodiscard]] io::Plot sky_plot(const SppRun& run);

}  // namespace wayfare::examples
