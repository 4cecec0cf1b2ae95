#pragma once

// The height of a walker by air pressure, alone or with a height by dead reckoning.

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include <wayfare/core/atmosphere.hpp>
#include <wayfare/core/time.hpp>
#include <wayfare/filter/sequential_update.hpp>
#include <wayfare/inertial/attitude.hpp>

namespace wayfare {

/// Noises of a BarometricHeight.
struct BarometricHeightParameters {
  double pressure_sigma_Pa = 2.0;  ///< white noise of a reading
  /// Random walk of the pressure at rest, Pa/√s: weather, ventilation, warming of the sensor.
  double pressure_drift_Pa = 0.3;
  /// Random walk of the height besides the rises passed to move(), m/√s: 0.3 for a walker on stairs
  /// whose rises are unknown.
  double height_walk_m = 0.0;
};

/// Kalman filter of the height and the pressure drift (as a height), both zero at the first
/// reading. Without readings it is the sum of the rises.
class BarometricHeight {
 public:
  /// At a height of zero, before the first reading.
  explicit BarometricHeight(const BarometricHeightParameters& parameters = {}) : p_(parameters) {}

  /// A rise by dead reckoning since the previous one, and its variance, which may be zero.
  void move(LogTime time, double rise_m, double variance_m2) {
    advance(time);
    height_m_ += rise_m;
    covariance_(0, 0) += variance_m2;
  }

  /// `missing`: not between 20 and 120 kPa. The first reading defines the reference pressure.
  UpdateStatus add(LogTime time, double pressure_Pa) {
    if (!(pressure_Pa > 20e3 && pressure_Pa < 120e3)) return report_.note(UpdateStatus::missing);
    if (last_ && time < *last_) return report_.note(UpdateStatus::late);
    advance(time);
    const double variance = square(metres(p_.pressure_sigma_Pa, pressure_Pa));
    if (!reference_Pa_) {
      reference_Pa_ = barometric_pressure_Pa(-height_m_, pressure_Pa);
      covariance_(1, 1) = variance;
    }
    by_pressure_m_ = barometric_height_m(pressure_Pa, *reference_Pa_);
    const double innovation = *by_pressure_m_ - height_m_ - drift_m_;
    const double expected = covariance_(0, 0) + 2.0 * covariance_(0, 1) + covariance_(1, 1);
    nis_ = square(innovation) / (expected + variance);
    std::array<double, 2> correction{};
    sequential_update(covariance_, correction, IndexedRow<double, 0, 1>{{1.0, 1.0}}, innovation,
                      variance);
    height_m_ += correction[0];
    drift_m_ += correction[1];
    return report_.note(UpdateStatus::used);
  }

  /// Above the start, m.
  [[nodiscard]] double height_m() const { return height_m_; }
  /// Standard deviation of the height, m.
  [[nodiscard]] double sigma_m() const { return std::sqrt(std::max(0.0, covariance_(0, 0))); }
  /// The height by the last reading alone.
  [[nodiscard]] std::optional<double> by_pressure_m() const { return by_pressure_m_; }
  /// Normalised innovation squared of the last reading, one degree of freedom.
  [[nodiscard]] double nis() const { return nis_; }
  /// Counts of readings by status.
  [[nodiscard]] const SensorReport& report() const { return report_; }

 private:
  static double square(double x) { return x * x; }
  /// The height of a small pressure difference, |dh/dp| = R·T/(g·p).
  static double metres(double difference_Pa, double pressure_Pa) {
    return detail::kAirGasConstant * detail::kAtmosphereTemperature_K / 9.80665 * difference_Pa /
           pressure_Pa;
  }

  void advance(LogTime time) {
    const double dt = last_ ? std::max(0.0, to_seconds(time - *last_)) : 0.0;
    last_ = last_ ? std::max(*last_, time) : time;
    covariance_(0, 0) += square(p_.height_walk_m) * dt;
    if (reference_Pa_)
      covariance_(1, 1) += square(metres(p_.pressure_drift_Pa, *reference_Pa_)) * dt;
  }

  BarometricHeightParameters p_;
  SymmetricMatrix<double, 2> covariance_;
  double height_m_ = 0.0, drift_m_ = 0.0, nis_ = 0.0;
  std::optional<double> reference_Pa_, by_pressure_m_;
  std::optional<LogTime> last_;
  SensorReport report_;
};

}  // namespace wayfare
