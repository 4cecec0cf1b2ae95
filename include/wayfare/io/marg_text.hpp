#pragma once

// Recordings of nine-axis units as columns: text with named columns (columns.hpp), or a binary
// table (float_table.hpp) with column names from the caller. Plain or gzip.

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/core/so3.hpp>
#include <wayfare/eval/attitude_error.hpp>
#include <wayfare/inertial/attitude.hpp>
#include <wayfare/io/columns.hpp>
#include <wayfare/io/text_file.hpp>
#include <wayfare/sensors/imu.hpp>

namespace wayfare::io {

/// The reference attitude of a sample, in the recording's world frame.
struct MargReference {
  SO3d q_world_body;
  bool known = false;  ///< false where its fields are empty or NaN
};

struct MargFile {
  MargRecording samples;                 ///< in the order of the file; NaN: not measured
  std::vector<MargReference> reference;  ///< of each sample; empty without such columns
  std::vector<bool> moving;              ///< of each sample: column `moving`; true without it
  bool has_magnetometer = false;
  Problems problems;
};

struct MargFormat {
  /// The columns gx gy gz, ax ay az (both needed), mx my mz (uT, nT, mT, T or G), qw qx qy qz,
  /// moving (0 or 1), and the time.
  ColumnFormat columns;
  /// Sampling period of a table without a time column, s; zero where it has one.
  double period_s = 0.0;
};

/// Errors: the file cannot be read, a column is missing or has an unknown unit, or no line is
/// usable; for a binary table also a wrong number of names, or a period that is negative or not
/// finite.
[[nodiscard]] Result<MargFile> read_marg(const std::string& path, const MargFormat& format = {});
[[nodiscard]] Result<MargFile> parse_marg(std::string_view bytes, const std::string& source,
                                          const MargFormat& format = {});

/// Text with named columns; without the magnetometer's columns where no sample has a field.
[[nodiscard]] std::string format_marg(std::span<const MargSample> samples);
[[nodiscard]] inline Result<void> write_marg(const std::string& path,
                                             std::span<const MargSample> samples,
                                             const WriteOptions& options = {}) {
  return write_file(path, format_marg(samples), options);
}

/// Root mean squares of an estimator's errors over the moving samples with a reference.
template <AttitudeEstimator Estimator>
[[nodiscard]] eval::AttitudeError attitude_rmse(Estimator& estimator, const MargFile& file) {
  eval::AttitudeRmse rmse;
  for (std::size_t i = 0; i < file.samples.size(); ++i) {
    estimator.add(file.samples[i]);
    if (!estimator.ready() || !file.moving[i] || !file.reference[i].known) continue;
    rmse.add(eval::attitude_error(estimator.q_world_body().template cast<double>(),
                                  file.reference[i].q_world_body));
  }
  return rmse.value();
}

}  // namespace wayfare::io
