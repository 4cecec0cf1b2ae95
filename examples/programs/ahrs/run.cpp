#include "run.hpp"

#include <cstddef>

namespace wayfare::examples {
namespace {

template <class World>
AhrsRun run_in(const MargRecording& samples, const AhrsParameters& parameters,
               const std::function<void(double)>& progress) {
  Ahrs<World> ahrs(parameters);
  AhrsRun run;
  run.rows.reserve(samples.size());
  for (std::size_t i = 0; i < samples.size(); ++i) {
    AhrsRow row;
    row.status = ahrs.add(samples[i]);
    row.time = samples[i].time;
    row.ready = ahrs.ready();
    row.q_world_body = ahrs.q_world_body();
    row.sigma_rad = ahrs.world_covariance().diagonal().cwiseSqrt();
    row.bias_radps = ahrs.gyro_bias_radps();
    row.bias_sigma_radps = ahrs.gyro_bias_sigma_radps();
    row.delay_s = ahrs.magnetometer_delay_s();
    row.at_rest = ahrs.at_rest();
    run.rows.push_back(row);
    if (i % 4096 == 0) progress(static_cast<double>(i) / static_cast<double>(samples.size()));
  }
  run.report = ahrs.report();
  return run;
}

}  // namespace

AhrsRun run_ahrs(const MargRecording& samples, const AhrsParameters& parameters, bool enu,
                 const std::function<void(double)>& progress) {
  return enu ? run_in<frame::Enu>(samples, parameters, progress)
             : run_in<frame::Ned>(samples, parameters, progress);
}

}  // namespace wayfare::examples
