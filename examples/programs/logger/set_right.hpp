#pragma once

#include <string>
#include <vector>

#include <wayfare/core/result.hpp>

namespace wayfare::examples {

/// Files of one run of a logger, whose stamps are set right.
struct SetRight {
  std::vector<std::string> files;
  std::string out;  ///< folder of the copies; empty: the readings are only shown
  int reading = 0;  ///< number of the reading of the clock that is right; 0: the last one
};

/// Prints the readings of the computer's clock and writes the copies. Errors: files of several
/// runs, no such reading; what read_clock and move_stamps refuse.
Result<void> set_right(const SetRight& what);

}  // namespace wayfare::examples
