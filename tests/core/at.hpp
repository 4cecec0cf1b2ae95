#pragma once

#include <wayfare/core/time.hpp>

namespace wayfare::tests {

/// The instant `s` seconds after a log's epoch.
inline LogTime at(double s) { return LogTime::from_seconds(s); }

}  // namespace wayfare::tests
