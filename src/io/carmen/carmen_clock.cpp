#include "io/carmen/carmen_clock.hpp"

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <optional>
#include <utility>

namespace wayfare::io::carmen {
namespace {

/// Of the scans of the front laser, in the order of the file.
struct Scans {
  std::vector<std::size_t> lines;
  std::vector<LogTime> times;         ///< stamps
  std::vector<LogTime> logger_times;  ///< of the lines that have one
  std::size_t equal = 0;              ///< different scans with the stamp of the one before

  /// Whether too many are equal, as with stamps of few digits.
  [[nodiscard]] bool are_coarse() const { return equal * 25 > lines.size(); }
};

constexpr Duration kLargestPeriod = std::chrono::seconds(10);

std::string seconds_text(Duration d) { return format_nanoseconds(d.count()) + " s"; }

template <class F>
void for_each_stream(LogLines& lines, const F& f) {
  for (auto* kinds : {&lines.front, &lines.rear})
    for (std::vector<ScanLine>& scans : *kinds) f(scans);
  f(lines.odometry);
  f(lines.radar);
  f(lines.wheels);
  f(lines.gyro);
  f(lines.truth);
}

/// Sets the time of each line to time(line number, stamp).
template <class Time>
void set_times(LogLines& lines, const Time& time) {
  for_each_stream(lines, [&](auto& stream) {
    for (auto& line : stream) time_of(line) = time(line);
  });
}

std::size_t count(const std::vector<bool>& set) {
  return static_cast<std::size_t>(std::count(set.begin(), set.end(), true));
}

/// Whether enough of the stamps are in order and different from each other. A log that writes each
/// scan twice, or one of stamps of whole seconds, has many equal ones.
bool is_usable(const std::vector<LogTime>& times) {
  constexpr std::size_t kFewest = 5;  // a few wrong lines of a short log are dropped
  const std::vector<bool> keep = largest_ordered_set(times);
  const std::size_t n = times.size(), dropped = n - count(keep);
  if (dropped * 100 > n && (dropped >= kFewest || dropped * 2 > n)) return false;
  std::size_t distinct = 0;
  std::optional<LogTime> last;
  for (std::size_t i = 0; i < n; ++i) {
    if (!keep[i] || (last && times[i] == *last)) continue;
    last = times[i];
    ++distinct;
  }
  return n < kFewest || (distinct > 1 && distinct * 10 > n);
}

/// Of the steps from one stamp to the next that are positive and not a gap.
std::optional<Duration> median_step(const std::vector<LogTime>& times) {
  std::vector<Duration> steps;
  for (std::size_t i = 1; i < times.size(); ++i) {
    const Duration step = times[i] - times[i - 1];
    if (step > Duration(0) && step <= kLargestPeriod) steps.push_back(step);
  }
  if (2 * steps.size() < times.size()) return std::nullopt;
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  return *middle;
}

// ---- a clock that was set back -------------------------------------------------------------

/// Scans first..last − 1 of one setting of the clock.
struct Piece {
  std::size_t first, last;
  Duration offset{0};
};

std::vector<Piece> pieces_of(const std::vector<LogTime>& times) {
  constexpr Duration kSetBack = std::chrono::seconds(1);
  std::vector<Piece> pieces = {{0, times.size()}};
  for (std::size_t i = 1; i < times.size(); ++i) {
    if (times[i] >= times[i - 1] - kSetBack) continue;
    pieces.back().last = i;
    pieces.push_back({i, times.size()});
  }
  return pieces;
}

bool are_usable(const std::vector<Piece>& pieces, const std::vector<LogTime>& times) {
  constexpr std::size_t kShortest = 10;  // scans: fewer may be lines with wrong stamps
  return std::all_of(pieces.begin(), pieces.end(), [&](const Piece& p) {
    const auto at = [&](std::size_t i) { return times.begin() + static_cast<std::ptrdiff_t>(i); };
    return p.last - p.first >= kShortest && is_usable({at(p.first), at(p.last)});
  });
}

/// The piece of a line: by its place in the file, but of two that meet there the one whose range of
/// stamps contains the line's.
Duration offset_of(const std::vector<Piece>& pieces, const Scans& scans, std::size_t line,
                   LogTime stamp) {
  const auto next = std::partition_point(pieces.begin() + 1, pieces.end(), [&](const Piece& p) {
    return scans.lines[p.first] <= line;
  });
  const auto contains = [&](const Piece& p) {
    const Duration slack = std::chrono::seconds(1);
    return stamp >= scans.times[p.first] - slack && stamp <= scans.times[p.last - 1] + slack;
  };
  const Piece& own = *std::prev(next);
  if (!contains(own) && next != pieces.end() && contains(*next)) return next->offset;
  return own.offset;
}

std::optional<ClockRepair> continue_clock(LogLines& lines, const Scans& scans) {
  const std::vector<LogTime>& times = scans.times;
  std::vector<Piece> pieces = pieces_of(times);
  const std::optional<Duration> step = median_step(times);
  if (pieces.size() < 2 || !step || !are_usable(pieces, times)) return std::nullopt;
  for (std::size_t k = 1; k < pieces.size(); ++k)
    pieces[k].offset =
        times[pieces[k - 1].last - 1] + pieces[k - 1].offset + *step - times[pieces[k].first];
  set_times(lines, [&](auto& line) {
    return time_of(line) + offset_of(pieces, scans, line.line, time_of(line));
  });
  return ClockRepair{ClockState::continued,
                     "the clock was set back " + std::to_string(pieces.size() - 1) +
                         " times, first before line " +
                         std::to_string(scans.lines[pieces[1].first]) +
                         ": it is continued with the usual step of " + seconds_text(*step)};
}

// ---- single stamps out of order ------------------------------------------------------------

/// Times that are not kept, between those before and after them, by their place.
void interpolate(std::vector<LogTime>& times, const std::vector<bool>& keep) {
  const auto known = [&](std::size_t i) { return keep[i]; };
  std::size_t before = times.size();
  for (std::size_t i = 0; i < times.size(); ++i) {
    if (known(i)) {
      before = i;
      continue;
    }
    std::size_t after = i;
    while (after < times.size() && !known(after)) ++after;
    if (before == times.size()) {
      times[i] = times[after];
    } else if (after == times.size()) {
      times[i] = times[before];
    } else {
      times[i] = times[before] + (times[after] - times[before]) *
                                     static_cast<std::int64_t>(i - before) /
                                     static_cast<std::int64_t>(after - before);
    }
  }
}

template <class Lines>
void interpolate_disordered(Lines& lines) {
  std::vector<LogTime> times;
  times.reserve(lines.size());
  for (auto& line : lines) times.push_back(time_of(line));
  std::vector<bool> keep = largest_ordered_set(times);
  std::optional<LogTime> last;  // of equal stamps the first is kept
  for (std::size_t i = 0; i < times.size(); ++i) {
    if (!keep[i]) continue;
    keep[i] = times[i] != last;
    last = times[i];
  }
  interpolate(times, keep);
  for (std::size_t i = 0; i < lines.size(); ++i) time_of(lines[i]) = times[i];
}

/// `in_order`: most stamps are in order, but many are equal.
std::optional<ClockRepair> interpolate_clock(LogLines& lines, const Scans& scans, bool in_order) {
  const std::size_t n = scans.times.size(), kept = count(largest_ordered_set(scans.times));
  if (2 * kept < n || !(in_order || median_step(scans.times))) return std::nullopt;
  for_each_stream(lines, [](auto& stream) { interpolate_disordered(stream); });
  return ClockRepair{ClockState::interpolated,
                     "time stamps of " + std::to_string(n - kept) + " of " + std::to_string(n) +
                         " scans are out of order, of " + std::to_string(scans.equal) +
                         " that of the scan before: their times are interpolated"};
}

// ---- stamps without use --------------------------------------------------------------------

std::optional<ClockRepair> take_logger_times(LogLines& lines, const Scans& scans,
                                             const std::string& fault) {
  const std::vector<LogTime>& times = scans.logger_times;
  if (times.size() != scans.times.size() || !is_usable(times) || !median_step(times))
    return std::nullopt;
  set_times(lines, [](auto& line) { return line.logger_time.value_or(time_of(line)); });
  return ClockRepair{ClockState::logger, fault + ": the logger's times are used"};
}

/// Of the whole log, forwards or backwards, where it is one that a scanner has.
std::optional<Duration> mean_step(const std::vector<LogTime>& times) {
  if (times.size() < 2) return std::nullopt;
  const auto steps = static_cast<std::int64_t>(times.size() - 1);
  const Duration step = std::chrono::abs(times.back() - times.front()) / steps;
  const bool usual = step >= Duration(std::chrono::milliseconds(1)) && step <= kLargestPeriod;
  return usual ? std::optional(step) : std::nullopt;
}

/// Why the stamps cannot be used.
std::string fault_of(const std::vector<LogTime>& times) {
  const auto [least, most] = std::minmax_element(times.begin(), times.end());
  const std::string stamps = "time stamps cannot be used: ";
  if (*least == *most) return stamps + "all are " + format_nanoseconds(least->nanoseconds()) + " s";
  if (times.back() < times.front()) return stamps + "they run backwards";
  return stamps + std::to_string(times.size() - count(largest_ordered_set(times))) + " of " +
         std::to_string(times.size()) + " scans are not in their order, or too many are equal";
}

ClockRepair number_scans(LogLines& lines, const Scans& scans, Duration default_period,
                         const std::string& fault) {
  const Duration period = mean_step(scans.times).value_or(default_period);
  const std::vector<std::size_t>& at = scans.lines;
  // Lines between two scans divide the time evenly; the last one, which usually belongs to the
  // next scan, has its time.
  set_times(lines, [&](auto& line) {
    const auto next = std::lower_bound(at.begin(), at.end(), line.line);
    const auto index = std::distance(at.begin(), next);
    LogTime time = LogTime() + period * index;
    if (next == at.end() || *next == line.line || next == at.begin()) return time;
    const auto behind = static_cast<std::int64_t>(*next - 1 - line.line);
    const auto between = static_cast<std::int64_t>(*next - *std::prev(next) - 1);
    return time - period * behind / between;
  });
  return {ClockState::numbered, fault + ": scans are numbered in the order of the file, one each " +
                                    seconds_text(period)};
}

}  // namespace

std::vector<bool> largest_ordered_set(const std::vector<LogTime>& times) {
  constexpr auto kNone = static_cast<std::size_t>(-1);
  std::vector<std::size_t> tails, previous(times.size(), kNone);
  for (std::size_t i = 0; i < times.size(); ++i) {
    const auto pile =
        std::upper_bound(tails.begin(), tails.end(), times[i],
                         [&](LogTime t, std::size_t tail) { return t < times[tail]; });
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

std::vector<std::optional<LogTime>> times_of_late_lines(const std::vector<LogTime>& times) {
  constexpr Duration kLittle = std::chrono::milliseconds(500);
  const std::vector<bool> keep = largest_ordered_set(times);
  std::vector<LogTime> between = times;
  interpolate(between, keep);
  std::vector<std::optional<LogTime>> late(times.size());
  for (std::size_t i = 0; i < times.size(); ++i)
    if (!keep[i] && std::chrono::abs(between[i] - times[i]) <= kLittle) late[i] = between[i];
  return late;
}

ClockRepair repair_clock(LogLines& lines, const std::vector<ScanLine>& scan_lines,
                         Duration default_period) {
  Scans scans;
  for (const ScanLine& line : scan_lines) {
    scans.lines.push_back(line.line);
    scans.times.push_back(line.scan.time);
    if (line.logger_time) scans.logger_times.push_back(*line.logger_time);
    if (&line == &scan_lines.front()) continue;
    const ScanLine& before = *(&line - 1);
    if (line.scan.time == before.scan.time && line.scan.ranges_m != before.scan.ranges_m)
      ++scans.equal;
  }
  const bool usable = scans.times.empty() || is_usable(scans.times);
  if (usable && !scans.are_coarse()) return {};
  if (!usable)
    if (auto done = continue_clock(lines, scans)) return *done;
  if (auto done = interpolate_clock(lines, scans, usable)) return *done;
  const std::string fault = fault_of(scans.times);
  if (auto done = take_logger_times(lines, scans, fault)) return *done;
  return number_scans(lines, scans, default_period, fault);
}

}  // namespace wayfare::io::carmen
