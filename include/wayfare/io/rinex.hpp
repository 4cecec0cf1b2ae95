#pragma once

// RINEX 2.10/2.11 and 3.00-3.05, observations and broadcast navigation messages of GPS, GLONASS,
// Galileo and BeiDou, plain or gzip. Damaged parts are reported by line and skipped. Satellites of
// other systems are counted and skipped. All times are converted to GPS time.

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
#include <wayfare/sensors/measurements.hpp>

namespace wayfare::io {

/// The signals of a satellite in order of preference: band and attribute of RINEX 3 ("1C" of C1C);
/// the first one with a code measurement in the epoch is used. One band per system keeps receiver
/// delays common. The codes of RINEX 2 are treated as 1C (C1), 1W (P1), 2C (C2), 2W (P2), 5X, 7X,
/// 8X and 6X.
using SignalPreference = std::array<std::vector<std::string>, kGnssSystems>;

/// By system: GPS L1, GLONASS L1, Galileo E1, BeiDou B1I ("1I" in version 3.02).
[[nodiscard]] SignalPreference default_signals();

/// Signals and limits of the readers.
struct RinexOptions {
  SignalPreference signals = default_signals();  ///< by system
  /// For files in UTC that do not contain the difference.
  std::vector<LeapSecond> leap_seconds = {leap_second_table().begin(), leap_second_table().end()};
  std::size_t max_problems = 100;  ///< kept in full; all are counted
  ReadOptions file = {};           ///< limits of the file
};

/// An event between epochs: 1 power failure before the next epoch, 2 the antenna starts to move, 3
/// a new site, 4 header lines, 5 external event, 6 cycle slips.
struct RinexEvent {
  int flag = 0;                        ///< 1 to 6, as above
  std::optional<Time<GpsClock>> time;  ///< if given
  std::size_t line = 0;                ///< of the file, from 1
};

/// The content of an observation file.
struct RinexObservations {
  double version = 0.0;  ///< of the format
  std::string marker;    ///< name of the site
  /// In the order of the file.
  std::vector<ObservationEpoch> epochs;
  std::vector<RinexEvent> events;                              ///< in the order of the file
  std::optional<Eigen::Vector3d> approximate_position_ecef_m;  ///< of the header
  /// Of the antenna from the marker.
  Eigen::Vector3d antenna_up_east_north_m = Eigen::Vector3d::Zero();
  std::optional<int> leap_seconds;  ///< GPS − UTC, s, of the header
  /// Carrier channels of the header, by slot.
  std::map<SatelliteId, int> glonass_channels;
  Problems problems;                 ///< parts skipped
  std::size_t lines = 0;             ///< of the file
  std::size_t skipped_epochs = 0;    ///< damaged ones
  std::size_t other_satellites = 0;  ///< observations of unsupported systems
  std::size_t no_signal = 0;         ///< observations without any of the requested signals
};

/// Errors: the file cannot be read, is not a RINEX observation file of a supported version, or
/// contains no epoch.
[[nodiscard]] Result<RinexObservations> read_rinex_observations(const std::string& path,
                                                                const RinexOptions& options = {});
/// The same for text in memory; `source` names it in messages.
[[nodiscard]] Result<RinexObservations> parse_rinex_observations(std::string_view text,
                                                                 const std::string& source,
                                                                 const RinexOptions& options = {});

/// The content of a navigation file.
struct RinexNavigation {
  double version = 0.0;            ///< of the format
  Ephemerides ephemerides;         ///< all messages accepted
  Problems problems;               ///< parts skipped
  std::size_t lines = 0;           ///< of the file
  std::size_t messages = 0;        ///< accepted
  std::size_t other_messages = 0;  ///< of unsupported systems
};

/// Errors: the file cannot be read, or is not a RINEX navigation file of a supported version.
[[nodiscard]] Result<RinexNavigation> read_rinex_navigation(const std::string& path,
                                                            const RinexOptions& options = {});
/// The same for text in memory; `source` names it in messages.
[[nodiscard]] Result<RinexNavigation> parse_rinex_navigation(std::string_view text,
                                                             const std::string& source,
                                                             const RinexOptions& options = {});

}  // namespace wayfare::io
