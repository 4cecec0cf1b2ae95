#pragma once

// Recordings of nine-axis units as columns: text with a line that names them (columns.hpp), or a
// binary table (float_table.hpp) whose columns the caller names. Plain or gzip.

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/core/so3.hpp>
#include <wayfare/io/columns.hpp>
#include <wayfare/io/text_file.hpp>
#include <wayfare/sensors/marg.hpp>

namespace wayfare::io {

/// A true attitude beside a sample, in whatever world frame the recording has.
struct MargReference {
  SO3d q_world_body;
  bool known = false;  ///< false where its fields are empty or NaN
};

struct MargFile {
  MargRecording samples;  ///< in the order of the file; NaN where a sensor was silent
  std::vector<MargReference> reference;  ///< beside them, or empty where there are no such columns
  std::vector<bool> moving;              ///< beside them: column `moving`; all where there is none
  bool has_magnetometer = false;
  Problems problems;
};

struct MargFormat {
  /// The columns gx gy gz, ax ay az (both needed), mx my mz (uT, nT, mT, T or G), qw qx qy qz,
  /// moving (0 or 1), and the time.
  ColumnFormat columns;
  /// For a table without a time: the time from one row to the next, s. Zero where it has one.
  double period_s = 0.0;
};

/// Errors: the file cannot be read, a column is missing or has an unknown unit, or no line could be
/// used; for a binary table also names that do not fit it.
[[nodiscard]] Result<MargFile> read_marg(const std::string& path, const MargFormat& format = {});
[[nodiscard]] Result<MargFile> parse_marg(std::string_view bytes, const std::string& source,
                                          const MargFormat& format = {});

/// Text with a line that names the columns; without the magnetometer's where no sample has it.
[[nodiscard]] std::string format_marg(std::span<const MargSample> samples);
[[nodiscard]] Result<void> write_marg(const std::string& path, std::span<const MargSample> samples,
                                      const WriteOptions& options = {});

}  // namespace wayfare::io
