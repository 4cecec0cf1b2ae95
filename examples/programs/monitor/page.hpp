#pragma once

namespace wayfare::examples {

/// The monitor's one page, with all it needs.
[[nodiscard]] const char* monitor_page();

}  // namespace wayfare::examples
