#include <wayfare/nav/check_drive.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <numbers>

#include "nav/check_drive/axes_fit.hpp"
#include "nav/check_drive/gnss_track.hpp"
#include "nav/check_drive/time_fit.hpp"
#include "nav/check_drive/unit_means.hpp"

namespace wayfare {
namespace {

using namespace nav;
using Cause = DriveFinding::Cause;
using Eigen::Vector3d;

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kGravity_mps2 = 9.80665;

std::string text(const char* format, ...) {
  char buffer[400];
  std::va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(buffer, sizeof buffer, format, arguments);
  va_end(arguments);
  return buffer;
}

/// "[180.0, 0.0, -90.0]"
std::string angles(const SO3d& q) {
  const Vector3d a = roll_pitch_yaw_rad(q) / kDegree;
  return text("[%.1f, %.1f, %.1f]", a.x(), a.y(), a.z());
}

/// "x", "x and z"
std::string axes_of(const Vector3d& sign) {
  std::string names;
  for (int i = 0; i < 3; ++i)
    if (sign[i] < 0.0) names += std::string(names.empty() ? "" : " and ") + "xyz"[i];
  return names;
}

std::string list(const Vector3d& v) { return text("[%.6g, %.6g, %.6g]", v.x(), v.y(), v.z()); }

struct Unit {
  double size;  ///< of what is read where 1 is right
  const char* name;
};

class Checker {
 public:
  Checker(const GnssInsRecording& recording, const GnssInsOptions& options)
      : recording_(recording),
        options_(options),
        origin_(recording.imu.front().time),
        unit_(recording.imu, origin_, options.imu_time_offset_s),
        track_(gnss_track(recording, origin_)) {}

  DriveCheck check() {
    if (unit_.empty()) return {};
    check_receiver();
    check_force_size();
    check_time();
    const auto pairs = pairs_at(track_, unit_, offset_s_);
    const auto force = fit_force(pairs, track_.interval_spacing_s);
    if (!result_.estimate.imu_time_offset_s || !force || !moves(*force)) {
      check_level();
    } else {
      check_axes(*force, pairs);
    }
    return std::move(result_);
  }

 private:
  void find(Cause cause, std::string what, std::string option) {
    result_.findings.push_back({cause, std::move(what), std::move(option)});
  }

  static bool moves(const ForceFit& fit) {
    return fit_mounting(fit, Vector3d::Ones()).response > 6.0 ||
           fit_mounting(fit, -Vector3d::Ones()).response > 6.0;
  }

  /// By the receiver, and by the unit: no turns.
  [[nodiscard]] bool stands_still() const {
    if (track_.extent_m > std::max(3.0, 6.0 * track_.position_sigma_m)) return false;
    if (track_.fast_mps > std::max(0.5, 4.0 * track_.velocity_sigma_mps)) return false;
    std::vector<double> rates;
    const auto mean = unit_.over(unit_.begin_s(), unit_.end_s());
    for (double t = unit_.begin_s(); mean && t + 1.0 <= unit_.end_s(); t += 1.0)
      if (const auto one = unit_.over(t, t + 1.0))
        rates.push_back((one->rate_radps - mean->rate_radps).norm());
    return rates.empty() || quantile(rates, 0.95) < 0.05;
  }

  void check_receiver() {
    const auto& p = track_.positions;
    if (p.empty()) {
      if (!recording_.ranges.empty() || !recording_.fixes.empty())
        find(Cause::no_position,
             text("none of %zu epochs gives a position", recording_.ranges.size()),
             "satellites: at least four per epoch (--obs and --nav of the same day, "
             "elevation_mask_deg, min_cn0_dbhz)");
      return;
    }
    if (p.back().time_s < unit_.begin_s() || p.front().time_s > unit_.end_s())
      find(Cause::no_overlap,
           text("the inertial samples are from %.1f to %.1f s, the positions from %.1f to %.1f s",
                unit_.begin_s(), unit_.end_s(), p.front().time_s, p.back().time_s),
           text("imu_time_offset_s (now %g), --imu-tags or --imu-clock",
                options_.imu_time_offset_s));
    if (10 * track_.with_velocity < p.size())
      find(Cause::no_velocity,
           text("%zu of %zu positions have a velocity: %s", track_.with_velocity, p.size(),
                recording_.ranges.empty() ? "the fixes have none" : "the ranges have no Doppler"),
           recording_.ranges.empty() ? "fixes with velocities, or \"start\" in the description"
                                     : "RINEX observations D1C (the receiver's raw Doppler), or "
                                       "\"start\" in the description");
    if (stands_still())
      find(Cause::at_rest,
           text("the vehicle does not move (its positions are within %.1f m, their σ is %.1f m): "
                "no heading",
                track_.extent_m, track_.position_sigma_m),
           "\"start\" with the heading in the description, or a recording in motion");
  }

  /// Median over windows of a second.
  void check_force_size() {
    std::vector<double> sizes, rates;
    for (double t = unit_.begin_s(); t + 1.0 <= unit_.end_s(); t += 1.0) {
      const auto mean = unit_.over(t, t + 1.0);
      if (!mean) continue;
      sizes.push_back(mean->force_mps2.norm()), rates.push_back(mean->rate_radps.norm());
      mean_force_ += mean->force_mps2;
    }
    if (sizes.empty()) return;
    const double size = result_.estimate.force_size_mps2 = upper_median_of(sizes);
    if (*std::max_element(rates.begin(), rates.end()) < 1e-9)
      find(Cause::silent_gyro, "the angular rate is always zero", "columns gx gy gz of --imu");
    if (std::abs(size / kGravity_mps2 - 1.0) < 0.05) return;
    static constexpr std::array kUnits = {
        Unit{1.0, "g read as m/s\u00b2"},
        Unit{kGravity_mps2 * kGravity_mps2, "m/s\u00b2 read as g"},
        Unit{1000.0, "mg read as m/s\u00b2"},
        Unit{100.0 * kGravity_mps2, "cm/s\u00b2 read as m/s\u00b2"},
        Unit{1000.0 * kGravity_mps2, "mm/s\u00b2 read as m/s\u00b2, or mg read as g"},
        Unit{0.001 * kGravity_mps2, "mg read as g or as m/s\u00b2"}};
    for (const Unit& u : kUnits) {
      if (std::abs(size / u.size - 1.0) > 0.05) continue;
      scale_force(kGravity_mps2 / u.size);
      return find(
          Cause::force_unit,
          text("the specific force is %.4g m/s\u00b2 (median) in place of 9.81: %s", size, u.name),
          text("columns ax_g or ax_mps2 of imu, or accel_factor %.6g", kGravity_mps2 / u.size));
    }
    if (size < 2.5)
      return find(Cause::no_gravity,
                  text("the specific force is %.3g m/s\u00b2 (median) in place of 9.81: gravity is "
                       "missing (\"linear acceleration\" of a phone?)",
                       size),
                  "log the raw accelerometer");
    scale_force(kGravity_mps2 / size);
    find(Cause::force_size,
         text("the specific force is %.4g m/s\u00b2 (median) in place of 9.81", size),
         text("unit of columns ax ay az, or accel_factor %.6g", kGravity_mps2 / size));
  }
  void scale_force(double factor) { result_.estimate.accel_factor.setConstant(factor); }

  void check_time() {
    const auto fit = TimeSearch(track_, unit_).find();
    if (!fit) return;
    offset_s_ = fit->offset_s;
    result_.estimate.imu_time_offset_s = options_.imu_time_offset_s + fit->offset_s;
    result_.estimate.time_offset_sigma_s = fit->sigma_s;
    if (std::abs(fit->offset_s) < kTimeLimit_s + 3.0 * fit->sigma_s ||
        fit->score < fit->score_at_zero + 12.0 || fit->score < fit->next_score + 8.0)
      return;
    std::string likely =
        fit->offset_s > 0.0 ? "the unit's times are early" : "the unit's times are late";
    for (const auto& [seconds, why] :
         {std::pair{18, "UTC for GPS time"}, {19, "TAI for GPS time"}, {37, "UTC for TAI"}})
      if (std::abs(std::abs(fit->offset_s) - seconds) < 0.5)
        likely += text(" by the %d s of %s", seconds, why);
    find(Cause::time_offset,
         text("%s: accelerations and turns agree with the receiver's at %+.2f \u00b1 %.2f s",
              likely.c_str(), fit->offset_s, fit->sigma_s),
         text("imu_time_offset_s %.3f (now %.3f)", *result_.estimate.imu_time_offset_s,
              options_.imu_time_offset_s));
  }

  /// Without accelerations gravity's direction alone.
  void check_level() {
    if (!(mean_force_.norm() > 0.0) || result_.estimate.force_size_mps2 < 0.5) return;
    const Vector3d down = -mean_force_.normalized();
    result_.estimate.level = down;
    const Vector3d configured = options_.q_body_imu * down;
    const double tilt = std::acos(std::clamp(configured.z(), -1.0, 1.0));
    if (tilt < kTiltLimit) return;
    const Vector3d axis = tilt > 3.1 ? Vector3d::UnitX() : configured.cross(Vector3d::UnitZ());
    const SO3d level = SO3d::exp(tilt * axis.normalized()) * options_.q_body_imu;
    find(Cause::mounting,
         text("%s: gravity is %.0f\u00b0 from the configured vertical",
              tilt > 2.6 ? "the unit is upside down, or the specific force has the wrong sign"
                         : "the unit is tilted",
              tilt / kDegree),
         "mounting_deg " + angles(level) + ", its heading as configured");
  }

  struct Hypothesis {
    Vector3d force_sign;
    MountingFit mounting;
    GyroFit gyros;
    Vector3d rate_sign = Vector3d::Ones();  ///< −1 where the gain is surely negative
    double cost = 0.0;
  };

  [[nodiscard]] Hypothesis hypothesis(const Vector3d& sign, const ForceFit& force,
                                      const std::vector<Pair>& pairs) const {
    Hypothesis h{sign, fit_mounting(force, sign), {}};
    h.gyros = fit_gyros(pairs, unit_, offset_s_, h.mounting, sign,
                        result_.estimate.accel_factor.x(), track_.interval_spacing_s);
    for (int i = 0; i < 3; ++i)
      if (is_negative(h.gyros, i)) h.rate_sign[i] = -1.0;
    const double turned = (options_.q_body_imu.inverse() * h.mounting.q_body_imu).log().norm();
    // A sign costs as much as a mounting that is off by some 40°.
    h.cost = turned / kDegree + 40.0 * static_cast<double>((h.rate_sign.array() < 0.0).count());
    return h;
  }

  void check_axes(const ForceFit& force, const std::vector<Pair>& pairs) {
    Hypothesis best = hypothesis(Vector3d::Ones(), force, pairs);
    if (best.mounting.mirrored) {
      best.cost = 1e9;
      for (const Vector3d& sign :
           {Vector3d(-1, 1, 1), Vector3d(1, -1, 1), Vector3d(1, 1, -1), Vector3d(-1, -1, -1)})
        if (Hypothesis h = hypothesis(sign, force, pairs); h.cost < best.cost) best = h;
    }
    DriveEstimate& e = result_.estimate;
    e.accel_factor = e.accel_factor.cwiseProduct(best.force_sign);
    e.q_body_imu = best.mounting.q_body_imu;
    e.mounting_sigma_rad = best.mounting.heading_sigma_rad;
    e.level = best.mounting.q_body_imu.inverse() * Vector3d::UnitZ();
    report_signs(best);
    report_rate_unit(best.gyros);
    report_mounting();
  }

  void report_signs(const Hypothesis& h) {
    DriveEstimate& e = result_.estimate;
    e.gyro_factor = e.gyro_factor.cwiseProduct(h.rate_sign);
    const bool force = h.force_sign.minCoeff() < 0.0, rate = h.rate_sign.minCoeff() < 0.0;
    const std::string force_axes = axes_of(h.force_sign), rate_axes = axes_of(h.rate_sign);
    const auto option = [](const char* name, const Vector3d& factor) {
      return std::string(name) + " " + list(factor);
    };
    if (force && h.force_sign == h.rate_sign) {
      find(Cause::axis_sign,
           "axis " + force_axes + " of the unit has the wrong sign: its axes are left-handed",
           option("accel_factor", e.accel_factor) + ", " + option("gyro_factor", e.gyro_factor));
      return;
    }
    if (force)
      find(Cause::force_sign,
           "accelerometer axis " + force_axes +
               " has the wrong sign: accelerations along and across the course and gravity are "
               "left-handed",
           option("accel_factor", e.accel_factor));
    if (rate) {
      std::string gains;
      for (int i = 0; i < 3; ++i)
        if (h.rate_sign[i] < 0.0)
          gains += text(" %.2f \u00b1 %.2f", h.gyros.gain[i], h.gyros.sigma[i]);
      find(Cause::rate_sign,
           "gyro axis " + rate_axes + " has the wrong sign: true over measured rate is" + gains,
           option("gyro_factor", e.gyro_factor));
    }
  }

  /// Whether the gain of an axis is negative and not positive, both of the size of the common gain:
  /// by the ratio of their likelihoods.
  static bool is_negative(const GyroFit& g, int axis) {
    constexpr double kLogRatio = 20.0;
    const double gain = g.gain[axis], sigma = g.sigma[axis];
    return gain < -2.0 * sigma && -2.0 * gain * g.common().first > kLogRatio * sigma * sigma;
  }

  void report_rate_unit(const GyroFit& g) {
    const auto [gain, sigma] = g.common();
    if (!(sigma < 0.1 * gain) || (gain > 0.7 && gain < 1.4)) return;
    DriveEstimate& e = result_.estimate;
    const auto near = [gain = gain](double factor) {
      return gain > 0.7 * factor && gain < 1.4 * factor;
    };
    const char* unit = near(kDegree)         ? ": degrees per second read as rad/s"
                       : near(1.0 / kDegree) ? ": rad/s read as degrees per second"
                                             : "";
    const double factor = near(kDegree) ? kDegree : near(1.0 / kDegree) ? 1.0 / kDegree : gain;
    e.gyro_factor *= factor;
    find(*unit != '\0' ? Cause::rate_unit : Cause::rate_size,
         text("the course turns %.4g \u00b1 %.2g times as fast as the gyros read%s", gain, sigma,
              unit),
         "columns gx_degps or gx_radps of imu, or gyro_factor " + list(e.gyro_factor));
  }

  void report_mounting() {
    const DriveEstimate& e = result_.estimate;
    const Vector3d configured_down = options_.q_body_imu.inverse() * Vector3d::UnitZ();
    const double tilt = std::acos(std::clamp(configured_down.dot(*e.level), -1.0, 1.0));
    const double turned = (options_.q_body_imu.inverse() * *e.q_body_imu).log().norm();
    const bool surely =
        e.mounting_sigma_rad < 0.1 && turned > std::max(kHeadingLimit, 5.0 * e.mounting_sigma_rad);
    if (tilt < kTiltLimit && !surely) return;
    find(Cause::mounting,
         text("the unit is mounted %.0f\u00b0 from the configured mounting%s: gravity and the "
              "accelerations along the course give %s \u00b1 %.1f\u00b0",
              turned / kDegree, tilt > 2.6 ? ", upside down" : "", angles(*e.q_body_imu).c_str(),
              e.mounting_sigma_rad / kDegree),
         "mounting_deg " + angles(*e.q_body_imu) + " (now " + angles(options_.q_body_imu) + ")");
  }

  static constexpr double kTiltLimit = 20.0 * kDegree, kHeadingLimit = 20.0 * kDegree;
  /// Fixes of a phone are filtered, and lag by as much.
  static constexpr double kTimeLimit_s = 0.3;

  const GnssInsRecording& recording_;
  const GnssInsOptions& options_;
  LogTime origin_;
  UnitMeans unit_;
  GnssTrack track_;
  double offset_s_ = 0.0;
  Vector3d mean_force_ = Vector3d::Zero();
  DriveCheck result_;
};

}  // namespace

DriveCheck check_drive(const GnssInsRecording& recording, const GnssInsOptions& options) {
  if (recording.imu.empty()) return {};
  return Checker(recording, options).check();
}

}  // namespace wayfare
