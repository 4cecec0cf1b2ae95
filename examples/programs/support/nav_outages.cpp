#include "nav_outages.hpp"

#include <algorithm>
#include <charconv>
#include <optional>
#include <string_view>

#include <wayfare/gnss/single_point.hpp>

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
      return Error{ErrorCode::parse,
                   "not an outage START:LENGTH[:SATELLITES]: '" + std::string(one) + "'"};
    outages.push_back(outage);
  }
  return outages;
}

void apply_outages(const std::vector<NavOutage>& outages, GnssInsRecording& recording) {
  for (const NavOutage& o : outages) {
    const LogTime begin = recording.imu.front().time + from_seconds(o.start_s);
    const OutageWindow window{begin, begin + from_seconds(o.length_s), o.satellites_left};
    // The highest satellites are kept: that depends on the receiver's position.
    std::optional<Geodetic> receiver;
    for (const RangeEpoch& epoch : recording.ranges) {
      if (receiver && epoch.time > begin) break;
      if (const auto point = single_point(epoch)) receiver = point->position;
    }
    recording.ranges = mask_satellites(recording.ranges, window, receiver.value_or(Geodetic{}));
    std::erase_if(recording.fixes, [&](const GnssFix& f) { return window.contains(f.time); });
  }
}

std::vector<LogTime> outage_starts(LogTime first, LogTime end, Duration length, std::size_t count,
                                   const std::vector<RangeEpoch>& epochs) {
  std::vector<LogTime> starts = wayfare::outage_starts(first, end, length, count);
  for (LogTime& start : starts) {
    LogTime epoch = start;
    for (const RangeEpoch& e : epochs)
      if (e.time <= start) epoch = e.time;
    start = epoch;
  }
  return starts;
}

}  // namespace wayfare::examples
