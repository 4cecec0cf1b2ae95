#include <array>
#include <charconv>

#include <wayfare/logger/logger.hpp>

namespace wayfare::logger {
namespace {

/// CRC-32 (polynomial 04C11DB7, reflected), bit by bit: status lines are short and infrequent.
std::uint32_t crc32(std::string_view bytes) {
  std::uint32_t sum = 0xFFFFFFFFU;
  for (const char c : bytes) {
    sum ^= static_cast<std::uint8_t>(c);
    for (int k = 0; k < 8; ++k) sum = sum >> 1 ^ ((sum & 1U) != 0 ? 0xEDB88320U : 0U);
  }
  return ~sum;
}

std::string hexadecimal(std::uint32_t value) {
  std::array<char, 8> digits;
  for (std::size_t i = 0; i < 8; ++i) digits[i] = "0123456789abcdef"[value >> (28 - 4 * i) & 0xFU];
  return {digits.data(), digits.size()};
}

}  // namespace

std::optional<Command> command_of(std::uint8_t byte) {
  switch (byte) {
    case 'B':
    case 'S':
    case 'T':
    case 'C':
      return static_cast<Command>(byte);
    default:
      return std::nullopt;
  }
}

std::string status_line(std::string_view json) {
  return std::string(json) + '*' + hexadecimal(crc32(json)) + '\n';
}

std::optional<std::string_view> status_of_line(std::string_view line) {
  while (!line.empty() && (line.back() == '\n' || line.back() == '\r')) line.remove_suffix(1);
  if (line.size() < 9 || line[line.size() - 9] != '*') return std::nullopt;
  const std::string_view json = line.substr(0, line.size() - 9);
  if (line.substr(line.size() - 8) != hexadecimal(crc32(json))) return std::nullopt;
  return json;
}

}  // namespace wayfare::logger
