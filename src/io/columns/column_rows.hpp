#pragma once

// Private: rows of a text file of columns, converted to SI units.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/result.hpp>
#include <wayfare/core/time.hpp>
#include <wayfare/io/text_file.hpp>

#include "io/text/lines.hpp"

namespace wayfare::io {

enum class Dimension : std::uint8_t {
  none,
  text,
  time,
  length,
  speed,
  angle,
  angular_rate,
  acceleration,
  magnetic_field,
  pressure,
  decibel_hertz
};

inline constexpr std::int64_t kGpsEpochUnix_s = 315964800;  ///< 1980-01-06

/// A quantity that a reader uses.
struct Quantity {
  std::string_view stem;
  Dimension dimension = Dimension::none;
};

/// The requested values of one line, in the requested order; NaN (or no text) for a missing column,
/// an empty field or "nan".
struct ColumnRow {
  LogTime time;
  std::size_t line = 0;      ///< number, from 1
  std::size_t end_byte = 0;  ///< offset in the text after the line
  std::span<const double> numbers;
  std::span<const std::string_view> texts;
};

/// The columns of a text and the format of its lines.
class ColumnRows {
 public:
  /// Errors: no line names the columns, no time, a column named twice, an unknown unit, one of the
  /// first `required` quantities missing.
  static Result<ColumnRows> open(std::string_view text, const std::string& source,
                                 const ColumnFormat& format, std::span<const Quantity> wanted,
                                 std::size_t required = 0);

  /// Whether the file has a column for wanted[i].
  [[nodiscard]] bool has(std::size_t i) const { return slots_[i].column >= 0; }
  /// An error that names the missing ones among wanted[first] .. wanted[last - 1].
  [[nodiscard]] Result<void> require(std::size_t first, std::size_t last) const;

  /// The columns that are read, in the order of the file.
  [[nodiscard]] const std::vector<ColumnUse>& uses() const { return uses_; }

  /// Calls `take` for each readable line; it returns an error message, or an empty string. Returns
  /// the number of accepted lines.
  std::size_t for_each(const std::function<std::string(const ColumnRow&)>& take,
                       Problems& problems) const;

 private:
  struct Slot {
    int column = -1;
    double factor = 1.0;
    Quantity quantity;
  };
  enum class TimeKind : std::uint8_t { none, log, week_tow, calendar, unix_like };

  Result<void> name_columns(const ColumnFormat& format);
  Result<std::vector<std::string>> chosen_names(const ColumnFormat& format);
  Result<void> assign(const std::string& name, int column);
  Result<void> check_time() const;
  std::string read_time(std::span<const std::string_view> fields, LogTime& time) const;

  std::string_view text_;
  std::string source_;
  std::vector<Slot> slots_;
  std::vector<ColumnUse> uses_;
  std::vector<std::string> headings_;  ///< as in the file, where its columns are chosen
  std::size_t column_count_ = 0;
  std::size_t first_line_ = 0;  ///< lines up to this one are not data
  TimeKind time_kind_ = TimeKind::none;
  int time_column_ = -1;         ///< t, utc, tow, clock
  int time_second_column_ = -1;  ///< week, date
  int time_decimals_ = 0;        ///< 3 where the column is in milliseconds
  bool time_is_utc_ = false;
  int leap_seconds_ = 0;
};

/// Splits a line at commas and semicolons, or at blanks where it has neither. Fields are trimmed; a
/// separator at the end is ignored.
void split_fields(std::string_view line, std::vector<std::string_view>& fields);

/// Three numbers of a row, from `first` on.
inline Eigen::Vector3d triple(std::span<const double> numbers, std::size_t first) {
  return {numbers[first], numbers[first + 1], numbers[first + 2]};
}

using text::append_numbers;
inline void append_time(std::string& out, LogTime time) {
  out += format_nanoseconds(time.nanoseconds());
}

}  // namespace wayfare::io
