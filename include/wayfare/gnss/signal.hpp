#pragma once

// Names and carrier frequencies of satellites and signals.

#include <optional>
#include <string>
#include <string_view>

#include <wayfare/sensors/gnss.hpp>

namespace wayfare {

inline constexpr double kSpeedOfLight_mps = 299792458.0;

/// Carriers, Hz (IS-GPS-200, Galileo OS SIS ICD, BDS-SIS-ICD B1I/B2I/B3I).
namespace carrier {
inline constexpr double kL1 = 1575.42e6, kL2 = 1227.60e6, kL5 = 1176.45e6;
inline constexpr double kE1 = kL1, kE5a = kL5, kE5b = 1207.14e6, kE5 = 1191.795e6, kE6 = 1278.75e6;
inline constexpr double kB1I = 1561.098e6, kB2I = 1207.14e6, kB3I = 1268.52e6, kB1C = kL1;
/// GLONASS ICD 5.1, 3.3.1.1: channel k is this many steps above channel 0.
inline constexpr double kGlonassL1 = 1602.0e6, kGlonassL1Step = 0.5625e6;
inline constexpr double kGlonassL2 = 1246.0e6, kGlonassL2Step = 0.4375e6;
}  // namespace carrier

inline constexpr GnssSystem kAllGnssSystems[] = {GnssSystem::gps, GnssSystem::glonass,
                                                 GnssSystem::galileo, GnssSystem::beidou};

[[nodiscard]] constexpr int index_of(GnssSystem system) { return static_cast<int>(system); }
/// RINEX's letter: G, R, E, C.
[[nodiscard]] constexpr char letter_of(GnssSystem system) { return "GREC"[index_of(system)]; }
[[nodiscard]] const char* name_of(GnssSystem system);
/// By letter; none for other systems (J, S, I).
[[nodiscard]] std::optional<GnssSystem> system_of(char letter);

/// "G05".
[[nodiscard]] std::string to_string(SatelliteId satellite);
/// From "G05", "G 5" or " 5" (GPS); none for other systems and invalid numbers.
[[nodiscard]] std::optional<SatelliteId> parse_satellite(std::string_view text);

/// The carrier of a RINEX 3 band digit ('1' of "C1C"), Hz. GLONASS: of channel `glonass_channel`.
/// None if the system has no such band.
[[nodiscard]] std::optional<double> carrier_hz(GnssSystem system, char band,
                                               int glonass_channel = 0);

}  // namespace wayfare
