#pragma once

#include <wayfare/core.hpp>

#include "named.hpp"

/// Turns on the spot, from the other translation unit.
wayfare::SE2d turned(const wayfare::SE2d& pose, wayfare::Angle by);
