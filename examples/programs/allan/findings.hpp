#pragma once

// Noise parameters of a unit from a recording at rest, in the units of data sheets.

#include <string>
#include <vector>

#include <wayfare/eval/table.hpp>
#include <wayfare/inertial/imu_noise.hpp>
#include <wayfare/io/report.hpp>

namespace wayfare::examples {

/// Statistics of one axis.
struct AxisRecord {
  AllanRecorder allan;
  AutocorrelationRecorder slow;
};

/// A record of a unit at rest, taken in reading by reading.
struct RestRecord {
  double rate_hz = 0.0;
  std::size_t readings = 0;
  std::vector<AxisRecord> axes;  ///< gyro x y z in rad/s, accelerometer x y z in m/s²
  [[nodiscard]] double length_s() const { return static_cast<double>(readings) / rate_hz; }
};

struct AxisFit {
  AllanCurve curve, hadamard;
  AllanFit allan;
  GaussMarkovFit slow;
};
using UnitFit = std::vector<AxisFit>;  ///< gyro x y z, accelerometer x y z

[[nodiscard]] UnitFit fit_unit(const RestRecord& record);

/// White noise from the Allan deviation, biases from the autocorrelation or, if no process is
/// found, from the bias instability. Scale factors are not observable at rest and keep their
/// default.
[[nodiscard]] ImuNoise nominal_noise(const UnitFit& fit);

[[nodiscard]] eval::Table allan_table(const UnitFit& fit);
[[nodiscard]] eval::Table gauss_markov_table(const UnitFit& fit);
/// Differences between the axes.
[[nodiscard]] std::vector<std::string> remarks(const UnitFit& fit);
/// Deviation over averaging time, both as decimal logarithms: gyro and accelerometer.
[[nodiscard]] std::vector<io::Plot> allan_plots(const UnitFit& fit);

}  // namespace wayfare::examples
