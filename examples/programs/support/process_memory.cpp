#include "process_memory.hpp"

#include <cstddef>
#include <fstream>

#include <sys/resource.h>
#include <unistd.h>

namespace wayfare::examples {

double resident_memory_mb() {
  std::ifstream file("/proc/self/statm");
  std::size_t size = 0, resident = 0;
  file >> size >> resident;
  return 1e-6 * static_cast<double>(resident) * static_cast<double>(::sysconf(_SC_PAGESIZE));
}

double peak_memory_mb() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return 1e-6 * 1024.0 * static_cast<double>(usage.ru_maxrss);
}

}  // namespace wayfare::examples
