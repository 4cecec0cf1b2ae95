#pragma once

#include <cstddef>

#include <wayfare/eval/attitude_error.hpp>
#include <wayfare/inertial/attitude.hpp>
#include <wayfare/io/marg_text.hpp>

namespace wayfare::examples {

/// Root mean squares over the moving samples with a reference.
template <AttitudeEstimator Estimator>
eval::AttitudeError attitude_rmse(Estimator& estimator, const io::MargFile& file) {
  eval::AttitudeRmse rmse;
  for (std::size_t i = 0; i < file.samples.size(); ++i) {
    estimator.add(file.samples[i]);
    if (!estimator.ready() || !file.moving[i] || !file.reference[i].known) continue;
    rmse.add(eval::attitude_error(estimator.q_world_body().template cast<double>(),
                                  file.reference[i].q_world_body));
  }
  return rmse.value();
}

}  // namespace wayfare::examples
