#pragma once

// Private: sorts out CARMEN lines that are not in order of time.

#include <vector>

#include "io/carmen/carmen_faults.hpp"
#include "io/carmen/carmen_lines.hpp"

namespace wayfare::io::carmen {

/// Drops the smallest set of lines that are not in order of time and reports them; `what` names
/// such a line.
template <class Line>
void order(std::vector<Line>& lines, const char* what, Faults& faults);

/// The same, and drops duplicates: lines with the time of the previous one.
template <class T>
void order_once(std::vector<Measured<T>>& lines, const char* what, Faults& faults);

/// Drops scans that are equal to the previous one and reports them.
void drop_repeated(std::vector<ScanLine>& scans, Faults& faults);

}  // namespace wayfare::io::carmen
