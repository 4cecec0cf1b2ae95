#pragma once

// Trials of the BROAD recordings (Laidig et al. 2021), if available.

#include <cmath>
#include <string>
#include <vector>

#include <wayfare/core/se3.hpp>
#include <wayfare/eval/trajectory_error.hpp>
#include <wayfare/io/text_file.hpp>
#include <wayfare/sensors/measurements.hpp>

namespace wayfare::testing {

struct BroadTrial {
  MargRecording samples;
  std::vector<SO3d> q_enu_body;  ///< the reference; identity if missing
  std::vector<bool> counts;      ///< moving, and with a reference
};

inline Result<BroadTrial> read_broad(const std::string& path) {
  const Result<io::FloatTable> table = io::read_float_table(path);
  if (!table) return table.error();
  if (table->columns != 14)
    return Error{ErrorCode::invalid, "does not have the 14 columns of a trial", path};
  BroadTrial trial;
  for (std::size_t i = 0; i < table->rows(); ++i) {
    const auto r = table->row(i);
    const auto vector = [&](std::size_t c) { return Eigen::Vector3d(r[c], r[c + 1], r[c + 2]); };
    // 285.714 Hz, every second sample.
    const auto time = LogTime::from_nanoseconds(static_cast<std::int64_t>(i) * 7'000'000);
    trial.samples.push_back({time, vector(0), vector(3), vector(6)});
    const bool known = std::isfinite(r[9] + r[10] + r[11] + r[12]);
    trial.q_enu_body.push_back(known ? SO3d(Eigen::Quaterniond(r[9], r[10], r[11], r[12]))
                                     : SO3d());
    trial.counts.push_back(known && r[13] > 0.5F);
  }
  return trial;
}

/// Root mean square over the samples that count.
template <class Estimator>
eval::AttitudeError broad_error(Estimator& estimator, const BroadTrial& trial) {
  const SO3d from_world = rotation_from_enu<typename Estimator::World, double>().inverse();
  eval::AttitudeRmse rmse;
  for (std::size_t i = 0; i < trial.samples.size(); ++i) {
    estimator.add(trial.samples[i]);
    if (!trial.counts[i] || !estimator.ready()) continue;
    const SO3d q = from_world * estimator.q_world_body().template cast<double>();
    rmse.add(eval::attitude_error(q, trial.q_enu_body[i]));
  }
  return rmse.value();
}

}  // namespace wayfare::testing
