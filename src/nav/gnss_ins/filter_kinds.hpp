#pragma once

// Filters with different states, each compiled by itself.

#include <memory>

#include "nav/gnss_ins/any_filter.hpp"

namespace wayfare::nav {

[[nodiscard]] std::unique_ptr<AnyInsFilter> make_plain_filter(const GnssInsOptions& options);
/// With states for wheels and carrier phases; those of the one that is not used stay zero.
[[nodiscard]] std::unique_ptr<AnyInsFilter> make_aided_filter(const GnssInsOptions& options);

}  // namespace wayfare::nav
