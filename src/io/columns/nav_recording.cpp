#include <wayfare/io/nav_recording.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <optional>
#include <utility>

#include <wayfare/eval/table.hpp>
#include <wayfare/gnss/correct_ranges.hpp>
#include <wayfare/gnss/gps_time.hpp>
#include <wayfare/gnss/single_point.hpp>
#include <wayfare/io/observations.hpp>
#include <wayfare/io/rinex.hpp>
#include <wayfare/sync/in_order.hpp>

namespace wayfare::io {
namespace {

using StampedVelocity = std::pair<LogTime, Eigen::Vector3d>;
using ToGpsTime = std::function<LogTime(LogTime)>;

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

/// An error, with the gap, for streams that do not overlap in time.
template <class Measurements>
Result<void> check_overlap(const char* what, const std::vector<ImuSample>& imu,
                           const Measurements& other, Duration imu_offset) {
  if (other.empty()) return {};
  const LogTime first = imu.front().time + imu_offset, last = imu.back().time + imu_offset;
  const LogTime begin = other.front().time, end = other.back().time;
  if (begin <= last && first <= end) return {};
  const bool late = begin > last;
  const double weeks = std::abs(to_seconds(begin - first)) / 604800.0;
  std::string text =
      std::string("the ") + what + (late ? " begin " : " end ") +
      eval::fixed(to_seconds(late ? begin - last : first - end), 3) + " s" +
      (late ? " after the inertial samples end" : " before the inertial samples begin");
  if (std::abs(weeks - std::round(weeks)) < 0.02 && weeks > 0.5)
    text += ": about " + eval::fixed(std::round(weeks), 0) + " GPS weeks apart";
  text +=
      "; the files are of different drives, or the unit's clock needs imu_time_offset_s or a "
      "conversion";
  return Error{ErrorCode::invalid, text};
}

/// "2025-07-08 19:34"
std::string date_of(Time<GpsClock> time) {
  const CivilTime c = civil_from_gps(time);
  char text[40];
  std::snprintf(text, sizeof text, "%04d-%02d-%02d %02d:%02d", c.year, c.month, c.day, c.hour,
                c.minute);
  return text;
}

/// Times of the observations and of the messages, which may be of another day.
std::string days_of(const std::vector<ObservationEpoch>& epochs, const Ephemerides& ephemerides) {
  if (epochs.empty()) return {};
  std::optional<Time<GpsClock>> first, last;
  for (const SatelliteId id : ephemerides.satellites())
    for (const Ephemeris& e : ephemerides.of(id)) {
      const Time<GpsClock> t = reference_time(e);
      first = first ? std::min(*first, t) : t, last = last ? std::max(*last, t) : t;
    }
  if (!first) return "; the navigation files have no messages";
  return "; observations from " + date_of(epochs.front().time) + " to " +
         date_of(epochs.back().time) + ", navigation messages for " + date_of(*first) + " to " +
         date_of(*last) + " GPS time";
}

class Loader {
 public:
  Loader(const NavFiles& files, const NavFormats& formats, const NavReading& reading)
      : files_(files), formats_(formats), reading_(reading) {}

  Result<NavRecording> load() {
    GnssInsRecording& r = out_.recording;
    for (const NavFileFormat* format : {&formats_.fixes, &formats_.truth})
      if (!std::isfinite(format->velocity_late_s))
        return Error{ErrorCode::invalid, "the delay of velocities is not a number of seconds"};
    if (auto done = load_imu(); !done) return done.error();
    if (r.imu.empty()) return Error{ErrorCode::invalid, "the inertial unit has no samples"};
    if (auto done = load_ranges(); !done) return done.error();
    if (auto done = load_fixes(); !done) return done.error();
    if (r.ranges.empty() && r.fixes.empty())
      return Error{ErrorCode::invalid,
                   "satellite measurements are needed: raw observations and navigation messages, "
                   "ranges, or fixes"};
    if (auto done = load_truth(); !done) return done.error();
    if (auto done = load_wheels(); !done) return done.error();
    if (reading_.apart) return std::move(out_);
    const Duration offset = from_seconds(reading_.imu_time_offset_s);
    for (const Result<void>& check :
         {check_overlap("range epochs", r.imu, r.ranges, offset),
          check_overlap("fixes", r.imu, r.fixes, offset),
          check_overlap("wheel speeds", r.imu, r.wheels, offset),
          check_overlap("reference states", r.imu, out_.truth.states, offset)})
      if (!check) return check.error();
    return std::move(out_);
  }

 private:
  /// The result of a reader, whose problems are reported.
  template <class File>
  Result<File> noted(Result<File> file, const std::string& path) {
    if (!file) return file;
    if (reading_.problems) reading_.problems(file->problems);
    if (!file->problems.empty())
      out_.remarks.push_back(path + ": " + std::to_string(file->problems.count()) +
                             " lines skipped");
    return file;
  }

  template <class Measurement>
  void order(const char* what, std::vector<Measurement>& all) {
    const SortReport report = sort_by_time(all);
    const auto add = [&](std::size_t count, const char* how) {
      if (count > 0) out_.remarks.push_back(std::to_string(count) + " " + what + " " + how);
    };
    add(report.out_of_order, "out of order, sorted");
    add(report.duplicates, "with a repeated time, left out");
    add(report.outliers, "with a time far from their neighbours', left out");
  }

  Result<ImuFile> read_part(std::size_t i) {
    const ColumnFormat format = i < formats_.imu.size() ? formats_.imu[i].format : ColumnFormat{};
    return noted(reading_.imu(files_.imu[i], format), files_.imu[i]);
  }

  template <class Fit>
  void remark_clock(const Fit& fit) {
    out_.remarks.push_back("inertial clock: rate error " + eval::fixed(1e6 * (fit.rate - 1.0), 1) +
                           " ppm, scatter of the stamps " + eval::fixed(1e3 * fit.residual_s, 1) +
                           " ms");
  }

  /// From the unit's clock to GPS time; empty without a file of either kind.
  Result<ToGpsTime> device_clock(const ImuFile& imu) {
    if (!files_.imu_tags.empty()) {
      const auto tags = noted(read_time_tags(files_.imu_tags), files_.imu_tags);
      if (!tags) return tags.error();
      const auto fit = fit_time_tags(imu, *tags);
      if (!fit) return fit.error();
      remark_clock(*fit);
      return ToGpsTime(*fit);
    }
    if (files_.imu_clock.empty()) return ToGpsTime();
    const auto clock =
        noted(read_clock(files_.imu_clock, formats_.imu_clock.format), files_.imu_clock);
    if (!clock) return clock.error();
    const auto fit = fit_clock<DeviceClock>(clock->pairs);
    if (!fit) return fit.error();
    remark_clock(*fit);
    return ToGpsTime([line = *fit](LogTime t) {
      return line(Time<DeviceClock>::from_nanoseconds(t.nanoseconds()));
    });
  }

  Result<void> load_imu() {
    if (files_.imu.empty() || files_.imu.size() > 2)
      return Error{ErrorCode::invalid, "an inertial unit has one or two files"};
    auto first = read_part(0);
    if (!first) return first.error();
    const auto clock = device_clock(*first);
    if (!clock) return clock.error();
    std::vector<ImuSample>& samples = out_.recording.imu;
    samples = std::move(first->samples);
    if (files_.imu.size() == 2) {
      auto second = read_part(1);
      if (!second) return second.error();
      if (first->has_gyro == second->has_gyro ||
          first->has_accelerometer == second->has_accelerometer)
        return Error{ErrorCode::invalid,
                     "one file must contain the gyro and the other the accelerometer",
                     files_.imu[1]};
      order("inertial samples", samples);
      order("inertial samples", second->samples);
      samples = first->has_gyro ? merge_imu_parts(samples, second->samples)
                                : merge_imu_parts(second->samples, samples);
      if (samples.empty())
        return Error{ErrorCode::invalid, "the two parts do not overlap in time", files_.imu[1]};
    }
    order("inertial samples", samples);
    if (*clock)
      for (ImuSample& s : samples) s.time = (*clock)(s.time);
    return {};
  }

  Result<void> load_ranges() {
    if (!files_.ranges.empty()) {
      auto ranges = noted(read_ranges(files_.ranges, formats_.ranges.format), files_.ranges);
      if (!ranges) return ranges.error();
      out_.recording.ranges = std::move(ranges->epochs);
    } else if (!files_.observations.empty()) {
      if (auto done = load_raw(); !done) return done;
    }
    order("range epochs", out_.recording.ranges);
    return {};
  }

  /// Of the files, and those in the stream of observations.
  Result<Ephemerides> load_navigation(const Ephemerides& received) {
    std::optional<Ephemerides> all;
    for (const std::string& path : files_.navigation) {
      auto one = noted(read_rinex_navigation(path), path);
      if (!one) return one.error();
      if (!all) {
        all = std::move(one->ephemerides);
      } else {
        all->add(one->ephemerides);
      }
    }
    if (!all && received.empty())
      return Error{ErrorCode::invalid, "raw observations need a navigation file"};
    if (!all) return received;
    all->add(received);
    return *std::move(all);
  }

  Result<void> load_raw() {
    const auto observations = noted(read_observations(files_.observations), files_.observations);
    if (!observations) return observations.error();
    const auto ephemerides = load_navigation(observations->ephemerides);
    if (!ephemerides) return ephemerides.error();

    SinglePointOptions options;
    options.corrections.elevation_mask = Angle::degrees(formats_.elevation_mask_deg);
    options.corrections.min_cn0_dbhz = formats_.min_cn0_dbhz;
    Eigen::Vector3d near = Eigen::Vector3d::Zero();
    std::map<RangeRefusal, std::size_t> refused;
    std::size_t positions = 0, seen = 0, used = 0;
    const auto& epochs = observations->epochs;
    for (std::size_t i = 0; i < epochs.size(); ++i) {
      if (reading_.progress)
        reading_.progress(static_cast<double>(i) / static_cast<double>(epochs.size()));
      const auto point = single_point(epochs[i], *ephemerides, options, near);
      if (point && point->consistent) {
        near = point->position_ecef_m;
        ++positions;
      }
      std::vector<RefusedRange> why;
      RangeEpoch ranges = correct_ranges(epochs[i], *ephemerides, near, options.corrections, &why);
      seen += epochs[i].satellites.size();
      used += ranges.satellites.size();
      for (const RefusedRange& r : why) ++refused[r.why];
      if (near.isZero() || ranges.satellites.empty()) continue;
      out_.recording.ranges.push_back(std::move(ranges));
    }
    const std::string number = std::to_string(epochs.size()), all = std::to_string(seen);
    if (out_.recording.ranges.empty())
      return Error{ErrorCode::not_found,
                   "none of its " + number +
                       " epochs gives a position with these navigation files; of " + all +
                       " satellites: " + reasons(refused) + days_of(epochs, *ephemerides),
                   files_.observations};
    out_.remarks.push_back(files_.observations + ": " + number + " epochs, " +
                           std::to_string(positions) + " with a single-point position; " +
                           std::to_string(used) + " of " + all + " satellites used" +
                           (refused.empty() ? "" : ", the others: " + reasons(refused)));
    return {};
  }

  Result<void> load_fixes() {
    if (files_.fixes.empty()) return {};
    auto file = noted(reading_.fixes(files_.fixes, formats_.fixes.format), files_.fixes);
    if (!file) return file.error();
    std::vector<GnssFix>& fixes = out_.recording.fixes;
    fixes = std::move(file->fixes);
    order("fixes", fixes);
    if (formats_.fixes.velocity_late_s == 0.0) return {};
    const Duration late = from_seconds(formats_.fixes.velocity_late_s);
    std::vector<StampedVelocity> velocities;
    for (const GnssFix& f : fixes)
      if (f.velocity_ned_mps) velocities.emplace_back(f.time - late, *f.velocity_ned_mps);
    for (GnssFix& fix : fixes)
      if (fix.velocity_ned_mps) fix.velocity_ned_mps = velocity_at(fix.time, velocities);
    return {};
  }

  Result<void> load_wheels() {
    if (files_.wheels.empty()) return {};
    auto file = noted(read_wheels(files_.wheels, formats_.wheels.format), files_.wheels);
    if (!file) return file.error();
    out_.recording.wheels = std::move(file->readings);
    order("wheel speeds", out_.recording.wheels);
    return {};
  }

  Result<void> load_truth() {
    if (files_.truth.empty()) return {};
    auto file = noted(read_nav(files_.truth, formats_.truth.format), files_.truth);
    if (!file) return file.error();
    out_.truth = {std::move(file->trajectory), file->has_velocity, file->has_attitude};
    NavTrajectory& states = out_.truth.states;
    order("reference states", states);
    if (!file->has_velocity || formats_.truth.velocity_late_s == 0.0) return {};
    const Duration late = from_seconds(formats_.truth.velocity_late_s);
    std::vector<StampedVelocity> velocities;
    for (const NavState& s : states) velocities.emplace_back(s.time - late, s.velocity_ned_mps);
    for (NavState& s : states)
      s.velocity_ned_mps = velocity_at(s.time, velocities).value_or(s.velocity_ned_mps);
    return {};
  }

  const NavFiles& files_;
  const NavFormats& formats_;
  const NavReading& reading_;
  NavRecording out_;
};

}  // namespace

Result<NavRecording> read_nav_recording(const NavFiles& files, const NavFormats& formats,
                                        const NavReading& reading) {
  return Loader(files, formats, reading).load();
}

}  // namespace wayfare::io
