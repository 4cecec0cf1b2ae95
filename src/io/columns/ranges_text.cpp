// Corrected ranges, a line for each satellite of an epoch.

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include <wayfare/gnss/ephemerides.hpp>
#include <wayfare/io/nav_text.hpp>

#include "io/columns/column_rows.hpp"

namespace wayfare::io {
namespace {

constexpr Quantity kRanges[] = {
    {"sat", Dimension::text},         {"x", Dimension::length},
    {"y", Dimension::length},         {"z", Dimension::length},
    {"vx", Dimension::speed},         {"vy", Dimension::speed},
    {"vz", Dimension::speed},         {"range", Dimension::length},
    {"rate", Dimension::speed},       {"range_sigma", Dimension::length},
    {"rate_sigma", Dimension::speed}, {"cn0", Dimension::decibel_hertz},
    {"phase", Dimension::length},     {"phase_sigma", Dimension::length},
    {"interrupted", Dimension::none}};

std::optional<SatelliteId> satellite(std::string_view token) {
  if (token.size() < 2) return std::nullopt;
  const std::optional<GnssSystem> system = system_of(token.front());
  int number = 0;
  if (!system || !text::to_number(token.substr(1), number)) return std::nullopt;
  if (number < 1 || number > 255) return std::nullopt;
  return SatelliteId{*system, static_cast<std::uint8_t>(number)};
}

std::string take_range(const ColumnRow& row, const ColumnRows& rows, CorrectedRange& range) {
  const std::optional<SatelliteId> id = satellite(row.texts[0]);
  if (!id) return "not a satellite, such as G05: '" + text::printable(row.texts[0]) + "'";
  range.satellite = *id;
  range.position_ecef_m = triple(row.numbers, 1);
  range.velocity_ecef_mps = triple(row.numbers, 4);
  range.range_m = row.numbers[7];
  range.range_rate_mps = row.numbers[8];
  if (rows.has(9)) range.range_sigma_m = row.numbers[9];
  if (rows.has(10)) range.range_rate_sigma_mps = row.numbers[10];
  range.cn0_dbhz = row.numbers[11];
  range.phase_m = row.numbers[12];
  if (rows.has(13)) range.phase_sigma_m = row.numbers[13];
  range.phase_interrupted = rows.has(14) && row.numbers[14] != 0.0;
  if (!range.position_ecef_m.allFinite() || !range.velocity_ecef_mps.allFinite())
    return "the satellite's position or velocity is not finite";
  if (std::isinf(range.range_m) || std::isinf(range.range_rate_mps) || std::isinf(range.phase_m))
    return "an infinite range";
  for (const double sigma : {range.range_sigma_m, range.range_rate_sigma_mps, range.phase_sigma_m})
    if (!(sigma > 0.0 && sigma * sigma > 0.0) || !std::isfinite(sigma * sigma))
      return "a standard deviation is not positive";
  return {};
}

}  // namespace

Result<RangesFile> parse_ranges(std::string_view all, const std::string& source,
                                const ColumnFormat& format) {
  const auto rows = ColumnRows::open(all, source, format, kRanges, 8);
  if (!rows) return rows.error();
  RangesFile file;
  file.columns = rows->uses();
  const auto take = [&](const ColumnRow& row) -> std::string {
    CorrectedRange range;
    if (std::string fault = take_range(row, *rows, range); !fault.empty()) return fault;
    if (file.epochs.empty() || file.epochs.back().time != row.time)
      file.epochs.push_back({row.time, {}});
    std::vector<CorrectedRange>& satellites = file.epochs.back().satellites;
    for (const CorrectedRange& other : satellites)
      if (other.satellite == range.satellite) return "the satellite is in this epoch already";
    satellites.push_back(range);
    return {};
  };
  if (rows->for_each(take, file.problems) == 0) return no_content("range", source, file.problems);
  return file;
}

Result<RangesFile> read_ranges(const std::string& path, const ColumnFormat& format) {
  return read_and_parse(path, {}, parse_ranges, format);
}

std::string format_ranges(std::span<const RangeEpoch> epochs) {
  std::string out =
      "t_s sat x_m y_m z_m vx_mps vy_mps vz_mps range_m rate_mps range_sigma_m rate_sigma_mps "
      "cn0_dbhz";
  const bool phases = std::any_of(epochs.begin(), epochs.end(), [](const RangeEpoch& epoch) {
    return std::any_of(epoch.satellites.begin(), epoch.satellites.end(),
                       [](const CorrectedRange& r) { return std::isfinite(r.phase_m); });
  });
  out += phases ? " phase_m phase_sigma_m interrupted\n" : "\n";
  for (const RangeEpoch& epoch : epochs) {
    for (const CorrectedRange& r : epoch.satellites) {
      append_time(out, epoch.time);
      out += ' ' + to_string(r.satellite);
      append_numbers(out, r.position_ecef_m);
      append_numbers(out, r.velocity_ecef_mps);
      append_numbers(out, std::array{r.range_m, r.range_rate_mps, r.range_sigma_m,
                                     r.range_rate_sigma_mps, r.cn0_dbhz});
      if (phases)
        append_numbers(out,
                       std::array{r.phase_m, r.phase_sigma_m, r.phase_interrupted ? 1.0 : 0.0});
      out += '\n';
    }
  }
  return out;
}

}  // namespace wayfare::io
