#include "io/carmen/carmen_order.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>

#include <wayfare/io/time_text.hpp>

namespace wayfare::io::carmen {
namespace {

std::int64_t time_of(const ScanLine& line) { return line.scan.time.nanoseconds(); }
std::int64_t time_of(const OdometryLine& line) { return line.time.nanoseconds(); }
template <class T>
std::int64_t time_of(const Measured<T>& line) {
  return line.value.time.nanoseconds();
}

/// The elements of `times` to keep: a longest non-decreasing subsequence (patience sorting), so
/// that one wrong stamp costs one line and not all after it.
std::vector<bool> largest_ordered_set(const std::vector<std::int64_t>& times) {
  constexpr auto kNone = static_cast<std::size_t>(-1);
  std::vector<std::size_t> tails, previous(times.size(), kNone);
  for (std::size_t i = 0; i < times.size(); ++i) {
    const auto pile =
        std::upper_bound(tails.begin(), tails.end(), times[i],
                         [&](std::int64_t t, std::size_t tail) { return t < times[tail]; });
    if (pile != tails.begin()) previous[i] = *(pile - 1);
    if (pile == tails.end()) {
      tails.push_back(i);
    } else {
      *pile = i;
    }
  }
  std::vector<bool> keep(times.size(), false);
  for (std::size_t i = tails.empty() ? kNone : tails.back(); i != kNone; i = previous[i])
    keep[i] = true;
  return keep;
}

template <class Line>
Error out_of_order(const Line& line, const std::vector<Line>& before, const char* what) {
  std::string message = std::string(what) + " is out of order: time stamp " +
                        format_nanoseconds(time_of(line)) + " s";
  if (!before.empty()) message += " after " + format_nanoseconds(time_of(before.back())) + " s";
  return Error{ErrorCode::invalid, std::move(message)};
}

/// Drops every line that `repeats` the previous one kept.
template <class Line, class Repeats>
void drop_repetitions(std::vector<Line>& lines, const char* what, const Repeats& repeats,
                      Faults& faults) {
  std::vector<Line> kept;
  kept.reserve(lines.size());
  for (Line& line : lines) {
    if (kept.empty() || !repeats(line, kept.back())) {
      kept.push_back(std::move(line));
      continue;
    }
    const std::string first = std::to_string(kept.back().line);
    faults.skip(Error{ErrorCode::invalid, "repeats the " + std::string(what) + " of line " + first},
                line.line);
  }
  lines = std::move(kept);
}

bool same_scan(const LaserScan& a, const LaserScan& b) {
  const auto same = [](float x, float y) { return x == y || (std::isnan(x) && std::isnan(y)); };
  return a.time == b.time && std::equal(a.ranges_m.begin(), a.ranges_m.end(), b.ranges_m.begin(),
                                        b.ranges_m.end(), same);
}

}  // namespace

template <class Line>
void order(std::vector<Line>& lines, const char* what, Faults& faults) {
  std::vector<std::int64_t> times;
  times.reserve(lines.size());
  for (const Line& line : lines) times.push_back(time_of(line));
  const std::vector<bool> keep = largest_ordered_set(times);
  std::vector<Line> kept;
  kept.reserve(lines.size());
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (keep[i]) {
      kept.push_back(std::move(lines[i]));
    } else {
      faults.skip(out_of_order(lines[i], kept, what), lines[i].line);
    }
  }
  lines = std::move(kept);
}

template <class T>
void order_once(std::vector<Measured<T>>& lines, const char* what, Faults& faults) {
  order(lines, what, faults);
  const auto at_the_same_time = [](const auto& a, const auto& b) {
    return time_of(a) == time_of(b);
  };
  drop_repetitions(lines, what, at_the_same_time, faults);
}

template void order(std::vector<ScanLine>&, const char*, Faults&);
template void order(std::vector<OdometryLine>&, const char*, Faults&);
template void order_once(std::vector<Measured<RadarScan>>&, const char*, Faults&);
template void order_once(std::vector<Measured<WheelSample>>&, const char*, Faults&);
template void order_once(std::vector<Measured<GyroSample>>&, const char*, Faults&);
template void order_once(std::vector<Measured<StampedPose>>&, const char*, Faults&);

void drop_repeated(std::vector<ScanLine>& scans, Faults& faults) {
  const auto same = [](const ScanLine& a, const ScanLine& b) { return same_scan(a.scan, b.scan); };
  drop_repetitions(scans, "scan", same, faults);
}

}  // namespace wayfare::io::carmen
