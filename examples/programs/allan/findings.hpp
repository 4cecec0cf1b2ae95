#pragma once

// What a record at rest says of its unit, in the units data sheets use.

#include <string>
#include <vector>

#include <wayfare/eval/table.hpp>
#include <wayfare/inertial/imu_noise.hpp>
#include <wayfare/io/report.hpp>

#include "record.hpp"

namespace wayfare::examples {

struct AxisFit {
  AllanCurve curve, hadamard;
  AllanFit allan;
  GaussMarkovFit slow;
};
using UnitFit = std::vector<AxisFit>;  ///< gyro x y z, accelerometer x y z

[[nodiscard]] UnitFit fit_unit(const RestRecord& record);

/// White noise from the Allan deviation, biases from the autocorrelation; where that shows no
/// process, from the bias instability. What rest cannot show (scale factors) keeps its default.
[[nodiscard]] ImuNoise nominal_noise(const UnitFit& fit);

[[nodiscard]] eval::Table allan_table(const UnitFit& fit);
[[nodiscard]] eval::Table gauss_markov_table(const UnitFit& fit);
/// How far the axes are apart, and what was not seen.
[[nodiscard]] std::vector<std::string> remarks(const UnitFit& fit);
/// Deviation over averaging time, both as decimal logarithms: of gyro and of accelerometer.
[[nodiscard]] std::vector<io::Plot> allan_plots(const UnitFit& fit);

}  // namespace wayfare::examples
