#pragma once

// Raw observations of a receiver: RINEX, or its own stream (u-blox: RXM-RAWX, RXM-SFRBX), plain or
// gzip. Recognised by the content.

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/gnss/ephemerides.hpp>
#include <wayfare/io/text_file.hpp>
#include <wayfare/sensors/measurements.hpp>

namespace wayfare::io {

/// The content of a file.
struct RawObservations {
  std::vector<ObservationEpoch> epochs;  ///< in the order of the file
  Ephemerides ephemerides;  ///< of the stream's navigation messages: GPS alone; none of RINEX
  Problems problems;        ///< parts skipped
};

/// Of a stream the signals of one band are taken, as default_signals() does: GPS L1 C/A, GLONASS
/// L1, Galileo E1, BeiDou B1I; ranges and phases only where the receiver says that they are valid.
/// Errors: the file cannot be read, is of neither kind, or contains no epoch.
[[nodiscard]] Result<RawObservations> read_observations(const std::string& path);
/// The same for bytes in memory; `source` names them in messages.
[[nodiscard]] Result<RawObservations> parse_observations(std::string_view bytes,
                                                         const std::string& source);

}  // namespace wayfare::io
