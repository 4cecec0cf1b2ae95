#pragma once

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
