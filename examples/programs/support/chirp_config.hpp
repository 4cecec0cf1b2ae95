#pragma once

// A radar's resolutions, limits and noise from its chirp configuration.

#include <string>

#include <wayfare/core/result.hpp>
#include <wayfare/decode/ti_config.hpp>
#include <wayfare/motion/radar_velocity.hpp>
#include <wayfare/sync/augmented_scans.hpp>

#include "command_line.hpp"
#include "program_files.hpp"

namespace wayfare::examples {

/// --chirps, a file.
void add_chirps(CommandLine& app, std::string& path);

/// A .cfg file and what follows from it.
struct Chirps {
  decode::TiConfig config;
  decode::TiLimits limits;
};
/// Errors: those of parse_ti_config, and a file that cannot be read.
[[nodiscard]] Result<Chirps> read_chirps(const std::string& path);

/// Noise and residuals of radial speeds by the Doppler bins, the nearest range.
void apply(const Chirps& chirps, RadarVelocityOptions& options);
/// Largest speed and virtual antennas.
void apply(const Chirps& chirps, RadarArray& array);
/// Resolutions, limits, field of view and frame rate, for people.
[[nodiscard]] Facts facts_of(const Chirps& chirps);

}  // namespace wayfare::examples
