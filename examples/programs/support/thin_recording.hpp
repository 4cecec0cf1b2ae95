#pragma once

// A robot's log as a lesser sensor would have made it.

#include <cstddef>

#include <wayfare/sensors/recording.hpp>

#include "command_line.hpp"

namespace wayfare::examples {

struct Thinning {
  std::size_t every = 1;           ///< one scan of so many is kept …
  std::size_t beams = 1;           ///< … and of it one beam of so many …
  double max_range_m = 0.0;        ///< … farther ones as no returns; 0: as they are …
  double field_of_view_deg = 0.0;  ///< … those within half of it either side of ahead; 0: all
};

void add_thinning(CommandLine& app, Thinning& thinning);

void thin(Recording& recording, const Thinning& thinning);

}  // namespace wayfare::examples
