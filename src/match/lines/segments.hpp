#pragma once

// Line segments of a scan by split and merge (Nguyen et al. 2005, section II).

#include <cstddef>
#include <vector>

#include <wayfare/match/lines.hpp>

#include "match/lines/beams.hpp"

namespace wayfare::lines {

struct Segment {
  double x_m = 0.0, y_m = 0.0;  ///< midpoint
  double ux = 1.0, uy = 0.0;    ///< direction
  double length_m = 0.0;
  double weight_m = 0.0;  ///< length, reduced if it deviates from a line by more than the noise
};

/// Writes the segments of `beams` into `segments`, in the order of the scan.
class Splitter {
 public:
  void split(const Beams& beams, const WallOptions& options, std::vector<Segment>& segments);

 private:
  struct Run {
    std::size_t begin, end;  ///< the last point is end − 1
  };
  void split_run(const Beams& beams, const WallOptions& options, Run run,
                 std::vector<Segment>& segments);
  std::vector<Run> open_;
};

}  // namespace wayfare::lines
