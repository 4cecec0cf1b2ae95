#include "chirp_config.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include <wayfare/eval/table.hpp>
#include <wayfare/io/text_file.hpp>

namespace wayfare::examples {

void add_chirps(CommandLine& app, std::string& path) {
  app.add_file("--chirps", path,
               "the radar's chirp configuration (.cfg), for its resolutions, limits and noise");
}

Result<Chirps> read_chirps(const std::string& path) {
  const auto text = io::read_file(path);
  if (!text) return text.error();
  auto config = decode::parse_ti_config(text->bytes, path);
  if (!config) return config.error();
  const decode::TiLimits limits = decode::limits_of(*config);
  return Chirps{*std::move(config), limits};
}

void apply(const Chirps& chirps, RadarVelocityOptions& options) {
  // A speed is rounded to its bin: uniform within it. Echoes leak into the bins beside theirs.
  options.doppler_sigma_m_s = chirps.limits.speed_step_mps / std::sqrt(12.0);
  options.inlier_m_s = 2.5 * chirps.limits.speed_step_mps;
  if (chirps.config.min_range_m > 0.0) options.min_range_m = chirps.config.min_range_m;
}

void apply(const Chirps& chirps, RadarArray& array) {
  array.max_speed_m_s = chirps.limits.max_speed_mps;
  array.receivers = std::popcount(chirps.config.rx_mask);
  array.transmitters = chirps.limits.azimuth_antennas / std::max(1, array.receivers);
}

Facts facts_of(const Chirps& chirps) {
  const decode::TiLimits& l = chirps.limits;
  const decode::TiConfig& c = chirps.config;
  const auto number = [](double value, int decimals, const char* unit) {
    return eval::fixed(value, decimals) + " " + unit;
  };
  return {
      {"range", "bins of " + number(l.range_step_m, 4, "m") + ", resolution " +
                    number(l.range_resolution_m, 4, "m") + ", to " + number(l.max_range_m, 1, "m")},
      {"speed", "bins of " + number(l.speed_step_mps, 4, "m/s") + ", to " +
                    number(l.max_speed_mps, 2, "m/s")},
      {"azimuth", eval::fixed(c.min_azimuth.degrees(), 0) + " to " +
                      number(c.max_azimuth.degrees(), 0, "deg") + ", " +
                      std::to_string(l.azimuth_antennas) + " antennas, resolution " +
                      number(l.azimuth_resolution.degrees(), 1, "deg")},
      {"frames", number(1e3 / c.frame.period_ms, 1, "Hz")}};
}

}  // namespace wayfare::examples
