#pragma once

namespace wayfare::examples {

/// Memory of this process that is resident now, MB.
[[nodiscard]] double resident_memory_mb();

/// The most that was resident until now, MB, with the log it has read.
[[nodiscard]] double peak_memory_mb();

}  // namespace wayfare::examples
