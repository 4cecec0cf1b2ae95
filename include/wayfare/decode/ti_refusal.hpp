#pragma once

// Why the bytes behind a magic word are no frame of a TI mmWave sensor.

#include <cstdint>
#include <string>

#include <wayfare/decode/ti_header.hpp>

namespace wayfare::decode {

/// What is inconsistent.
enum class TiFault : std::uint8_t {
  none,    ///< nothing was refused
  header,  ///< lengths and counts of no known header
  length,  ///< the items do not end where the frame does
  item,    ///< an item has a length that its type does not have
  points,  ///< the header counts other points than there are
};

/// A magic word that no frame begins with.
struct TiRefusal {
  std::uint64_t position = 0;     ///< of the magic word in the stream
  TiHeader header;                ///< as recognised
  TiFault fault = TiFault::none;  ///< what is inconsistent
  std::uint32_t item = 0;         ///< type of the last item read, 0 for none
};

/// In words: which header was recognised, and what is inconsistent; empty for no fault.
[[nodiscard]] std::string to_string(const TiRefusal& refusal);

}  // namespace wayfare::decode
