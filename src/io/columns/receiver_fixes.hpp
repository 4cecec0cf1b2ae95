#pragma once

// Private: positions of files that are no columns: receivers' streams, GPX and KML.

#include <optional>
#include <string>
#include <string_view>

#include <wayfare/core/result.hpp>
#include <wayfare/io/nav_text.hpp>

namespace wayfare::io {

/// Whether the bytes begin with messages of u-blox receivers with right checksums, also between
/// other bytes.
[[nodiscard]] bool is_ubx(std::string_view bytes);
/// The same for NMEA sentences.
[[nodiscard]] bool is_nmea(std::string_view bytes);
/// XML of any kind.
[[nodiscard]] bool is_xml(std::string_view bytes);

/// Of NAV-PVT messages, or of NMEA sentences where there are none.
[[nodiscard]] Result<FixFile> parse_receiver_fixes(std::string_view bytes,
                                                   const std::string& source);
/// Track points of GPX, gx:Track of KML.
[[nodiscard]] Result<FixFile> parse_xml_fixes(std::string_view text, const std::string& source);

/// Nullopt where it is none of these.
[[nodiscard]] inline std::optional<Result<FixFile>> parse_foreign_fixes(std::string_view bytes,
                                                                        const std::string& source) {
  if (is_xml(bytes)) return parse_xml_fixes(bytes, source);
  if (is_ubx(bytes) || is_nmea(bytes)) return parse_receiver_fixes(bytes, source);
  return std::nullopt;
}

}  // namespace wayfare::io
