#pragma once

// Reading and writing whole files. Gzip is decompressed on reading; writing is atomic.
//
// The destination of a byte stream: a file, or a test double.
//
// Text files of columns: the first line, or a description of the file, names each column and its
// unit. Used by all readers of navigation data.
//
// Binary tables: "F32 ", the number of columns as int32, of rows as int64, then the rows as
// float32, all little endian; NaN: not measured. Plain or gzip.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/io/detail/descriptor.hpp>

namespace wayfare::io {

/// Seconds in decimal text, such as "976052857.137530" or "1.2e3", as whole nanoseconds, without a
/// floating-point intermediate; digits beyond the ninth decimal are rounded (half away from zero).
/// nullopt where it is not such a number or does not fit 64 bits.
[[nodiscard]] std::optional<std::int64_t> parse_nanoseconds(std::string_view seconds);

/// Nanoseconds as seconds with nine decimals, exact: "976052857.137530000".
[[nodiscard]] std::string format_nanoseconds(std::int64_t nanoseconds);

/// Limits of reading a file.
struct ReadOptions {
  /// Limit of the content, bytes after decompression; a larger file is an error.
  std::size_t max_bytes = std::size_t{1} << 30;
};

/// A file's bytes, decompressed if it was gzip.
struct FileContent {
  std::string bytes;      ///< decompressed
  bool was_gzip = false;  ///< the file was compressed
  /// Set where a gzip stream is truncated or damaged: `bytes` then contains the data before that.
  std::optional<Error> damage;
};

/// Reads all of `path`. Errors: cannot be opened or read, is a folder, is larger than allowed.
[[nodiscard]] Result<FileContent> read_file(const std::string& path,
                                            const ReadOptions& options = {});

/// The same for bytes in memory; `source` names them in messages.
[[nodiscard]] Result<FileContent> decompress(std::string_view bytes, const std::string& source,
                                             const ReadOptions& options = {});

/// What to do if the file to be written exists.
enum class Existing {
  refuse,   ///< an Error
  replace,  ///< the new file takes its place
};

/// What write_file may do.
struct WriteOptions {
  Existing existing = Existing::refuse;  ///< a file of that name
};

/// Writes `bytes` to a temporary file beside `path` and renames it there, so that `path` never
/// contains only part of them, even if the disk is full.
[[nodiscard]] Result<void> write_file(const std::string& path, std::string_view bytes,
                                      const WriteOptions& options = {});

/// The faults found while reading that were not fatal: their number, and the first ones in full.
class Problems {
 public:
  Problems() = default;
  /// Keeps the first `capacity` in full.
  explicit Problems(std::size_t capacity) : capacity_(capacity) {}

  /// Counts an error, and keeps it if there is room.
  void add(Error error) {
    ++count_;
    if (first_.size() < capacity_) first_.push_back(std::move(error));
  }

  /// Number of faults.
  [[nodiscard]] std::size_t count() const { return count_; }
  /// Whether there was none.
  [[nodiscard]] bool empty() const { return count_ == 0; }
  /// In the order of the file.
  [[nodiscard]] const std::vector<Error>& first() const& { return first_; }
  /// Of a temporary, so that a loop may run over them.
  [[nodiscard]] std::vector<Error> first() && { return std::move(first_); }
  /// What most of the faults kept in full are: the message up to its details, without numbers;
  /// empty if there is none.
  [[nodiscard]] std::string most_frequent() const;

 private:
  std::size_t capacity_ = 100;
  std::size_t count_ = 0;
  std::vector<Error> first_;
};

/// The destination of a byte stream.
class ByteSink {
 public:
  virtual ~ByteSink() = default;
  /// Appends all of `bytes`, or none of them on an error.
  [[nodiscard]] virtual Result<void> write(std::string_view bytes) = 0;
  /// When this returns, written data survives a power failure.
  [[nodiscard]] virtual Result<void> sync() = 0;
};

/// A file written from its start on. A failed write is undone, so that the file ends with the last
/// successful one.
class FileSink final : public ByteSink {
 public:
  /// Errors: the file exists (see WriteOptions), or cannot be written.
  [[nodiscard]] static Result<std::unique_ptr<ByteSink>> create(const std::string& path,
                                                                const WriteOptions& options = {});
  [[nodiscard]] Result<void> write(std::string_view bytes) override;
  [[nodiscard]] Result<void> sync() override;

 private:
  FileSink(Descriptor file, std::string path) : file_(std::move(file)), path_(std::move(path)) {}

  Descriptor file_;
  std::string path_;
  std::uint64_t size_ = 0;
};

/// A column of a foreign file: `gx_degps` is the column "Gyro X", or 5.
struct ColumnChoice {
  std::string name;    ///< quantity and unit, as in ColumnFormat
  std::string column;  ///< heading without quotes, or number from 1
};

/// The columns of a file. Fields are separated by commas or semicolons where a line has them, else
/// by blanks; a separator at the end of a line is ignored.
///
/// A name is a quantity and its unit: `ax_g`, `gx_degps`, `lat_deg`, or `ax [m/s^2]`. Angles are in
/// rad or deg, turn rates in radps (rad/s) or degps (deg/s), specific force in mps2 (m/s^2), g or
/// mg, magnetic fields in uT, nT, mT, T or G, pressures in Pa, hPa, mbar or kPa, lengths in m, cm,
/// mm or km, speeds in mps (m/s) or kmh (km/h), times in s, ms, us or ns.
///
/// The time of a line is one of
/// - `t`: on the recording's own clock; for GNSS, seconds since 1980-01-06, GPS time
/// - `week`, `tow`: GPS week (not rolled over) and time of week
/// - `date`, `clock`: a calendar date 2025/07/08 and time of day 19:34:18.499 in GPS time
/// - `utc_date`, `utc_clock`: the same in UTC
/// - `utc`: Unix time: UTC from 1970
/// - `unixgps`: GPS time from 1970 without leap seconds, as in RTKLIB's files
///
/// The columns of a foreign file are chosen by their headings or numbers: only those are read.
struct ColumnFormat {
  /// Names in the order of the file; "-" skips a column. Empty: a line of the file names them,
  /// optionally after '#' or '%'.
  std::vector<std::string> columns;
  /// Leading lines that are neither names nor data.
  std::size_t skip_lines = 0;
  /// GPS time minus UTC, s: 18 since 2017-01-01. Used only for times in UTC.
  int leap_seconds = 18;
  /// Columns taken by heading or number, in place of the names above.
  std::vector<ColumnChoice> choices = {};

  /// Whether the caller says what the columns are, so that the file's format is not guessed.
  [[nodiscard]] bool named() const { return !columns.empty() || !choices.empty(); }
};

/// A column as a reader understood it.
struct ColumnUse {
  std::size_t column = 0;  ///< number, from 1
  std::string heading;     ///< in the file; empty: it has none
  std::string name;        ///< quantity and unit
};

/// A table of float32 numbers.
struct FloatTable {
  std::size_t columns = 0;    ///< of every row
  std::vector<float> values;  ///< row by row
  /// Set where the file is truncated; its whole rows are read.
  Problems problems;

  /// Number of rows.
  [[nodiscard]] std::size_t rows() const { return columns == 0 ? 0 : values.size() / columns; }
  /// Row r < rows().
  [[nodiscard]] std::span<const float> row(std::size_t r) const {
    return std::span(values).subspan(r * columns, columns);
  }
};

/// Errors: cannot be read, not such a table, excess bytes, no rows.
[[nodiscard]] Result<FloatTable> read_float_table(const std::string& path,
                                                  const ReadOptions& options = {});
/// The same for bytes in memory; `source` names them in messages.
[[nodiscard]] Result<FloatTable> parse_float_table(std::string_view bytes,
                                                   const std::string& source);
/// Not compressed; `columns` numbers per row.
[[nodiscard]] std::string format_float_table(std::span<const float> values, std::size_t columns);

}  // namespace wayfare::io
