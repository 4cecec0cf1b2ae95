#include "drives.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <numbers>

#include <wayfare/core/random.hpp>
#include <wayfare/eval/nav_error.hpp>

namespace wayfare::examples {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

GnssInsStart random_start(const NavState& truth, std::uint64_t seed) {
  GnssInsStart start;
  start.position_sigma_m = 3.0;
  start.velocity_sigma_mps = 0.3;
  start.level_sigma_rad = 1.0 * kDegree;
  start.heading_sigma_rad = 5.0 * kDegree;
  Rng rng = Rng(seed).stream(3);
  return drawn_start(truth, start, rng);
}

GnssInsRecording recording_of(const LoadedDrive& drive) {
  return {drive.tuning.imu, drive.tuning.ranges, {}, drive.tuning.start};
}

}  // namespace

Result<LoadedDrive> load_drive(const std::string& folder, std::uint64_t seed) {
  const std::filesystem::path at(folder);
  LoadedDrive drive;
  drive.name = at.has_filename() ? at.filename().string() : at.parent_path().filename().string();
  const std::string config = (at / "config.json").string();
  if (std::filesystem::exists(config)) {
    auto read = read_nav_config(config);
    if (!read) return read.error();
    drive.config = *std::move(read);
  } else {
    drive.config.truth_is_antenna = false;
  }
  NavFiles files;
  files.imu = {(at / "imu.txt").string()};
  files.ranges = (at / "ranges.txt").string();
  files.truth = (at / "truth.txt").string();
  auto loaded = load_nav_recording(files, drive.config);
  if (!loaded) return loaded.error();
  if (loaded->truth.states.size() < 2 || loaded->recording.imu.size() < 2)
    return Error{ErrorCode::invalid, "has too few states", folder};
  drive.truth = loaded->truth.states;
  // A reference without attitude gets its heading from the course; roll and pitch are unknown.
  drive.tuning.has_level = loaded->truth.has_attitude && drive.config.truth_is_true;
  drive.tuning.has_heading = loaded->truth.has_attitude;
  const auto reference = std::make_shared<const eval::NavReference>(std::move(loaded->truth));
  drive.tuning.truth = [reference](LogTime t) { return eval::reference_at(*reference, t); };
  drive.tuning.imu = std::move(loaded->recording.imu);
  drive.tuning.ranges = std::move(loaded->recording.ranges);
  drive.tuning.options = drive.config.filter;
  const LogTime first = std::max(drive.truth.front().time, drive.tuning.imu.front().time);
  const auto begin = drive.tuning.truth(first);
  if (!begin)
    return Error{ErrorCode::invalid, "the reference does not overlap the readings", folder};
  drive.tuning.start = random_start(*begin, seed);
  return drive;
}

SystemErrors system_errors(const LoadedDrive& drive, const GnssInsOptions& options) {
  const auto run = run_gnss_ins(recording_of(drive), options);
  const Eigen::Vector3d nan = Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
  if (!run) return {nan, nan, nan};
  Eigen::Matrix<double, 9, 1> squares = Eigen::Matrix<double, 9, 1>::Zero(), counts = squares;
  for (const GnssInsPoint& p : run->points) {
    const auto truth = drive.tuning.truth(p.nav.time);
    if (!truth) continue;
    const eval::NavError e = eval::nav_error(p.nav, *truth);
    Eigen::Matrix<double, 9, 1> square, known = Eigen::Matrix<double, 9, 1>::Ones();
    square << e.position_ned_m.cwiseAbs2(), e.velocity_ned_mps.cwiseAbs2(),
        (e.attitude_body_rad / kDegree).cwiseAbs2();
    known.segment<2>(6).setConstant(drive.tuning.has_level ? 1.0 : 0.0);
    const bool moves = truth->velocity_ned_mps.head<2>().norm() > 3.0;
    known[8] = drive.tuning.has_heading && (drive.tuning.has_level || moves) ? 1.0 : 0.0;
    squares += square.cwiseProduct(known);
    counts += known;
  }
  const Eigen::Matrix<double, 9, 1> rmse = squares.cwiseQuotient(counts).cwiseSqrt();
  return {rmse.head<3>(), rmse.segment<3>(3), rmse.tail<3>()};
}

Result<OutageReport> outages(const LoadedDrive& drive, const GnssInsOptions& options, int threads) {
  OutagePlan plan;
  plan.threads = threads;
  const LogTime begin = drive.tuning.start.nav.time;
  const LogTime end = std::min(
      {drive.tuning.imu.back().time, drive.tuning.ranges.back().time, drive.truth.back().time});
  const Duration settle = from_seconds(std::min(60.0, 0.3 * to_seconds(end - begin)));
  if (end - begin - settle < plan.durations.back())
    return Error{ErrorCode::invalid, "is too short for outages of 30 s", drive.name};
  plan.starts = outage_starts(begin + settle, end, plan.durations.back(), 10, drive.tuning.ranges);
  const auto truth = [&drive](LogTime t) {
    return drive.tuning.truth(t).value_or(drive.truth.back());
  };
  const auto run = [&](const OutageWindow& window) -> Result<NavTrajectory> {
    GnssInsRecording recording = recording_of(drive);
    recording.ranges = mask_satellites(recording.ranges, window, truth(window.begin).position);
    // Readings after the outage are not needed.
    while (!recording.imu.empty() && recording.imu.back().time > window.end)
      recording.imu.pop_back();
    const auto result = run_gnss_ins(recording, options);
    if (!result) return result.error();
    NavTrajectory track;
    for (const GnssInsPoint& p : result->points) track.push_back(p.nav);
    return track;
  };
  return run_outages(plan, run, truth);
}

}  // namespace wayfare::examples
