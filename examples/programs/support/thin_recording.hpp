#pragma once

// A robot's log as a lesser sensor would have recorded it.

#include <cstddef>

#include <wayfare/sensors/recording.hpp>

#include "command_line.hpp"

namespace wayfare::examples {

struct Thinning {
  std::size_t every = 1;           ///< keeps each every-th scan …
  std::size_t beams = 1;           ///< … and each beams-th beam of it
  double max_range_m = 0.0;        ///< farther ranges become missing returns; 0: no limit
  double field_of_view_deg = 0.0;  ///< of the beams kept, symmetric about ahead; 0: all
};

void add_thinning(CommandLine& app, Thinning& thinning);

void thin(Recording& recording, const Thinning& thinning);

}  // namespace wayfare::examples
