// Arguments of the navigation programs: outages and columns.

#include <algorithm>
#include <charconv>
#include <cstddef>
#include <map>
#include <string_view>

#include <wayfare/eval/table.hpp>

#include "command_line.hpp"
#include "nav_config.hpp"

namespace wayfare::examples {

Result<std::vector<NavOutage>> parse_outages(const std::string& text) {
  std::vector<NavOutage> outages;
  std::string_view rest = text;
  while (!rest.empty()) {
    const std::string_view one = rest.substr(0, rest.find(','));
    rest.remove_prefix(std::min(rest.size(), one.size() + 1));
    NavOutage outage;
    const char *at = one.data(), *const end = one.data() + one.size();
    const auto number = [&](auto& value) {
      const auto [stop, error] = std::from_chars(at, end, value);
      const bool good = error == std::errc() && stop != at;
      at = stop;
      return good;
    };
    const auto colon = [&] { return at != end && *at++ == ':'; };
    const bool good = number(outage.start_s) && colon() && number(outage.length_s) &&
                      (at == end || (colon() && number(outage.satellites_left))) && at == end &&
                      outage.start_s >= 0.0 && outage.start_s < 1e9 && outage.length_s > 0.0 &&
                      outage.length_s < 1e9;
    if (!good)
      return bad_use("not an outage START:LENGTH[:SATELLITES]: '" + std::string(one) + "'");
    outages.push_back(outage);
  }
  return outages;
}

Result<void> check_outages(const std::vector<NavOutage>& outages, double length_s) {
  const auto outside = std::ranges::find_if(
      outages, [&](const NavOutage& outage) { return outage.start_s >= length_s; });
  if (outside == outages.end()) return {};
  return bad_use("--outage begins at " + eval::fixed(outside->start_s, 1) +
                 " s, outside the recording, which takes " + eval::fixed(length_s, 1) + " s");
}

Result<void> choose_columns(const std::vector<std::string>& texts, NavConfig& config) {
  const std::map<std::string, io::NavFileFormat*> files = {{"imu_clock", &config.imu_clock},
                                                           {"ranges", &config.ranges},
                                                           {"fixes", &config.fixes},
                                                           {"wheels", &config.wheels},
                                                           {"truth", &config.truth}};
  for (const std::string& text : texts) {
    const std::size_t colon = text.find(':'), equal = text.find('=', colon);
    const std::string file = text.substr(0, colon);
    io::NavFileFormat* format = nullptr;
    if (file == "imu" || file == "imu2") {
      config.imu.resize(std::max<std::size_t>(config.imu.size(), file == "imu" ? 1 : 2));
      format = &config.imu[file == "imu" ? 0 : 1];
    } else if (const auto found = files.find(file); found != files.end()) {
      format = found->second;
    }
    if (colon == text.npos || equal == text.npos || equal == colon + 1 ||
        equal + 1 == text.size() || format == nullptr)
      return bad_use(
          "--column must be FILE:NAME=COLUMN with FILE imu, imu2, imu_clock, ranges, "
          "fixes, wheels or truth, not '" +
          text + "'");
    format->format.choices.push_back(
        {text.substr(colon + 1, equal - colon - 1), text.substr(equal + 1)});
  }
  return {};
}

}  // namespace wayfare::examples
