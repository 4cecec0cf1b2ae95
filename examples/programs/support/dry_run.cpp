#include "dry_run.hpp"

#include <cmath>
#include <cstdio>
#include <limits>
#include <utility>
#include <vector>

#include <wayfare/core/se3.hpp>
#include <wayfare/eval/table.hpp>
#include <wayfare/gnss/ephemerides.hpp>
#include <wayfare/gnss/gps_time.hpp>
#include <wayfare/io/nav_text.hpp>

#include "degree.hpp"
#include "program_files.hpp"

namespace wayfare::examples {
namespace {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

/// As GPS time, which a counter of the unit's own is not.
std::string calendar(LogTime time) {
  const CivilTime t = civil_from_gps(gps_time(time));
  char text[80];
  std::snprintf(text, sizeof text, "%04d-%02d-%02d %02d:%02d:%06.3f", t.year, t.month, t.day,
                t.hour, t.minute, to_seconds(t.of_minute));
  return text;
}

std::string columns_of(const std::vector<io::ColumnUse>& columns) {
  std::string text;
  for (const io::ColumnUse& use : columns) {
    text += "  column " + std::to_string(use.column);
    if (!use.heading.empty() && use.heading != use.name) text += " '" + use.heading + "'";
    text += ": " + use.name + "\n";
  }
  return text;
}

/// A file's rows: the first three and the last. `row` gives the cells behind the time.
template <class Rows, class TimeOf, class Row>
std::string rows_of(const Rows& rows, std::vector<eval::Table::Column> columns,
                    const TimeOf& time_of, const Row& row) {
  columns.insert(columns.begin(), {{"row"}, {"time", "s"}, {"as GPS time"}});
  eval::Table table(columns);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (i >= 3 && i + 1 != rows.size()) continue;
    const LogTime time = time_of(rows[i]);
    std::vector<std::string> cells = {std::to_string(i + 1), eval::fixed(time.seconds(), 3),
                                      calendar(time)};
    for (const auto& [value, decimals] : row(rows[i]))
      cells.push_back(eval::fixed(value, decimals));
    table.add_row(std::move(cells));
  }
  return table.to_text();
}

std::string heading_of(const std::string& what, const std::string& path, std::size_t rows,
                       const io::Problems& problems) {
  std::string text = what + " " + path + ": " + std::to_string(rows) + " rows";
  if (!problems.empty())
    text += ", " + std::to_string(problems.count()) +
            " lines skipped, the first: " + problems.first().front().to_string();
  return text + "\n";
}

using Cells = std::vector<std::pair<double, int>>;

void add(Cells& cells, const Eigen::Vector3d& values, int decimals) {
  for (const double v : values) cells.emplace_back(v, decimals);
}

void add(Cells& cells, const Geodetic& p) {
  cells.emplace_back(p.latitude.degrees(), 7);
  cells.emplace_back(p.longitude.degrees(), 7);
  cells.emplace_back(p.height_m, 2);
}

std::string show(const std::string& path, const io::ImuFile& file) {
  return heading_of("inertial samples", path, file.samples.size(), file.problems) +
         columns_of(file.columns) +
         rows_of(
             file.samples,
             {{"gx", "deg/s"},
              {"gy", "deg/s"},
              {"gz", "deg/s"},
              {"ax", "m/s^2"},
              {"ay", "m/s^2"},
              {"az", "m/s^2"},
              {"|a|", "m/s^2"}},
             [](const ImuSample& s) { return s.time; },
             [&](const ImuSample& s) {
               Cells cells;
               const Eigen::Vector3d none = Eigen::Vector3d::Constant(kUnknown);
               add(cells, file.has_gyro ? (s.angular_rate_radps / kDegree).eval() : none, 3);
               const Eigen::Vector3d a = file.has_accelerometer ? s.specific_force_mps2 : none;
               add(cells, a, 3);
               cells.emplace_back(a.norm(), 3);
               return cells;
             });
}

std::string show(const std::string& path, const io::FixFile& file) {
  return heading_of("fixes", path, file.fixes.size(), file.problems) + columns_of(file.columns) +
         rows_of(
             file.fixes,
             {{"lat", "deg"},
              {"lon", "deg"},
              {"h", "m"},
              {"sn", "m"},
              {"se", "m"},
              {"sd", "m"},
              {"vn", "m/s"},
              {"ve", "m/s"},
              {"vd", "m/s"}},
             [](const GnssFix& f) { return f.time; },
             [](const GnssFix& f) {
               Cells cells;
               add(cells, f.position);
               add(cells, f.position_covariance_ned_m2.diagonal().cwiseSqrt(), 2);
               add(cells, f.velocity_ned_mps.value_or(Eigen::Vector3d::Constant(kUnknown).eval()),
                   2);
               return cells;
             });
}

std::string show(const std::string& path, const io::NavFile& file) {
  return heading_of("reference", path, file.trajectory.size(), file.problems) +
         columns_of(file.columns) +
         rows_of(
             file.trajectory,
             {{"lat", "deg"},
              {"lon", "deg"},
              {"h", "m"},
              {"vn", "m/s"},
              {"ve", "m/s"},
              {"vd", "m/s"},
              {"roll", "deg"},
              {"pitch", "deg"},
              {"yaw", "deg"}},
             [](const NavState& s) { return s.time; },
             [&](const NavState& s) {
               Cells cells;
               const Eigen::Vector3d none = Eigen::Vector3d::Constant(kUnknown);
               add(cells, s.position);
               add(cells, file.has_velocity ? s.velocity_ned_mps : none, 2);
               const Eigen::Vector3d angles = roll_pitch_yaw_rad(s.q_nb) / kDegree;
               add(cells, file.has_attitude ? angles : none, 2);
               return cells;
             });
}

std::string show(const std::string& path, const io::ClockFile& file) {
  return heading_of("clock", path, file.pairs.size(), file.problems) + columns_of(file.columns) +
         rows_of(
             file.pairs, {{"device", "s"}}, [](const auto& pair) { return pair.log; },
             [](const auto& pair) {
               return Cells{{pair.device.seconds(), 6}};
             });
}

std::string show(const std::string& path, const io::WheelsFile& file) {
  return heading_of("wheel speeds", path, file.readings.size(), file.problems) +
         columns_of(file.columns) +
         rows_of(
             file.readings, {{"speed", "m/s"}}, [](const auto& reading) { return reading.time; },
             [](const auto& reading) {
               return Cells{{reading.speed_mps, 3}};
             });
}

std::string show(const std::string& path, const io::RangesFile& file) {
  return heading_of("range epochs", path, file.epochs.size(), file.problems) +
         columns_of(file.columns) +
         rows_of(
             file.epochs, {{"satellites"}, {"first range", "m"}, {"rate", "m/s"}, {"sigma", "m"}},
             [](const RangeEpoch& e) { return e.time; },
             [](const RangeEpoch& e) {
               const CorrectedRange& r = e.satellites.front();
               return Cells{{static_cast<double>(e.satellites.size()), 0},
                            {r.range_m, 3},
                            {r.range_rate_mps, 3},
                            {r.range_sigma_m, 2}};
             });
}

/// Adds what a reader understood; the error of a file is kept, and the others are still read.
template <class File>
void append(const std::string& path, const Result<File>& file, std::string& text,
            Result<void>& first_error) {
  if (!text.empty()) text += '\n';
  if (file) {
    text += show(path, *file);
    return;
  }
  text += file.error().to_string() + "\n";
  if (first_error) first_error = file.error();
}

}  // namespace

Result<std::string> dry_run(const NavFiles& files, const NavConfig& config) {
  std::string text;
  Result<void> good;
  for (std::size_t i = 0; i < files.imu.size(); ++i) {
    const io::ColumnFormat format =
        i < config.imu.size() ? config.imu[i].format : io::ColumnFormat{};
    append(files.imu[i], ros::read_imu(files.imu[i], format, files.topics), text, good);
  }
  if (!files.imu_clock.empty())
    append(files.imu_clock, io::read_clock(files.imu_clock, config.imu_clock.format), text, good);
  if (!files.ranges.empty())
    append(files.ranges, io::read_ranges(files.ranges, config.ranges.format), text, good);
  if (!files.fixes.empty())
    append(files.fixes, ros::read_fixes(files.fixes, config.fixes.format, files.topics), text,
           good);
  if (!files.wheels.empty())
    append(files.wheels, io::read_wheels(files.wheels, config.wheels.format), text, good);
  if (!files.truth.empty())
    append(files.truth, io::read_nav(files.truth, config.truth.format), text, good);
  if (!good) {
    std::fputs(text.c_str(), stdout);
    return good.error();
  }
  return text;
}

}  // namespace wayfare::examples
