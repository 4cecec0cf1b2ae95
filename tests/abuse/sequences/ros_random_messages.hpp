#pragma once

// Random messages and times for nodes: mostly valid ones.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>

#include <wayfare/core/random.hpp>
#include <wayfare/core/time.hpp>
#include <wayfare/ros/convert.hpp>
#include <wayfare/ros/messages.hpp>

#include "abuse/abuse.hpp"

namespace wayfare::ros {

inline constexpr std::int64_t kSecond = 1'000'000'000;
inline const LogTime kStart = LogTime::from_nanoseconds(1000 * kSecond);

inline double any_number(Rng& rng) {
  constexpr double kNumbers[] = {0.0,          1.0,           -3.5,    tests::kNan, tests::kInf,
                                 tests::kHuge, -tests::kHuge, 1.7e308, 1e9,         tests::kTiny};
  return kNumbers[rng.below(std::size(kNumbers))];
}

/// A room, seen from a robot that stands in its middle.
inline LaserScan scan_message(LogTime time, Rng& rng) {
  LaserScan m;
  m.header = header_of(time, rng.below(40) == 0 ? "other" : "laser");
  m.angle_min = -2.0F, m.angle_max = 2.0F, m.angle_increment = 0.05F;
  m.range_min = 0.1F, m.range_max = 20.0F;
  for (int i = 0; i < 81; ++i) {
    const double a = -2.0 + 0.05 * i;
    const double wall = std::min(3.0 / std::abs(std::cos(a)), 2.0 / std::abs(std::sin(a) + 1e-9));
    m.ranges.push_back(static_cast<float>(wall + 0.01 * rng.uniform()));
  }
  if (rng.below(8) == 0) m.ranges[rng.below(81)] = static_cast<float>(any_number(rng));
  if (rng.below(20) == 0) m.angle_increment = static_cast<float>(any_number(rng));
  if (rng.below(20) == 0) m.ranges.clear();
  return m;
}

/// Mostly onwards; now and then the same, late, far or not set.
inline LogTime next_time(Rng& rng, LogTime& now) {
  switch (rng.below(25)) {
    case 0:
      return now;
    case 1:
      return now - Duration(static_cast<std::int64_t>(rng.below(3 * kSecond)));
    case 2:
      return LogTime();
    case 3:
      return rng.below(8) == 0 ? LogTime::from_nanoseconds((1LL << 32) * kSecond - 1) : now;
    default:
      return now += Duration(static_cast<std::int64_t>(rng.below(kSecond / 10)));
  }
}

/// Of a robot that hardly moves.
inline Odometry odometry_message(LogTime time, Rng& rng) {
  return message_of(
      OdometrySample{time, Transform2<frame::Odom, frame::Base>(
                               SE2d(0.01 * rng.uniform(), 0.0, Angle::degrees(rng.uniform())))},
      rng.below(30) == 0 ? "elsewhere" : "odom", "base_link");
}

}  // namespace wayfare::ros
