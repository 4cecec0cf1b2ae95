#include <wayfare/io/map_image.hpp>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <map>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "io/text/file_parts.hpp"
#include "io/text/text.hpp"

namespace wayfare::io {
namespace {

constexpr std::uint8_t kOccupied = 0, kFree = 254, kUnknown = 205;

/// The pixels of a row for programs.
void to_trinary(std::span<const float> occupancy, const MapImageOptions& options,
                std::string& pixels) {
  pixels.clear();
  for (const float cell : occupancy) {
    const auto p = static_cast<double>(cell);
    std::uint8_t value = kUnknown;
    if (p >= options.occupied_threshold) value = kOccupied;
    if (p <= options.free_threshold) value = kFree;
    pixels += static_cast<char>(value);
  }
}

/// Header and rows.
Result<void> make_pgm(const GridRows& grid, const MapImageOptions& options,
                      const AppendPart& append) {
  if (grid.width() == 0 || grid.height() == 0)
    return Error{ErrorCode::invalid, "the number of cells does not match the map's size"};
  append("P5\n" + std::to_string(grid.width()) + " " + std::to_string(grid.height()) + "\n255\n");
  std::vector<float> occupancy(grid.width());
  std::string pixels;
  for (std::size_t row = grid.height(); row-- > 0;) {
    grid.read(row, occupancy);
    to_trinary(occupancy, options, pixels);
    if (!append(pixels)) break;
  }
  return {};
}

}  // namespace

Result<std::string> format_pgm(const GridRows& grid, const MapImageOptions& options) {
  std::string out;
  const auto made = make_pgm(grid, options, [&](std::string_view part) {
    out += part;
    return true;
  });
  if (!made) return made.error();
  return out;
}

std::string format_map_yaml(const GridRows& grid, const std::string& image_name,
                            const MapImageOptions& options) {
  // A name in single quotes may contain any character; a quote in it is doubled.
  std::string name;
  for (const char c : image_name) name.append(c == '\'' ? 2 : 1, c);
  std::string out = "image: '" + name + "'";
  const auto add = [&](const char* key, double value) { text::append_number(out += key, value); };
  add("\nresolution: ", grid.resolution_m());
  add("\norigin: [", grid.origin().x());
  add(", ", grid.origin().y());
  add(", ", grid.origin().heading().radians());
  add("]\nnegate: 0\noccupied_thresh: ", options.occupied_threshold);
  add("\nfree_thresh: ", options.free_threshold);
  return out += '\n';
}

Result<void> write_map(const std::string& stem, const GridRows& grid,
                       const MapImageOptions& options) {
  Result<void> made;
  Result<void> done = write_file_parts(
      stem + ".pgm", [&](const AppendPart& append) { made = make_pgm(grid, options, append); },
      options.file);
  if (!made) return made;
  if (!done) return done;
  const std::string name = std::filesystem::path(stem + ".pgm").filename().string();
  return write_file(stem + ".yaml", format_map_yaml(grid, name, options), options.file);
}

namespace {

/// The header's next word; comments run from '#' to the end of the line.
std::string_view pgm_word(std::string_view& rest) {
  while (!rest.empty()) {
    if (rest.front() == '#') {
      rest.remove_prefix(std::min(rest.find('\n'), rest.size()));
    } else if (std::isspace(static_cast<unsigned char>(rest.front())) != 0) {
      rest.remove_prefix(1);
    } else {
      break;
    }
  }
  std::size_t end = 0;
  while (end < rest.size() && std::isspace(static_cast<unsigned char>(rest[end])) == 0) ++end;
  const std::string_view word = rest.substr(0, end);
  rest.remove_prefix(end);
  return word;
}

}  // namespace

Result<Image> parse_pgm(std::string_view bytes, const std::string& source) {
  std::string_view rest = bytes;
  const auto fault = [&](std::string message) {
    return Error{ErrorCode::parse, std::move(message), source, 0, bytes.size() - rest.size()};
  };
  const std::string_view magic = pgm_word(rest);
  if (magic != "P5" && magic != "P2")
    return fault("not a PGM picture: begins with '" + text::printable(magic, 8) + "'" +
                 (bytes.starts_with("\x89PNG") ? "; convert the PNG to PGM" : ""));
  std::array<std::size_t, 3> header{};  // width, height, largest value
  for (std::size_t& value : header) {
    const std::string_view word = pgm_word(rest);
    if (!text::to_number(word, value) || value == 0 || value > (std::size_t{1} << 20))
      return fault("PGM header: not a size: '" + text::printable(word) + "'");
  }
  const auto [width, height, largest] = header;
  if (largest > 255) return fault("PGM pictures of more than 8 bits are not supported");
  const std::uint64_t pixels = std::uint64_t{width} * height;
  const std::uint64_t pixel_bytes = magic == "P5" ? pixels + 1 : 2 * pixels;
  if (rest.size() + 1 < pixel_bytes) {
    return fault("the picture is cut off: " + std::to_string(width) + " x " +
                 std::to_string(height) + " pixels announced, " + std::to_string(rest.size()) +
                 " bytes left");
  }
  Image image{width, height, 1, {}};
  const auto count = static_cast<std::size_t>(pixels);
  image.pixels.resize(count);
  if (magic == "P5") {
    rest.remove_prefix(1);  // one blank ends the header
    if (rest.size() < count) return fault("the picture is cut off");
  }
  for (std::size_t i = 0; i < count; ++i) {
    std::size_t value = 0;
    if (magic == "P5") {
      value = static_cast<unsigned char>(rest[i]);
    } else if (const std::string_view word = pgm_word(rest); !text::to_number(word, value)) {
      return fault("pixel " + std::to_string(i) + ": not a number: '" + text::printable(word) +
                   "'");
    }
    image.pixels[i] = static_cast<std::uint8_t>(std::min(value, largest) * 255 / largest);
  }
  return image;
}

namespace {

/// A scalar without its quotes and without a comment after it.
std::string unquoted(std::string_view value) {
  value = text::trimmed(value);
  if (!value.empty() && (value.front() == '\'' || value.front() == '"')) {
    const char quote = value.front();
    std::string result;
    for (std::size_t i = 1; i < value.size(); ++i) {
      const bool doubled = quote == '\'' && value.substr(i, 2) == "''";
      if (value[i] == quote && !doubled) break;
      result += value[i];
      if (doubled) ++i;
    }
    return result;
  }
  return std::string(text::trimmed(value.substr(0, value.find(" #"))));
}

struct Entry {
  std::string value;
  std::size_t line = 0;
};

std::optional<std::array<double, 3>> three_numbers(std::string_view list) {
  if (list.size() < 2 || list.front() != '[' || list.back() != ']') return std::nullopt;
  list = list.substr(1, list.size() - 2);
  std::array<double, 3> v{};
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t comma = list.find(',');
    if ((comma == list.npos) != (i == 2)) return std::nullopt;
    if (!text::to_number(text::trimmed(list.substr(0, comma)), v[i]) || !std::isfinite(v[i]))
      return std::nullopt;
    if (comma != list.npos) list.remove_prefix(comma + 1);
  }
  return v;
}

}  // namespace

Result<MapYaml> parse_map_yaml(std::string_view all, const std::string& source) {
  constexpr const char* kExpected = "expected the .yaml file of a map ('image: map.pgm', ...)";
  if (all.starts_with("P5") || all.starts_with("P2") || all.starts_with("\x89PNG"))
    return Error{ErrorCode::parse, std::string("is a picture; ") + kExpected, source};
  std::map<std::string, Entry, std::less<>> entries;
  text::Lines lines(all);
  for (std::string_view line; lines.next(line);) {
    line = text::trimmed(line);
    if (line.empty() || line.front() == '#' || line == "---") continue;
    const std::size_t colon = line.find(':');
    if (colon == line.npos)
      return Error{ErrorCode::parse, std::string("not 'key: value'; ") + kExpected, source,
                   lines.number()};
    entries[std::string(text::trimmed(line.substr(0, colon)))] = {unquoted(line.substr(colon + 1)),
                                                                  lines.number()};
  }
  MapYaml yaml;
  const auto fault = [&](const char* key, const char* wanted) {
    const auto found = entries.find(key);
    const std::string what = std::string("'") + key + "' ";
    if (found == entries.end() || found->second.line == 0)
      return Error{ErrorCode::parse, what + "is missing", source};
    return Error{ErrorCode::parse, what + "must be " + wanted, source, found->second.line};
  };
  const auto number = [&](const char* key, double& value) {
    const auto found = entries.find(key);
    return found != entries.end() && text::to_number(found->second.value, value) &&
           std::isfinite(value);
  };
  yaml.image = entries["image"].value;
  if (yaml.image.empty()) return fault("image", "a file name");
  if (!number("resolution", yaml.resolution_m) || yaml.resolution_m <= 0.0)
    return fault("resolution", "a positive number");
  const std::optional<std::array<double, 3>> origin = three_numbers(entries["origin"].value);
  if (!origin) return fault("origin", "[x, y, heading]");
  yaml.origin = SE2d((*origin)[0], (*origin)[1], Angle::radians((*origin)[2]));
  for (const auto& [key, value] : {std::pair("occupied_thresh", &yaml.occupied_threshold),
                                   std::pair("free_thresh", &yaml.free_threshold)}) {
    if (entries.contains(key) && !number(key, *value)) return fault(key, "a number");
  }
  const std::string negate = entries["negate"].value;
  yaml.negate = negate == "1" || negate == "true";
  const std::string mode = entries["mode"].value;
  yaml.scale = mode == "scale";
  if (!mode.empty() && mode != "trinary" && mode != "scale")
    return fault("mode", "trinary or scale");
  return yaml;
}

Result<GridImage> read_map(const std::string& yaml_path, const ReadOptions& options) {
  const Result<FileContent> text = read_file(yaml_path, options);
  if (!text) return text.error();
  const Result<MapYaml> yaml = parse_map_yaml(text->bytes, yaml_path);
  if (!yaml) return yaml.error();
  const std::filesystem::path image_path =
      std::filesystem::path(yaml_path).parent_path() / yaml->image;
  const Result<FileContent> bytes = read_file(image_path.string(), options);
  if (!bytes) return bytes.error();
  const Result<Image> image = parse_pgm(bytes->bytes, image_path.string());
  if (!image) return image.error();
  GridImage grid{image->width, image->height, yaml->resolution_m, yaml->origin, {}};
  grid.occupancy.reserve(image->pixels.size());
  for (std::size_t row = grid.height; row-- > 0;) {
    for (std::size_t column = 0; column < grid.width; ++column) {
      const double grey = image->pixels[row * grid.width + column];
      const double p = (yaml->negate ? grey : 255.0 - grey) / 255.0;
      float cell = yaml->scale ? static_cast<float>(p) : std::numeric_limits<float>::quiet_NaN();
      if (p > yaml->occupied_threshold) cell = 1.0F;
      if (p < yaml->free_threshold) cell = 0.0F;
      grid.occupancy.push_back(cell);
    }
  }
  return grid;
}

}  // namespace wayfare::io
