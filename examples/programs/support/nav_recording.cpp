#include "nav_recording.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <optional>
#include <utility>

#include <wayfare/eval/table.hpp>
#include <wayfare/gnss/single_point.hpp>
#include <wayfare/io/nav_text.hpp>
#include <wayfare/io/rinex.hpp>
#include <wayfare/sync/in_order.hpp>

#include "nav_ros.hpp"
#include "program_files.hpp"

namespace wayfare::examples {
namespace {

std::string seconds_text(Duration d) { return eval::fixed(to_seconds(d), 3) + " s"; }

void remark(NavRecording& out, const std::string& path, const io::Problems& problems) {
  print_problems(problems);
  if (!problems.empty())
    out.remarks.push_back(path + ": " + std::to_string(problems.count()) + " lines skipped");
}

template <class Measurement>
void order(NavRecording& out, const char* what, std::vector<Measurement>& all) {
  const SortReport report = sort_by_time(all);
  const auto add = [&](std::size_t count, const char* how) {
    if (count > 0) out.remarks.push_back(std::to_string(count) + " " + what + " " + how);
  };
  add(report.out_of_order, "out of order, sorted");
  add(report.duplicates, "with a repeated time, left out");
  add(report.outliers, "with a time far from their neighbours', left out");
}

Result<io::ImuFile> read_part(const NavFiles& files, const NavConfig& config, std::size_t i,
                              NavRecording& out) {
  const FileDescription description = i < config.imu.size() ? config.imu[i] : FileDescription{};
  auto file = read_unit(files.imu[i], description.format, files.topics);
  if (file) remark(out, files.imu[i], file->problems);
  return file;
}

using ToGpsTime = std::function<LogTime(LogTime)>;

/// From the unit's clock to GPS time; empty without a file of either kind.
Result<ToGpsTime> device_clock(const NavFiles& files, const NavConfig& config,
                               const io::ImuFile& imu, NavRecording& out) {
  const auto add_remark = [&](double rate, double residual_s) {
    out.remarks.push_back("inertial clock: rate error " + eval::fixed(1e6 * (rate - 1.0), 1) +
                          " ppm, scatter of the stamps " + eval::fixed(1e3 * residual_s, 1) +
                          " ms");
  };
  if (!files.imu_tags.empty()) {
    const auto tags = io::read_time_tags(files.imu_tags);
    if (!tags) return tags.error();
    remark(out, files.imu_tags, tags->problems);
    const auto fit = io::fit_time_tags(imu, *tags);
    if (!fit) return fit.error();
    add_remark(fit->rate, fit->residual_s);
    return ToGpsTime(*fit);
  }
  if (files.imu_clock.empty()) return ToGpsTime();
  const auto clock = io::read_clock(files.imu_clock, config.imu_clock.format);
  if (!clock) return clock.error();
  remark(out, files.imu_clock, clock->problems);
  const auto fit = fit_clock<DeviceClock>(clock->pairs);
  if (!fit) return fit.error();
  add_remark(fit->rate, fit->residual_s);
  return ToGpsTime([line = *fit](LogTime t) {
    return line(Time<DeviceClock>::from_nanoseconds(t.nanoseconds()));
  });
}

Result<void> load_imu(const NavFiles& files, const NavConfig& config, NavRecording& out) {
  if (files.imu.empty() || files.imu.size() > 2)
    return Error{ErrorCode::invalid, "an inertial unit has one or two files"};
  auto first = read_part(files, config, 0, out);
  if (!first) return first.error();
  const auto clock = device_clock(files, config, *first, out);
  if (!clock) return clock.error();
  std::vector<ImuSample>& samples = out.recording.imu;
  samples = std::move(first->samples);
  if (files.imu.size() == 2) {
    auto second = read_part(files, config, 1, out);
    if (!second) return second.error();
    if (first->has_gyro == second->has_gyro ||
        first->has_accelerometer == second->has_accelerometer)
      return Error{ErrorCode::invalid,
                   "one file must contain the gyro and the other the accelerometer", files.imu[1]};
    order(out, "inertial samples", samples);
    order(out, "inertial samples", second->samples);
    samples = first->has_gyro ? io::merge_imu_parts(samples, second->samples)
                              : io::merge_imu_parts(second->samples, samples);
    if (samples.empty())
      return Error{ErrorCode::invalid, "the two parts do not overlap in time", files.imu[1]};
  }
  order(out, "inertial samples", samples);
  if (*clock)
    for (ImuSample& s : samples) s.time = (*clock)(s.time);
  return {};
}

Result<io::RinexNavigation> load_navigation(const std::vector<std::string>& paths,
                                            NavRecording& out) {
  std::optional<io::RinexNavigation> all;
  for (const std::string& path : paths) {
    auto one = io::read_rinex_navigation(path);
    if (!one) return one.error();
    remark(out, path, one->problems);
    if (!all) {
      all = std::move(*one);
    } else {
      all->ephemerides.add(one->ephemerides);
    }
  }
  if (!all) return Error{ErrorCode::invalid, "raw observations need a navigation file (--nav)"};
  return std::move(*all);
}

/// Why satellites could not be used, most frequent reason first.
std::string reasons(const std::map<RangeRefusal, std::size_t>& counts) {
  std::vector<std::pair<std::size_t, RangeRefusal>> sorted;
  for (const auto& [why, count] : counts) sorted.emplace_back(count, why);
  std::sort(sorted.rbegin(), sorted.rend());
  std::string text;
  for (const auto& [count, why] : sorted)
    text += (text.empty() ? "" : ", ") + std::to_string(count) + " " + to_text(why);
  return text;
}

Result<void> load_raw(const NavFiles& files, const NavConfig& config, NavRecording& out,
                      const std::function<void(double)>& progress) {
  const auto observations = io::read_rinex_observations(files.observations);
  if (!observations) return observations.error();
  remark(out, files.observations, observations->problems);
  const auto navigation = load_navigation(files.navigation, out);
  if (!navigation) return navigation.error();

  SinglePointOptions options;
  options.corrections.elevation_mask = Angle::degrees(config.elevation_mask_deg);
  options.corrections.min_cn0_dbhz = config.min_cn0_dbhz;
  Eigen::Vector3d near = Eigen::Vector3d::Zero();
  std::map<RangeRefusal, std::size_t> refused;
  std::size_t positions = 0, seen = 0, used = 0;
  const auto& epochs = observations->epochs;
  for (std::size_t i = 0; i < epochs.size(); ++i) {
    if (progress) progress(static_cast<double>(i) / static_cast<double>(epochs.size()));
    const auto point = single_point(epochs[i], navigation->ephemerides, options, near);
    if (point && point->consistent) {
      near = point->position_ecef_m;
      ++positions;
    }
    std::vector<RefusedRange> why;
    RangeEpoch ranges =
        correct_ranges(epochs[i], navigation->ephemerides, near, options.corrections, &why);
    seen += epochs[i].satellites.size();
    used += ranges.satellites.size();
    for (const RefusedRange& r : why) ++refused[r.why];
    if (near.isZero() || ranges.satellites.empty()) continue;
    out.recording.ranges.push_back(std::move(ranges));
  }
  if (out.recording.ranges.empty())
    return Error{ErrorCode::not_found,
                 "none of its " + std::to_string(epochs.size()) +
                     " epochs gives a position with these navigation files; of " +
                     std::to_string(seen) + " satellites: " + reasons(refused),
                 files.observations};
  out.remarks.push_back(files.observations + ": " + std::to_string(epochs.size()) + " epochs, " +
                        std::to_string(positions) + " with a single-point position; " +
                        std::to_string(used) + " of " + std::to_string(seen) + " satellites used" +
                        (refused.empty() ? "" : ", the others: " + reasons(refused)));
  return {};
}

using StampedVelocity = std::pair<LogTime, Eigen::Vector3d>;

/// By linear interpolation.
std::optional<Eigen::Vector3d> velocity_at(LogTime time, const std::vector<StampedVelocity>& v) {
  const auto after = std::lower_bound(
      v.begin(), v.end(), time, [](const StampedVelocity& s, LogTime t) { return s.first < t; });
  if (after == v.end() || (after == v.begin() && after->first != time)) return std::nullopt;
  if (after->first == time) return after->second;
  const auto before = after - 1;
  const double part = to_seconds(time - before->first) / to_seconds(after->first - before->first);
  return (1.0 - part) * before->second + part * after->second;
}

Result<void> load_fixes(const NavFiles& files, const NavConfig& config, NavRecording& out) {
  auto file = read_receiver(files.fixes, config.fixes.format, files.topics);
  if (!file) return file.error();
  remark(out, files.fixes, file->problems);
  out.recording.fixes = std::move(file->fixes);
  std::vector<GnssFix>& fixes = out.recording.fixes;
  order(out, "fixes", fixes);
  if (config.fixes.velocity_late_s == 0.0) return {};
  const Duration late = from_seconds(config.fixes.velocity_late_s);
  std::vector<StampedVelocity> velocities;
  for (const GnssFix& f : fixes)
    if (f.velocity_ned_mps) velocities.emplace_back(f.time - late, *f.velocity_ned_mps);
  for (GnssFix& fix : fixes)
    if (fix.velocity_ned_mps) fix.velocity_ned_mps = velocity_at(fix.time, velocities);
  return {};
}

Result<void> load_truth(const NavFiles& files, const NavConfig& config, NavRecording& out) {
  auto file = io::read_nav(files.truth, config.truth.format);
  if (!file) return file.error();
  remark(out, files.truth, file->problems);
  out.truth = std::move(file->trajectory);
  out.truth_has_velocity = file->has_velocity;
  out.truth_has_attitude = file->has_attitude;
  order(out, "reference states", out.truth);
  if (!file->has_velocity || config.truth.velocity_late_s == 0.0) return {};
  const Duration late = from_seconds(config.truth.velocity_late_s);
  std::vector<StampedVelocity> velocities;
  for (const NavState& s : out.truth) velocities.emplace_back(s.time - late, s.velocity_ned_mps);
  for (NavState& s : out.truth)
    s.velocity_ned_mps = velocity_at(s.time, velocities).value_or(s.velocity_ned_mps);
  return {};
}

struct Span {
  LogTime first, last;
};

/// An error, with the gap, for streams that do not overlap in time.
Result<void> check_overlap(const char* what, const Span& imu, const Span& other) {
  if (other.first <= imu.last && imu.first <= other.last) return {};
  const Duration apart = other.first > imu.last ? other.first - imu.last : imu.first - other.last;
  const double weeks = std::abs(to_seconds(other.first - imu.first)) / 604800.0;
  std::string text = std::string("the ") + what + (other.first > imu.last ? " begin " : " end ") +
                     seconds_text(apart) +
                     (other.first > imu.last ? " after the inertial samples end"
                                             : " before the inertial samples begin");
  if (std::abs(weeks - std::round(weeks)) < 0.02 && weeks > 0.5)
    text += ": about " + eval::fixed(std::round(weeks), 0) + " GPS weeks apart";
  return Error{ErrorCode::invalid, text};
}

template <class Measurements>
Result<void> check_overlap(const char* what, const std::vector<ImuSample>& imu,
                           const Measurements& other) {
  if (other.empty()) return {};
  return check_overlap(what, {imu.front().time, imu.back().time},
                       {other.front().time, other.back().time});
}

}  // namespace

Result<NavRecording> load_nav_recording(const NavFiles& files, const NavConfig& config,
                                        const std::function<void(double)>& progress) {
  NavRecording out;
  GnssInsRecording& r = out.recording;
  if (auto done = load_imu(files, config, out); !done) return done.error();
  if (!files.ranges.empty()) {
    auto ranges = io::read_ranges(files.ranges, config.ranges.format);
    if (!ranges) return ranges.error();
    remark(out, files.ranges, ranges->problems);
    r.ranges = std::move(ranges->epochs);
  } else if (!files.observations.empty()) {
    if (auto done = load_raw(files, config, out, progress); !done) return done.error();
  }
  order(out, "range epochs", r.ranges);
  if (!files.fixes.empty())
    if (auto done = load_fixes(files, config, out); !done) return done.error();
  if (r.ranges.empty() && r.fixes.empty())
    return Error{ErrorCode::invalid,
                 "satellite measurements are needed: --obs and --nav, --ranges, "
                 "or --fixes"};
  if (!files.truth.empty())
    if (auto done = load_truth(files, config, out); !done) return done.error();
  for (const Result<void>& check :
       {check_overlap("range epochs", r.imu, r.ranges), check_overlap("fixes", r.imu, r.fixes),
        check_overlap("reference states", r.imu, out.truth)})
    if (!check) return check.error();
  return out;
}

}  // namespace wayfare::examples
