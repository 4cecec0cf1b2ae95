#pragma once

// Private: a CARMEN log's lines in the order of their times.

#include <vector>

#include "io/carmen/carmen_faults.hpp"
#include "io/carmen/carmen_lines.hpp"

namespace wayfare::io::carmen {

/// Leaves out the lines that are not in order of time, as few as can be, and reports them; `what`
/// names such a line.
void order(std::vector<ScanLine>& lines, const char* what, Faults& faults);
void order(std::vector<OdometryLine>& lines, const char* what, Faults& faults);

/// The same, and a line with the time of the one before is left out as a repetition of it.
void order_once(std::vector<Measured<RadarScan>>& lines, const char* what, Faults& faults);
void order_once(std::vector<Measured<WheelSample>>& lines, const char* what, Faults& faults);
void order_once(std::vector<Measured<GyroSample>>& lines, const char* what, Faults& faults);
void order_once(std::vector<Measured<StampedPose>>& lines, const char* what, Faults& faults);

/// Leaves out scans that say what the scan before said, and reports them.
void drop_repeated(std::vector<ScanLine>& scans, Faults& faults);

}  // namespace wayfare::io::carmen
