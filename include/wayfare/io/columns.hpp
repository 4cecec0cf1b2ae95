#pragma once

// Text files of columns: the first line, or a description of the file, names each column and its
// unit. Used by all readers of navigation data.
//
// Binary tables: "F32 ", the number of columns as int32, of rows as int64, then the rows as
// float32, all little endian; NaN: not measured. Plain or gzip.

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/io/text_file.hpp>

namespace wayfare::io {

/// The columns of a file. Fields are separated by commas or semicolons where a line has them, else
/// by blanks; a separator at the end of a line is ignored.
///
/// A name is a quantity and its unit: `ax_g`, `gx_degps`, `lat_deg`, or `ax [m/s^2]`. Angles are in
/// rad or deg, turn rates in radps (rad/s) or degps (deg/s), specific force in mps2 (m/s^2), g or
/// mg, magnetic fields in uT, nT, mT, T or G, lengths in m, cm, mm or km, speeds in mps (m/s) or
/// kmh (km/h), times in s, ms, us or ns.
///
/// The time of a line is one of
/// - `t`: on the recording's own clock; for GNSS, seconds since 1980-01-06, GPS time
/// - `week`, `tow`: GPS week (not rolled over) and time of week
/// - `date`, `clock`: a calendar date 2025/07/08 and time of day 19:34:18.499 in GPS time
/// - `utc_date`, `utc_clock`: the same in UTC
/// - `utc`: Unix time: UTC from 1970
/// - `unixgps`: GPS time from 1970 without leap seconds, as in RTKLIB's files
struct ColumnFormat {
  /// Names in the order of the file; "-" skips a column. Empty: a line of the file names them,
  /// optionally after '#' or '%'.
  std::vector<std::string> columns;
  /// Leading lines that are neither names nor data.
  std::size_t skip_lines = 0;
  /// GPS time minus UTC, s: 18 since 2017-01-01. Used only for times in UTC.
  int leap_seconds = 18;
};

struct FloatTable {
  std::size_t columns = 0;
  std::vector<float> values;  ///< row by row
  /// Set where the file is truncated; its whole rows are read.
  Problems problems;

  [[nodiscard]] std::size_t rows() const { return columns == 0 ? 0 : values.size() / columns; }
  [[nodiscard]] std::span<const float> row(std::size_t r) const {
    return std::span(values).subspan(r * columns, columns);
  }
};

/// Errors: cannot be read, not such a table, excess bytes, no rows.
[[nodiscard]] Result<FloatTable> read_float_table(const std::string& path,
                                                  const ReadOptions& options = {});
[[nodiscard]] Result<FloatTable> parse_float_table(std::string_view bytes,
                                                   const std::string& source);
/// Not compressed; `columns` numbers per row.
[[nodiscard]] std::string format_float_table(std::span<const float> values, std::size_t columns);

}  // namespace wayfare::io
