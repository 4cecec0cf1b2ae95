#pragma once

#include <cstdint>

#include <wayfare/inertial/attitude.hpp>

namespace wayfare {

/// What became of one sensor's readings.
struct SensorReport {
  std::uint64_t used = 0;
  std::uint64_t waiting = 0;
  std::uint64_t missing = 0;
  std::uint64_t late = 0;
  std::uint64_t saturated = 0;
  std::uint64_t disturbed = 0;

  /// Counts `intake` and passes it on.
  Intake note(Intake intake) {
    switch (intake) {
      case Intake::used:
        ++used;
        break;
      case Intake::waiting:
        ++waiting;
        break;
      case Intake::missing:
        ++missing;
        break;
      case Intake::late:
        ++late;
        break;
      case Intake::saturated:
        ++saturated;
        break;
      case Intake::disturbed:
        ++disturbed;
        break;
    }
    return intake;
  }
};

/// What an attitude filter met on its way.
struct AhrsReport {
  SensorReport gyro;
  SensorReport accelerometer;
  SensorReport magnetometer;
  SensorReport outside;  ///< headings told from outside
  std::uint64_t restarts = 0;        ///< after a gap of the gyro, or its clock set back
  std::uint64_t levelled_anew = 0;   ///< the attitude did not fit gravity any more
  std::uint64_t headings_taken = 0;  ///< the heading did not fit the field, or what was told, any more
};

/// Squares of innovations over their variances; NaN before the first.
template <class T>
struct AhrsNis {
  T velocity_east;
  T velocity_north;
  T heading;
  T outside;  ///< of a heading told from outside
};

}  // namespace wayfare
