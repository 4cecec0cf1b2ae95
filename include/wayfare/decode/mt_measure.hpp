#pragma once

// From what Xsens devices say to the library's measurements.

#include <optional>

#include <wayfare/core/time.hpp>
#include <wayfare/decode/awinda.hpp>
#include <wayfare/decode/mt_sample.hpp>
#include <wayfare/sensors/imu.hpp>
#include <wayfare/sensors/marg.hpp>

namespace wayfare::decode {

/// Rate and acceleration; nothing where one of them is missing.
[[nodiscard]] inline std::optional<ImuSample> to_imu_sample(const MtSample& sample, LogTime time) {
  if (!sample.rate_radps || !sample.acceleration_mps2) return std::nullopt;
  return ImuSample{time, *sample.rate_radps, *sample.acceleration_mps2};
}

/// Whatever of the nine axes is there. `earth_field_uT` is the strength of the Earth's field where
/// the device's magnetometer was calibrated, which it calls 1.
[[nodiscard]] inline MargSample to_marg_sample(const MtSample& sample, LogTime time,
                                               double earth_field_uT = 49.0) {
  MargSample marg;
  marg.time = time;
  if (sample.rate_radps) marg.angular_rate_radps = *sample.rate_radps;
  if (sample.acceleration_mps2) marg.specific_force_mps2 = *sample.acceleration_mps2;
  if (sample.magnetic_field_au) marg.magnetic_field_uT = earth_field_uT * *sample.magnetic_field_au;
  return marg;
}

/// A tracker's motion as a nine-axis sample.
[[nodiscard]] inline MargSample to_marg_sample(const AwindaMotion& motion, LogTime time,
                                               double earth_field_uT = 49.0) {
  MargSample marg;
  marg.time = time;
  marg.angular_rate_radps = motion.rate_radps;
  marg.specific_force_mps2 = motion.acceleration_mps2;
  marg.magnetic_field_uT = earth_field_uT * motion.field_au;
  return marg;
}

/// A counter that comes round, as one that does not: SampleTimeFine at 2³² or at 864 000 000,
/// PacketCounter at 65 536, frames at 2³². Steps back by less than half a round go back.
class RoundCounter {
 public:
  explicit RoundCounter(std::uint64_t round) : round_(static_cast<std::int64_t>(round)) {}

  [[nodiscard]] std::int64_t at(std::uint32_t count) {
    std::int64_t step = (static_cast<std::int64_t>(count) - total_) % round_;
    if (step < 0) step += round_;
    if (begun_ && step > round_ / 2) step -= round_;
    begun_ = true;
    return total_ += step;
  }

 private:
  std::int64_t round_, total_ = 0;
  bool begun_ = false;
};

}  // namespace wayfare::decode
