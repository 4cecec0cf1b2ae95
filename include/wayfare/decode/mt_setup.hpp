#pragma once

// Settings of an Xsens device in its configuration state: what its measurements contain, and the
// profile of its filter (Xsens, MT Low Level Communication Protocol, MT0101P).

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include <wayfare/core/detail/bytes.hpp>
#include <wayfare/decode/xbus.hpp>

namespace wayfare::decode {

/// One quantity of the measurements.
struct MtOutput {
  static constexpr std::uint16_t kAsMeasured = 0xFFFF;  ///< rate of what has none, such as UTC

  std::uint16_t id = 0;    ///< of its packets, with precision and frame in its lowest bits
  std::uint16_t rate = 0;  ///< Hz, or kAsMeasured

  bool operator==(const MtOutput&) const = default;  ///< id and rate
};

/// A list in a message's data. Refers to its bytes.
template <class Entry, std::size_t kBytes, Entry (*kRead)(const std::uint8_t*)>
class MtList {
 public:
  /// Entries of kBytes each.
  explicit MtList(Bytes data) : data_(data) {}
  [[nodiscard]] std::size_t size() const { return data_.size() / kBytes; }  ///< number of entries
  /// Entry i < size().
  [[nodiscard]] Entry operator[](std::size_t i) const { return kRead(&data_[kBytes * i]); }

 private:
  Bytes data_;
};

namespace detail {

[[nodiscard]] inline MtOutput mt_output(const std::uint8_t* p) {
  return {load_be<std::uint16_t>(p), load_be<std::uint16_t>(p + 2)};
}

}  // namespace detail

using MtOutputs = MtList<MtOutput, 4, detail::mt_output>;  ///< what measurements contain

/// The data of an output configuration; nullopt where it has another length.
[[nodiscard]] inline std::optional<MtOutputs> mt_outputs(Bytes data) {
  return data.size() % 4 == 0 ? std::optional(MtOutputs(data)) : std::nullopt;
}

/// Writes the request for these outputs (at most 32) to `out`; returns its length, or 0 where it
/// does not fit. The device answers with the outputs and rates it has set.
[[nodiscard]] inline std::size_t write_mt_outputs(std::uint8_t bus,
                                                  std::span<const MtOutput> outputs,
                                                  std::span<std::uint8_t> out) {
  std::array<std::uint8_t, 4 * 32> data{};
  if (4 * outputs.size() > data.size()) return 0;
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    store_be(outputs[i].id, &data[4 * i]);
    store_be(outputs[i].rate, &data[4 * i + 2]);
  }
  return write_xbus(bus, XbusId::request_output_configuration,
                    Bytes(data).first(4 * outputs.size()), out);
}

/// A profile of the device's filter.
struct MtFilterProfile {
  std::uint8_t id = 0,          ///< by which it is selected
      version = 0;              ///< of the profile
  std::array<char, 20> text{};  ///< its name, filled with blanks

  /// The name without the blanks; empty where the message does not have it.
  [[nodiscard]] std::string_view name() const {
    const std::string_view all(text.data(), text.size());
    return all.substr(0, std::min(all.find(' '), all.find(char{0})));
  }
};

namespace detail {

[[nodiscard]] inline MtFilterProfile mt_profile(const std::uint8_t* p) {
  MtFilterProfile profile{p[0], p[1], {}};
  std::copy(p + 2, p + 22, profile.text.begin());
  return profile;
}

}  // namespace detail

using MtFilterProfiles = MtList<MtFilterProfile, 22, detail::mt_profile>;  ///< those of a device

/// The data of `XbusId::filter_profiles`; nullopt where it has another length.
[[nodiscard]] inline std::optional<MtFilterProfiles> mt_filter_profiles(Bytes data) {
  return data.size() % 22 == 0 ? std::optional(MtFilterProfiles(data)) : std::nullopt;
}

/// The data of `XbusId::filter_profile`: version and id, or on newer devices the name; nullopt for
/// none and for names of more than 20 characters.
[[nodiscard]] inline std::optional<MtFilterProfile> mt_filter_profile(Bytes data) {
  MtFilterProfile profile;
  if (data.size() == 2) {
    profile.version = data[0];
    profile.id = data[1];
    return profile;
  }
  if (data.empty() || data.size() > profile.text.size()) return std::nullopt;
  std::copy(data.begin(), data.end(), profile.text.begin());
  return profile;
}

/// Writes the request to select a profile by its id; returns its length, or 0 where it does not
/// fit.
[[nodiscard]] inline std::size_t write_mt_filter_profile(std::uint8_t bus, std::uint8_t id,
                                                         std::span<std::uint8_t> out) {
  const std::array<std::uint8_t, 2> data = {0, id};
  return write_xbus(bus, XbusId::request_filter_profile, data, out);
}

/// The same by name, such as "General" or, of two profiles, "General/RobustVRU" (MTi-600 series).
[[nodiscard]] inline std::size_t write_mt_filter_profile(std::uint8_t bus, std::string_view name,
                                                         std::span<std::uint8_t> out) {
  return write_xbus(bus, XbusId::request_filter_profile,
                    Bytes(reinterpret_cast<const std::uint8_t*>(name.data()), name.size()), out);
}

/// What the code in an error message means; empty for an unknown one.
[[nodiscard]] constexpr std::string_view mt_error_text(std::uint8_t code) {
  switch (code) {
    case 0x03:
      return "period out of range";
    case 0x04:
      return "message unknown or not allowed now";
    case 0x1E:
      return "timer overflow: rate or number of outputs too high";
    case 0x20:
      return "baud rate out of range";
    case 0x21:
      return "parameter out of range";
    case 0x28:
      return "fault of the device";
    case 0x29:
      return "more data than the line takes";
    case 0x2A:
      return "buffer overflow";
    default:
      return {};
  }
}

}  // namespace wayfare::decode
