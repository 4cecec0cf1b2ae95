#pragma once

// RINEX 2.10/2.11 and 3.00-3.05, observations and broadcast navigation messages of GPS, GLONASS,
// Galileo and BeiDou, plain or gzip. What is damaged is reported by line and skipped; what is whole
// is kept. Satellites of other systems are counted and passed over. All times become GPS time.

#include <array>
#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/result.hpp>
#include <wayfare/gnss/ephemerides.hpp>
#include <wayfare/gnss/gps_time.hpp>
#include <wayfare/io/text_file.hpp>
#include <wayfare/sensors/gnss.hpp>

namespace wayfare::io {

/// Which signal of a satellite to take: band and attribute of RINEX 3 ("1C" of C1C), the first one
/// that has a code measurement in the epoch. One band a system keeps receiver delays common. The
/// codes of RINEX 2 count as 1C (C1), 1W (P1), 2C (C2), 2W (P2), 5X, 7X, 8X and 6X.
using SignalPreference = std::array<std::vector<std::string>, kGnssSystems>;

/// By system: GPS L1, GLONASS L1, Galileo E1, BeiDou B1I ("1I" is what 3.02 called it).
[[nodiscard]] SignalPreference default_signals();

struct RinexOptions {
  SignalPreference signals = default_signals();
  /// For files that count in UTC and do not give the difference themselves.
  std::vector<LeapSecond> leap_seconds = {leap_second_table().begin(), leap_second_table().end()};
  std::size_t max_problems = 100;  ///< kept in full; all are counted
  ReadOptions file = {};
};

/// Something between the epochs: 1 power failure before the epoch that follows, 2 the antenna
/// starts to move, 3 a new site, 4 header lines, 5 external event, 6 cycle slips.
struct RinexEvent {
  int flag = 0;
  std::optional<Time<GpsClock>> time;
  std::size_t line = 0;
};

struct RinexObservations {
  double version = 0.0;
  std::string marker;
  /// In the order of the file.
  std::vector<ObservationEpoch> epochs;
  std::vector<RinexEvent> events;
  std::optional<Eigen::Vector3d> approximate_position_ecef_m;
  Eigen::Vector3d antenna_up_east_north_m = Eigen::Vector3d::Zero();
  std::optional<int> leap_seconds;
  /// Carrier channels of the header, by slot.
  std::map<SatelliteId, int> glonass_channels;
  Problems problems;
  std::size_t lines = 0;
  std::size_t skipped_epochs = 0;
  std::size_t other_satellites = 0;  ///< observations of systems that are not read
  std::size_t no_signal = 0;         ///< observations without any of the signals asked for
};

/// Errors: the file cannot be read, is no RINEX observation file of a version that is read, or
/// holds no epoch.
[[nodiscard]] Result<RinexObservations> read_rinex_observations(const std::string& path,
                                                                const RinexOptions& options = {});
[[nodiscard]] Result<RinexObservations> parse_rinex_observations(std::string_view text,
                                                                 const std::string& source,
                                                                 const RinexOptions& options = {});

struct RinexNavigation {
  double version = 0.0;
  Ephemerides ephemerides;
  Problems problems;
  std::size_t lines = 0;
  std::size_t messages = 0;        ///< read and taken
  std::size_t other_messages = 0;  ///< of systems that are not read
};

/// Errors: the file cannot be read, or is no RINEX navigation file of a version that is read.
[[nodiscard]] Result<RinexNavigation> read_rinex_navigation(const std::string& path,
                                                            const RinexOptions& options = {});
[[nodiscard]] Result<RinexNavigation> parse_rinex_navigation(std::string_view text,
                                                             const std::string& source,
                                                             const RinexOptions& options = {});

}  // namespace wayfare::io
