#include <wayfare/slam/robot_calibration.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <optional>
#include <utility>

#include "slam/robot_calibration/measurements.hpp"
#include "slam/robot_calibration/parameters.hpp"
#include "slam/robot_calibration/solve.hpp"
#include "slam/robot_calibration/start.hpp"

namespace wayfare {
namespace calibration {

std::string contradiction(const std::string& sensor, const std::string& base, double speed_ratio,
                          double turn_ratio) {
  const auto near = [](double ratio, double of) { return ratio > of / 2.0 && ratio < of * 2.0; };
  const auto both = [&](const std::string& what, double ratio) {
    char text[32];
    std::snprintf(text, sizeof text, "%.3g", ratio);
    return what + " of the " + sensor + " are " + text + " times those of the " + base;
  };
  if (std::isfinite(speed_ratio) && speed_ratio > 0.0 && !near(speed_ratio, 1.0)) {
    std::string why = both("distances", speed_ratio);
    if (near(speed_ratio, 1000.0) || near(speed_ratio, 0.001))
      return why + ": one of them is in millimetres";
    if (near(speed_ratio, 100.0) || near(speed_ratio, 0.01))
      return why + ": one of them is in centimetres";
    if (speed_ratio < 0.02 || speed_ratio > 50.0) return why;
    return why + ": a unit or a wheel radius is wrong, or they move independently";
  }
  if (!std::isfinite(turn_ratio)) return {};
  if (turn_ratio < -0.3)
    return both("turns", turn_ratio) +
           ": left and right are exchanged, or the sensor is mounted "
           "upside down";
  if (near(turn_ratio, 57.3) || near(turn_ratio, 1.0 / 57.3))
    return both("turns", turn_ratio) + ": one of them is in degrees";
  if (!near(turn_ratio, 1.0))
    return both("turns", turn_ratio) +
           ": the wheel base or a unit is wrong, or they do not "
           "belong together";
  return {};
}

namespace {

Error invalid(std::string why) { return {ErrorCode::invalid, std::move(why), "calibration"}; }

/// The gyro's angles as velocities without translation.
struct GyroRatio {
  double ratio = std::numeric_limits<double>::quiet_NaN();
  double delay_s = 0.0;
};
/// Robust slope of the gyro's angle over the base's, for the delay that fits best.
GyroRatio gyro_start(const BaseMotion& base, const std::vector<GyroTurned>& all,
                     const Wheels& wheels, double max_delay_s) {
  GyroRatio best;
  double least = std::numeric_limits<double>::infinity();
  constexpr int kFewestTurns = 10;
  constexpr double kTurns_rad_s = 0.15;  // more than unequal wheels make of a straight drive
  const auto try_delay = [&](double delay) {
    int turning = 0;
    double xy = 0.0, xx = 0.0, n = 0.0, sx = 0.0, sy = 0.0, yy = 0.0;
    for (const GyroTurned& g : all) {
      const double from = g.from_s - delay, to = g.to_s - delay;
      if (!base.covers(from, to)) continue;
      const double x = base.between(from, to, wheels).heading().radians() / (to - from);
      const double y = g.turn_rad / (to - from);
      turning += std::max(std::abs(x), std::abs(y)) > kTurns_rad_s ? 1 : 0;
      xy += x * y, xx += x * x, yy += y * y, sx += x, sy += y, n += 1.0;
    }
    if (turning < kFewestTurns) return;
    const double var = xx - sx * sx / std::max(n, 1.0);
    constexpr double kTurns = 1e-3;  // (rad/s)²
    if (n < 20 || !(var > kTurns * n)) return;
    const double slope = (xy - sx * sy / n) / var;
    const double cost = (yy - sy * sy / n - slope * slope * var) / n;
    if (cost < least) least = cost, best = {slope, delay};
  };
  for (double d = -max_delay_s; d <= max_delay_s + 1e-9; d += 0.02) try_delay(d);
  const double coarse = best.delay_s;
  for (double d = coarse - 0.016; d <= coarse + 0.017; d += 0.004) try_delay(d);
  return best;
}

/// Sensors with too few measurements are left out, and named.
constexpr std::size_t kFewest = 20;

class Setup {
 public:
  Setup(const Recording& recording, const Measurements& measured,
        const RobotCalibrationOptions& options)
      : r_(recording), m_(measured), o_(options) {}

  Result<Problem> problem(std::vector<std::string>& notes) {
    p_.measured = &m_;
    const bool wheels = m_.wheels.size() >= kFewest, laser = m_.laser.coarse.size() >= kFewest;
    const bool radar = m_.radar.size() >= kFewest;
    if (!wheels && !(laser && radar))
      return Error{ErrorCode::not_found,
                   "needs the wheels' distances and a moving laser or radar, or a laser and a "
                   "radar",
                   "calibration"};
    if (!laser && !radar)
      return Error{
          m_.laser.scans + m_.radar_frames > 0 ? ErrorCode::degenerate : ErrorCode::not_found,
          "hardly any motion of a laser or radar to compare the wheels with (" +
              std::to_string(m_.laser.coarse.size()) + " motions of the laser in " +
              std::to_string(m_.laser.scans) + " scans, " + std::to_string(m_.radar.size()) +
              " velocities of the radar in " + std::to_string(m_.radar_frames) + " frames)",
          "calibration"};
    p_.start.laser = r_.T_base_laser.raw(), p_.start.radar = r_.T_base_radar.raw();
    p_.start.wheels[2] = r_.wheel_base_m > 0.0 ? r_.wheel_base_m : 0.4;
    if (wheels) {
      p_.base = BaseMotion(m_.wheels, true, o_.largest_gap_s);
      p_.laser = laser;
      note(notes, "laser", laser, !r_.scans.empty());
    } else {
      p_.base = BaseMotion(steps_of(m_.laser.fine), false, 1.0);
      p_.start.radar = p_.start.laser.inverse() * p_.start.radar;
      p_.start.laser = SE2d();
      notes.emplace_back("no wheels: the base is the laser");
    }
    p_.radar = radar;
    note(notes, "radar", radar, !r_.radar.empty());
    if (auto ok = start_sensors(notes); !ok) return ok.error();
    return p_;
  }

 private:
  static std::vector<BaseStep> steps_of(const std::vector<LaserMotion>& motions) {
    std::vector<BaseStep> steps;
    for (const LaserMotion& m : motions)
      steps.push_back({m.from_s, m.to_s, m.T_from_to.log() / (m.to_s - m.from_s)});
    return steps;
  }
  static void note(std::vector<std::string>& notes, const char* name, bool used, bool present) {
    if (used) return;
    notes.push_back(std::string(name) +
                    (present ? ": too little motion found in its data" : ": no data"));
  }
  [[nodiscard]] const char* base_name() const { return p_.base.by_wheels() ? "wheels" : "laser"; }

  Result<void> start_sensors(std::vector<std::string>& notes) {
    if (p_.laser)
      if (auto ok = start("laser", velocities_of(m_.laser.fine), p_.start.laser,
                          p_.start.laser_delay_s, true, notes);
          !ok)
        return ok;
    if (p_.radar)
      if (auto ok = start("radar", velocities_of(m_.radar), p_.start.radar, p_.start.radar_delay_s,
                          !p_.laser, notes);
          !ok)
        return ok;
    return start_gyro(notes);
  }
  /// `sizes`: the wheels' scale follows from this sensor's speeds.
  Result<void> start(const char* name, const std::vector<SensorVelocity>& velocities,
                     SE2d& mounting, double& delay_s, bool sizes, std::vector<std::string>& notes) {
    const MountingStart found = find_start(p_.base, velocities, p_.start.wheels, o_.max_delay_s);
    if (!std::isfinite(found.cost))
      return Error{ErrorCode::degenerate,
                   std::string(name) + ": its measurements and those of the " + base_name() +
                       " hardly overlap in time",
                   "calibration"};
    const std::string why = contradiction(name, base_name(), found.speed_ratio, found.turn_ratio);
    if (!why.empty()) return invalid(why);
    constexpr double kFar_rad = 0.35;
    const double turned = (found.T_base_sensor.heading() - mounting.heading()).wrapped().radians();
    if (std::abs(turned) > kFar_rad)
      notes.push_back(std::string(name) + ": mounted at another angle than given, by " +
                      std::to_string(std::lround(Angle::radians(turned).degrees())) + " deg");
    mounting = SE2d(mounting.translation(), found.T_base_sensor.rotation());
    delay_s = found.delay_s;
    if (sizes && p_.base.by_wheels()) p_.start.wheels.head<2>() *= found.speed_ratio;
    return {};
  }
  Result<void> start_gyro(std::vector<std::string>& notes) {
    if (m_.gyro.size() < kFewest) {
      notes.emplace_back("gyro: no data");
      return {};
    }
    const GyroRatio g = gyro_start(p_.base, m_.gyro, p_.start.wheels, o_.max_delay_s);
    if (std::isfinite(g.ratio)) {
      const std::string why = contradiction("gyro", base_name(), 1.0, g.ratio);
      if (!why.empty()) return invalid(why);
      p_.start.gyro_delay_s = g.delay_s;
    }
    p_.gyro = true;
    return {};
  }

  const Recording& r_;
  const Measurements& m_;
  const RobotCalibrationOptions& o_;
  Problem p_;
};

}  // namespace
}  // namespace calibration

Result<RobotCalibration> calibrate_robot(const Recording& recording,
                                         const RobotCalibrationOptions& options,
                                         const SlamProgress& progress) {
  auto measured = calibration::measure(recording, options, progress);
  if (!measured) return measured.error();
  RobotCalibration result;
  result.notes = measured->notes;
  auto problem = calibration::Setup(recording, *measured, options).problem(result.notes);
  if (!problem) return problem.error();
  const auto solution = calibration::solve(*problem, options);
  if (!solution) return solution.error();
  result.sensors = solution->sensors;
  calibration::fill(result, *problem, *solution, recording, options);
  return result;
}

const CalibratedParameter* RobotCalibration::find(std::string_view name) const {
  const auto at = std::ranges::find(parameters, name, &CalibratedParameter::name);
  return at == parameters.end() ? nullptr : &*at;
}

std::vector<std::string> RobotCalibration::undetermined() const {
  std::vector<std::string> names;
  for (const CalibratedParameter& p : parameters)
    if (!p.determined) names.push_back(p.name);
  return names;
}

}  // namespace wayfare
