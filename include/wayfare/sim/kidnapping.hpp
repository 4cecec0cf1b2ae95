#pragma once

// Recordings cut and joined: what a robot that is lifted and put down elsewhere records.

#include <wayfare/core/time.hpp>
#include <wayfare/sensors/recording.hpp>

namespace wayfare::sim {

/// What was recorded in [from, to), at the times it was.
[[nodiscard]] Recording part_of(const Recording& recording, LogTime from, LogTime to);

/// The robot is carried, without noticing, from where it was at `from` to where it was at `to`:
/// what lies between is cut out, later times move forward to close the gap, odometry goes on as if
/// nothing had happened and truth jumps; from <= to.
[[nodiscard]] Recording carried_away(const Recording& recording, LogTime from, LogTime to);

}  // namespace wayfare::sim
