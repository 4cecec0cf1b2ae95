#pragma once

// Filters with different states, each compiled by itself.

#include <memory>

#include "nav/gnss_ins/any_filter.hpp"

namespace wayfare::nav {

[[nodiscard]] std::unique_ptr<AnyInsFilter> make_plain_filter(const GnssInsOptions& options);
[[nodiscard]] std::unique_ptr<AnyInsFilter> make_wheel_filter(const GnssInsOptions& options);
[[nodiscard]] std::unique_ptr<AnyInsFilter> make_phase_filter(const GnssInsOptions& options);
[[nodiscard]] std::unique_ptr<AnyInsFilter> make_wheel_phase_filter(const GnssInsOptions& options);

}  // namespace wayfare::nav
