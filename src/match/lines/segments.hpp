#pragma once

// Straight pieces of a scan by splitting and merging (Nguyen et al. 2005, section II).

#include <cstddef>
#include <vector>

#include <wayfare/match/lines.hpp>

#include "match/lines/beams.hpp"

namespace wayfare::lines {

struct Segment {
  double x_m = 0.0, y_m = 0.0;  ///< its middle
  double ux = 1.0, uy = 0.0;    ///< along it
  double length_m = 0.0;
  double weight_m = 0.0;  ///< its length, less where it bows by more than the noise
};

/// The pieces of `beams` in the order of the scan, into `segments`.
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
