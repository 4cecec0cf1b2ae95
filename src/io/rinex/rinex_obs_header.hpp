#pragma once

// Private: the header of a RINEX observation file: its properties, and the indices of each signal
// in a satellite's list of values.

#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include <wayfare/gnss/ephemerides.hpp>
#include <wayfare/io/rinex.hpp>

#include "io/rinex/rinex_text.hpp"

namespace wayfare::io::rinex {

/// Indices of a signal's parts in a satellite's list of values; −1: not in the list.
struct SignalPlaces {
  int code = -1, doppler = -1, phase = -1, strength = -1;
  char band = '1';
};

/// Stores properties and problems in the file passed to the constructor.
class ObservationHeader {
 public:
  ObservationHeader(const FirstLine& first, const std::string& source, const RinexOptions& options,
                    RinexObservations& file);

  /// Parses one line, of the header or after an event; finish() applies the lists of types.
  void take(std::string_view line, std::size_t number);
  void finish();

  [[nodiscard]] bool version_2() const { return version_2_; }
  /// The system of satellites whose names lack one.
  [[nodiscard]] char default_letter() const { return default_letter_; }
  [[nodiscard]] TimeScale time_scale() const { return scale_; }
  /// Number of values per satellite in version 2.
  [[nodiscard]] std::size_t values_of_version_2() const { return types_of_all_.size(); }
  /// Of the requested signals, in their order.
  [[nodiscard]] const std::vector<SignalPlaces>& places(GnssSystem system) const {
    return places_[static_cast<std::size_t>(index_of(system))];
  }

 private:
  /// The RINEX 3 names of each value of a satellite.
  using Types = std::vector<std::vector<std::string>>;
  static constexpr std::size_t kMaxTypes = 999;

  void types_of_system(std::string_view line, std::size_t number);
  void types_of_all(std::string_view line, std::size_t number);
  void time_system(std::string_view name, std::size_t number);
  void glonass_channels(std::string_view line);
  void report(std::size_t line, std::string message);
  [[nodiscard]] std::vector<SignalPlaces> places_among(GnssSystem system, const Types& types) const;

  const std::string& source_;
  const RinexOptions& options_;
  RinexObservations& file_;
  bool version_2_;
  char default_letter_;
  TimeScale scale_ = TimeScale::gps;
  char types_letter_ = ' ';
  std::array<Types, 256> types_;  ///< by system letter
  Types types_of_all_;            ///< version 2
  std::array<std::vector<SignalPlaces>, kGnssSystems> places_;
};

}  // namespace wayfare::io::rinex
