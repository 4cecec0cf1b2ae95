#pragma once

// The legacy navigation message of GPS (LNAV on L1 C/A) from its subframes (IS-GPS-200, 20.3.3):
// orbit and clock of subframes 1 to 3, ionosphere and leap seconds of page 18 of subframe 4.

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>

#include <wayfare/gnss/ephemerides.hpp>
#include <wayfare/gnss/gps_time.hpp>

namespace wayfare {

/// The 24 data bits of each of a subframe's ten words, parity removed and polarity restored.
using GpsSubframe = std::array<std::uint32_t, 10>;

/// Collects the subframes of many satellites.
class GpsSubframes {
 public:
  static constexpr std::size_t kWords = 10;  ///< of a subframe

  /// Takes a subframe received near `near`, which resolves the week number sent modulo 1024. The
  /// result is the orbit and clock as soon as subframes 1 to 3 of one issue are complete, each
  /// issue once. Nullopt also for a satellite number outside 1 to 32, and words that do not begin
  /// with the preamble or do not name a subframe.
  std::optional<KeplerianEphemeris> add(int satellite, const GpsSubframe& words,
                                        Time<GpsClock> near);

  /// The latest of page 18.
  [[nodiscard]] const std::optional<KlobucharModel>& ionosphere() const { return ionosphere_; }
  /// GPS − UTC, s, at the time of the latest page 18.
  [[nodiscard]] std::optional<int> leap_seconds() const { return leap_seconds_; }

 private:
  struct Parts {
    std::array<std::optional<GpsSubframe>, 3> frames;
    std::optional<int> delivered;  ///< issue
  };

  std::optional<KeplerianEphemeris> complete(int satellite, Parts& parts, Time<GpsClock> near);
  void take_page(const GpsSubframe& words);

  std::map<int, Parts> satellites_;
  std::optional<KlobucharModel> ionosphere_;
  std::optional<int> leap_seconds_;
};

}  // namespace wayfare
