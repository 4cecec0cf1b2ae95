#include <wayfare/io/columns.hpp>

#include <bit>
#include <cstdint>
#include <cstring>

#include "io/text/lines.hpp"

namespace wayfare::io {
namespace {

constexpr std::string_view kMagic = "F32 ";
constexpr std::size_t kHeader = 16;
static_assert(std::endian::native == std::endian::little, "the table's numbers are little endian");

template <class T>
T number_at(std::string_view bytes, std::size_t offset) {
  T value{};
  std::memcpy(&value, bytes.data() + offset, sizeof value);
  return value;
}

}  // namespace

Result<FloatTable> parse_float_table(std::string_view bytes, const std::string& source) {
  const auto error = [&](const char* message, std::size_t byte) {
    return Error{ErrorCode::parse, message, source, 0, byte};
  };
  if (bytes.substr(0, kMagic.size()) != kMagic) return error("does not begin with 'F32 '", 0);
  if (bytes.size() < kHeader) return error("ends within its header", bytes.size());
  const auto columns = number_at<std::int32_t>(bytes, 4);
  const auto rows = number_at<std::int64_t>(bytes, 8);
  if (columns < 1 || columns > 65536) return error("the number of columns is not in 1 to 65536", 4);
  if (rows < 0) return error("has a negative number of rows", 8);
  FloatTable table;
  table.columns = static_cast<std::size_t>(columns);
  const std::string_view body = bytes.substr(kHeader);
  const std::size_t available = body.size() / (sizeof(float) * table.columns);
  const auto wanted = static_cast<std::size_t>(rows);
  if (available > wanted ||
      (available == wanted && body.size() % (sizeof(float) * table.columns) != 0))
    return error("has bytes after its last row", kHeader + wanted * table.columns * sizeof(float));
  if (available == 0) return error("contains no rows", kHeader);
  if (available < wanted) table.problems.add(error("ends before its last row", bytes.size()));
  table.values.resize(available * table.columns);
  std::memcpy(table.values.data(), body.data(), table.values.size() * sizeof(float));
  return table;
}

Result<FloatTable> read_float_table(const std::string& path, const ReadOptions& options) {
  return read_and_parse(path, options, parse_float_table);
}

std::string format_float_table(std::span<const float> values, std::size_t columns) {
  WAYFARE_EXPECTS(columns > 0 && values.size() % columns == 0, "the rows must be of equal length");
  std::string out(kMagic);
  const auto append = [&](auto value) {
    char raw[sizeof value];
    std::memcpy(raw, &value, sizeof value);
    out.append(raw, sizeof raw);
  };
  append(static_cast<std::int32_t>(columns));
  append(static_cast<std::int64_t>(values.size() / columns));
  for (const float value : values) append(value);
  return out;
}

}  // namespace wayfare::io
