#pragma once

// What an Awinda station sends of a tracker that moves as a unit's samples say.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include <Eigen/Geometry>

#include <wayfare/sensors/measurements.hpp>
#include "decode/xbus_streams.hpp"

namespace wayfare::testing {

inline constexpr std::uint32_t kTracker = 0x00B42A11;

/// The station's configuration: 100 frames a second, one tracker.
inline decode::Stream awinda_configuration() {
  decode::Stream data(118);
  decode::store_be<std::uint32_t>(0x00200001, data.data());
  decode::store_be<std::uint16_t>(1152, &data[4]);
  decode::store_be<std::uint16_t>(1, &data[96]);
  decode::store_be(kTracker, &data[98]);
  return decode::message(decode::XbusId::configuration, data);
}

/// Snapshots of the integrals of rate and specific force, one for each sample.
class AwindaTracker {
 public:
  explicit AwindaTracker(std::uint32_t device = kTracker) : device_(device) {}

  decode::Stream next(const MargSample& s, double period_s = 0.01) {
    const Eigen::Vector3d turn = period_s * s.angular_rate_radps;
    const Eigen::Vector3d gain = period_s * s.specific_force_mps2;
    velocity_mps_ += q_ * (gain + 0.5 * turn.cross(gain));
    q_ = (q_ * SO3d::exp(turn).quaternion()).normalized();
    std::array<double, 4> q = {q_.w(), q_.x(), q_.y(), q_.z()};
    const auto largest = static_cast<std::size_t>(
        std::max_element(q.begin(), q.end(),
                         [](double a, double b) { return std::abs(a) < std::abs(b); }) -
        q.begin());
    const double sign = q[largest] < 0.0 ? -1.0 : 1.0;
    decode::Stream packet;
    decode::put<std::uint16_t>(packet, 0xC810);
    decode::put<std::uint8_t>(packet, 46);
    decode::put(packet, device_);
    decode::put(packet, frame_++);
    for (std::size_t i = 0; i < 3; ++i)
      decode::put(packet,
                  static_cast<std::int32_t>(std::lround(sign * q[(largest + 1 + i) % 4] * 0x1p31)));
    for (int i = 0; i < 3; ++i)
      decode::put(packet, static_cast<std::int32_t>(std::lround(velocity_mps_[i] * 0x1p16)));
    for (const double field : {0.4, 0.0, -0.9})
      decode::put(packet, static_cast<std::int16_t>(std::lround(4096.0 * field)));
    decode::put<std::uint32_t>(packet, 0);
    decode::put(packet, static_cast<std::uint16_t>(largest << 11U));
    decode::put<std::uint16_t>(packet, 0);
    return decode::message(decode::XbusId::mt_data2, packet);
  }

 private:
  std::uint32_t device_, frame_ = 0;
  Eigen::Quaterniond q_ = Eigen::Quaterniond::Identity();
  Eigen::Vector3d velocity_mps_ = Eigen::Vector3d::Zero();
};

}  // namespace wayfare::testing
