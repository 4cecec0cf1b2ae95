#include <wayfare/decode/ti_refusal.hpp>

#include <array>
#include <cstdio>

namespace wayfare::decode {
namespace {

const char* name_of(const TiHeader& header) {
  switch (header.layout) {
    case TiLayout::area_scanner:
      return "the area scanner's header of 44 bytes";
    case TiLayout::tracker_3d:
      return "the header of 48 bytes of 3D people counting";
    case TiLayout::tracker_2d:
      return "the header of 52 bytes of people counting in a plane";
    default:
      return header.bytes() == 36 ? "the demo's header of 36 bytes"
                                  : "the demo's header of 40 bytes";
  }
}

std::string fault_of(const TiRefusal& refusal) {
  const std::string item = std::to_string(refusal.item);
  switch (refusal.fault) {
    case TiFault::header:
      return "its lengths and counts are of no known header (36, 40, 44, or 48 and 52 bytes with a "
             "checksum)";
    case TiFault::length:
      return refusal.item == 0
                 ? std::string("it ends within the header")
                 : "its items do not end where the frame does; the last is of type " + item;
    case TiFault::item:
      return "the item of type " + item + " has an impossible length";
    default:
      return "it counts other points than there are";
  }
}

}  // namespace

std::string to_string(const TiRefusal& refusal) {
  if (refusal.fault == TiFault::none) return {};
  const TiHeader& h = refusal.header;
  std::array<char, 160> text{};
  std::snprintf(text.data(), text.size(),
                " (version %u.%u.%u.%u, platform %X, frame %u, %u bytes, %u items, %u points): ",
                h.version >> 24, h.version >> 16 & 0xFFU, h.version >> 8 & 0xFFU, h.version & 0xFFU,
                h.platform, h.frame_number, h.total_bytes, h.tlvs, h.points);
  const std::string read =
      refusal.fault == TiFault::header ? std::string("read as ") : std::string("recognised ");
  return "byte " + std::to_string(refusal.position) + ": " + read + name_of(h) + text.data() +
         fault_of(refusal);
}

}  // namespace wayfare::decode
