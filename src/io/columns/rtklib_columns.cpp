#include <array>
#include <utility>
#include <vector>

#include "io/columns/column_rows.hpp"
#include "io/columns/nav_columns.hpp"

namespace wayfare::io {
namespace {

// Headings of RTKLIB's solutions and the corresponding column names.
constexpr std::array<std::pair<std::string_view, std::string_view>, 19> kNames = {
    {{"latitude(deg)", "lat_deg"},
     {"longitude(deg)", "lon_deg"},
     {"height(m)", "h_m"},
     {"Q", "q"},
     {"sdn(m)", "sn_m"},
     {"sde(m)", "se_m"},
     {"sdu(m)", "sd_m"},
     {"sdne(m)", "sne_m"},
     {"sdeu(m)", "seu_m"},
     {"sdun(m)", "sun_m"},
     {"vn(m/s)", "vn_mps"},
     {"ve(m/s)", "ve_mps"},
     {"vu(m/s)", "vu_mps"},
     {"sdvn", "svn_mps"},
     {"sdve", "sve_mps"},
     {"sdvu", "svd_mps"},
     {"roll(deg)", "roll_deg"},
     {"pitch(deg)", "pitch_deg"},
     {"yaw(deg)", "yaw_deg"}}};

std::string our_name(std::string_view heading) {
  for (const auto& [theirs, ours] : kNames)
    if (theirs == heading) return std::string(ours);
  return "-";
}

}  // namespace

std::optional<ColumnFormat> rtklib_columns(std::string_view all, const ColumnFormat& format) {
  if (!format.columns.empty()) return std::nullopt;
  ColumnFormat found = format;
  text::Lines lines(all);
  bool utc = false;
  for (std::string_view line; lines.next(line);) {
    std::vector<std::string_view> fields;
    if (line.starts_with('%')) {
      split_fields(line.substr(1), fields);
      if (fields.size() < 4 || fields[1] != "latitude(deg)") continue;
      if (fields[0] != "GPST" && fields[0] != "UTC") continue;
      utc = fields[0] == "UTC";
      found.columns.clear();
      for (std::size_t i = 1; i < fields.size(); ++i) found.columns.push_back(our_name(fields[i]));
      continue;
    }
    if (found.columns.empty()) return std::nullopt;
    // The heading has one word for date and time, or week and time of week.
    split_fields(line, fields);
    if (fields.empty()) continue;
    const bool date = fields[0].find('/') != std::string_view::npos;
    const std::array<const char*, 2> time =
        date ? (utc ? std::array{"utc_date", "utc_clock"} : std::array{"date", "clock"})
             : std::array{"week", "tow_s"};
    found.columns.insert(found.columns.begin(), time.begin(), time.end());
    return found;
  }
  return std::nullopt;
}

}  // namespace wayfare::io
