#include "pedestrian_slam/walker_options.hpp"

namespace wayfare::examples {

void WalkerOptions::add_options(CommandLine& app) {
  length.add_options(app);
  app.add_option("--step", step_m,
                 "length of every step, m: the same as --length constant --factor")
      .positive()
      .excludes("--length")
      .excludes("--factor")
      .excludes("--calibration");
  app.add_flag("--no-magnetometer", no_magnetometer, "no heading by it where the map gives none");
  app.add_flag("--no-steps", no_steps, "use only rotation and tilt of the unit");
  app.add_flag("--no-feedback", no_feedback, "do not correct steps and heading by the map");
  app.add_flag("--no-heading", no_heading,
               "let the map correct the steps but not the unit's heading");
}

Result<void> WalkerOptions::apply(PedestrianSlamOptions& o) const {
  const auto model = length.model();
  if (!model) return model.error();
  o.pedestrian.length = *model;
  if (step_m > 0) o.pedestrian.length = ConstantStep{step_m};
  o.pedestrian.ahrs.use_magnetometer = !no_magnetometer;
  o.steps = !no_steps;
  o.feedback = !no_feedback;
  o.heading = !no_heading;
  return {};
}

}  // namespace wayfare::examples
