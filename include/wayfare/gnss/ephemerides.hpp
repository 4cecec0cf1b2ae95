#pragma once

// Names and carrier frequencies of satellites and signals, and broadcast ephemerides: satellite
// orbits and clocks, and the message valid at a time.

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/result.hpp>
#include <wayfare/core/time.hpp>
#include <wayfare/gnss/range_model.hpp>
#include <wayfare/sensors/measurements.hpp>

namespace wayfare {

inline constexpr double kSpeedOfLight_mps = 299792458.0;  ///< c in vacuum, exact

/// Carriers, Hz (IS-GPS-200, Galileo OS SIS ICD, BDS-SIS-ICD B1I/B2I/B3I).
namespace carrier {
inline constexpr double kL1 = 1575.42e6,    ///< GPS and Galileo's band
    kL2 = 1227.60e6,                        ///< GPS
    kL5 = 1176.45e6;                        ///< GPS
inline constexpr double kE1 = kL1,          ///< Galileo
    kE5a = kL5,                             ///< Galileo
    kE5b = 1207.14e6,                       ///< Galileo
    kE5 = 1191.795e6,                       ///< E5a and E5b together
    kE6 = 1278.75e6;                        ///< Galileo
inline constexpr double kB1I = 1561.098e6,  ///< BeiDou
    kB2I = 1207.14e6,                       ///< BeiDou
    kB3I = 1268.52e6,                       ///< BeiDou
    kB1C = kL1;                             ///< BeiDou
/// GLONASS ICD 5.1, 3.3.1.1: channel k is this many steps above channel 0.
inline constexpr double kGlonassL1 = 1602.0e6,  ///< channel 0
    kGlonassL1Step = 0.5625e6;                  ///< between channels
inline constexpr double kGlonassL2 = 1246.0e6,  ///< channel 0
    kGlonassL2Step = 0.4375e6;                  ///< between channels
}  // namespace carrier

/// In the order of arrays by system.
inline constexpr GnssSystem kAllGnssSystems[] = {GnssSystem::gps, GnssSystem::glonass,
                                                 GnssSystem::galileo, GnssSystem::beidou};

/// Place in arrays by system.
[[nodiscard]] constexpr std::size_t index_of(GnssSystem system) {
  return static_cast<std::size_t>(system);
}
/// RINEX's letter: G, R, E, C.
[[nodiscard]] constexpr char letter_of(GnssSystem system) { return "GREC"[index_of(system)]; }
[[nodiscard]] const char* name_of(GnssSystem system);  ///< GPS, GLONASS, Galileo or BeiDou
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

/// Broadcast orbit and clock of GPS, Galileo and BeiDou: a Kepler ellipse with corrections
/// (IS-GPS-200 table 20-I and its equivalents). Angles in rad, rates per second.
struct KeplerianEphemeris {
  SatelliteId satellite;                      ///< that sent it
  Time<GpsClock> toe;                         ///< reference time of the orbit
  Time<GpsClock> toc;                         ///< reference time of the clock
  double sqrt_semi_major_axis = 0.0;          ///< √m
  double eccentricity = 0.0;                  ///< e
  double mean_anomaly_rad = 0.0;              ///< M₀, at `toe`
  double mean_motion_difference_radps = 0.0;  ///< Δn
  double inclination_rad = 0.0;               ///< i₀, at `toe`
  double inclination_rate_radps = 0.0;        ///< its rate
  double ascending_node_rad = 0.0;            ///< Ω₀, at the start of the week of `toe`
  double ascending_node_rate_radps = 0.0;     ///< Ω̇
  double argument_of_perigee_rad = 0.0;       ///< ω
  double cuc_rad = 0.0,                       ///< argument of latitude, cosine of twice itself
      cus_rad = 0.0;                          ///< sine
  double crc_m = 0.0,                         ///< radius, cosine
      crs_m = 0.0;                            ///< sine
  double cic_rad = 0.0,                       ///< inclination, cosine
      cis_rad = 0.0;                          ///< sine
  double clock_bias_s = 0.0,                  ///< a₀, at `toc`
      clock_drift = 0.0,                      ///< a₁, s/s
      clock_drift_rate_per_s = 0.0;           ///< a₂, s/s²
  /// GPS: T_GD. Galileo: BGD E5a/E1 and E5b/E1. BeiDou: T_GD1 (B1/B3) and T_GD2 (B2/B3).
  double group_delay_s[2] = {0.0, 0.0};
  /// Galileo: clock of the E5a/E1 pair (F/NAV), otherwise of E5b/E1 (I/NAV).
  bool clock_of_e5a = false;
  double accuracy_m = 2.0;  ///< URA, SISA
  int issue = 0;            ///< IODE, IODnav, AODE
  int health = 0;           ///< as sent
};

/// Broadcast state of a GLONASS satellite, Earth-fixed (PZ-90, treated as WGS-84).
struct GlonassEphemeris {
  SatelliteId satellite;                                        ///< that sent it
  Time<GpsClock> toe;                                           ///< reference time
  int channel = 0;                                              ///< of the carrier, −7…13
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();         ///< at `toe`
  Eigen::Vector3d velocity_mps = Eigen::Vector3d::Zero();       ///< at `toe`
  Eigen::Vector3d acceleration_mps2 = Eigen::Vector3d::Zero();  ///< due to Sun and Moon
  double clock_bias_s = 0.0;                                    ///< −τ_n
  double clock_drift = 0.0;                                     ///< γ_n
  double l2_minus_l1_s = 0.0;                                   ///< Δτ_n
  int health = 0;    ///< B_n as RINEX gives it; 0 is healthy
  int age_days = 0;  ///< E_n, of the data at `toe`
};

/// Position, velocity and clock error of a satellite, in Earth-fixed axes of the same instant.
struct SatelliteState {
  Eigen::Vector3d position_ecef_m = Eigen::Vector3d::Zero();    ///< m
  Eigen::Vector3d velocity_ecef_mps = Eigen::Vector3d::Zero();  ///< m/s
  double clock_s = 0.0;      ///< satellite time − system time, with relativity
  double clock_drift = 0.0;  ///< its rate, s/s
};

/// IS-GPS-200 20.3.3.4.3 (GPS), Galileo OS SIS ICD 5.1.1, BDS-SIS-ICD 5.2.4.12 with the rotated
/// frame of geostationary satellites; the velocity is the formulas' derivative.
[[nodiscard]] SatelliteState satellite_state(const KeplerianEphemeris& ephemeris,
                                             Time<GpsClock> time);

/// GLONASS ICD 5.1 A.3.1.2: Runge-Kutta of fourth order, Earth's flattening by J2, steps of at most
/// `step_s`; the clock needs no relativity correction. NaN if that takes more than 100 000 steps
/// (69 days by default), where nothing is left of the orbit.
[[nodiscard]] SatelliteState satellite_state(const GlonassEphemeris& ephemeris, Time<GpsClock> time,
                                             double step_s = 60.0);

/// Group delay of the signal on `carrier_hz` relative to the broadcast clock's signal (or pair), s:
/// to be subtracted from the satellite clock. None if the message has no delay for this signal.
[[nodiscard]] std::optional<double> group_delay_s(const KeplerianEphemeris& ephemeris,
                                                  double carrier_hz);
/// Of L2 by Δτ_n; zero on L1.
[[nodiscard]] std::optional<double> group_delay_s(const GlonassEphemeris& ephemeris,
                                                  double carrier_hz);

/// Whether the signal on `carrier_hz` may be used, by the health bits as sent.
[[nodiscard]] bool is_healthy(const KeplerianEphemeris& ephemeris, double carrier_hz);
/// The same for GLONASS.
[[nodiscard]] bool is_healthy(const GlonassEphemeris& ephemeris, double carrier_hz);

/// BeiDou's geostationary satellites, whose ephemerides are in a rotated frame.
[[nodiscard]] bool is_beidou_geostationary(SatelliteId satellite);

/// Largest age of a message relative to its reference time; beyond it the orbit error grows from
/// metres to kilometres. By system: GPS, GLONASS, Galileo, BeiDou.
struct EphemerisLimits {
  /// Before and after the reference time.
  std::array<Duration, kGnssSystems> age = {std::chrono::seconds(7201), std::chrono::seconds(1801),
                                            std::chrono::seconds(14401),
                                            std::chrono::seconds(21601)};
};

using Ephemeris = std::variant<KeplerianEphemeris, GlonassEphemeris>;  ///< of any system

/// The reference time of the orbit.
[[nodiscard]] Time<GpsClock> reference_time(const Ephemeris& ephemeris);
/// The satellite that sent it.
[[nodiscard]] SatelliteId satellite_of(const Ephemeris& ephemeris);
/// By the formulas of its system.
[[nodiscard]] SatelliteState satellite_state(const Ephemeris& ephemeris, Time<GpsClock> time);
/// By the formulas of its system.
[[nodiscard]] std::optional<double> group_delay_s(const Ephemeris& ephemeris, double carrier_hz);
/// By the rule of its system.
[[nodiscard]] bool is_healthy(const Ephemeris& ephemeris, double carrier_hz);

/// Broadcast messages of many satellites, found by satellite and time.
class Ephemerides {
 public:
  /// Rejects values that are not finite or not an orbit of a navigation satellite. Replaces a
  /// stored message of the same satellite, time and source.
  Result<void> add(const Ephemeris& ephemeris);
  /// Adds all of `other`, and its ionosphere and leap seconds if missing here.
  void add(const Ephemerides& other);

  /// The message with the reference time nearest to `time`, at any distance; null if there is none.
  /// Of equal Galileo messages the I/NAV one, for E1, is preferred.
  [[nodiscard]] const Ephemeris* nearest(SatelliteId satellite, Time<GpsClock> time) const;

  /// Whether it has no message.
  [[nodiscard]] bool empty() const { return messages_.empty(); }
  /// Total number of messages.
  [[nodiscard]] std::size_t size() const;
  /// Those with a message, in order.
  [[nodiscard]] std::vector<SatelliteId> satellites() const;
  /// A satellite's messages in order of reference time.
  [[nodiscard]] const std::vector<Ephemeris>& of(SatelliteId satellite) const;

  std::optional<KlobucharModel> gps_ionosphere;     ///< of GPS messages, if broadcast
  std::optional<KlobucharModel> beidou_ionosphere;  ///< of BeiDou messages, if broadcast
  /// GPS − UTC, if broadcast.
  std::optional<int> leap_seconds;

 private:
  std::map<SatelliteId, std::vector<Ephemeris>> messages_;
};

}  // namespace wayfare
