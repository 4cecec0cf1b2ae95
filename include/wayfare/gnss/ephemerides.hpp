#pragma once

// All broadcast messages of a recording: which one holds for a satellite at an instant.

#include <array>
#include <cstddef>
#include <map>
#include <optional>
#include <variant>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/gnss/atmosphere.hpp>
#include <wayfare/gnss/ephemeris.hpp>

namespace wayfare {

/// How far from its reference time a message may be used; beyond it the orbit's error grows from
/// metres to kilometres. By system: GPS, GLONASS, Galileo, BeiDou.
struct EphemerisLimits {
  std::array<Duration, kGnssSystems> age = {std::chrono::seconds(7201), std::chrono::seconds(1801),
                                            std::chrono::seconds(14401),
                                            std::chrono::seconds(21601)};
};

using Ephemeris = std::variant<KeplerianEphemeris, GlonassEphemeris>;

/// The reference time of the orbit.
[[nodiscard]] Time<GpsClock> reference_time(const Ephemeris& ephemeris);
[[nodiscard]] SatelliteId satellite_of(const Ephemeris& ephemeris);
[[nodiscard]] SatelliteState satellite_state(const Ephemeris& ephemeris, Time<GpsClock> time);
[[nodiscard]] std::optional<double> group_delay_s(const Ephemeris& ephemeris, double carrier_hz);
[[nodiscard]] bool is_healthy(const Ephemeris& ephemeris, double carrier_hz);

class Ephemerides {
 public:
  /// Refused: values that are not finite or cannot be the orbit of a navigation satellite. A
  /// message with the same satellite, time and source as one that is there replaces it.
  Result<void> add(const Ephemeris& ephemeris);
  /// Adds all of `other`; its ionosphere and leap seconds fill in what is missing here.
  void add(const Ephemerides& other);

  /// The message whose reference time is nearest to `time`, however far; null where there is none.
  /// Of a Galileo satellite's two messages the I/NAV one, made for E1, comes first.
  [[nodiscard]] const Ephemeris* nearest(SatelliteId satellite, Time<GpsClock> time) const;

  [[nodiscard]] bool empty() const { return messages_.empty(); }
  /// Messages in all.
  [[nodiscard]] std::size_t size() const;
  [[nodiscard]] std::vector<SatelliteId> satellites() const;
  /// A satellite's messages in order of reference time.
  [[nodiscard]] const std::vector<Ephemeris>& of(SatelliteId satellite) const;

  std::optional<KlobucharModel> gps_ionosphere;
  std::optional<KlobucharModel> beidou_ionosphere;
  /// GPS − UTC, where a message said so.
  std::optional<int> leap_seconds;

 private:
  std::map<SatelliteId, std::vector<Ephemeris>> messages_;
};

}  // namespace wayfare
