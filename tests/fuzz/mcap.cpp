#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>

#include <wayfare/io/mcap.hpp>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace wayfare::io;
  const auto reader =
      McapReader::parse(std::string(reinterpret_cast<const char*>(data), size), "fuzz");
  if (!reader) return 0;
  std::size_t through = 0;
  reader->read({}, [&](const McapMessage& m) {
    if (m.channel == nullptr) std::abort();
    ++through;
    return true;
  });
  // Counting and reading from the front agree.
  if (!reader->contents().indexed && through != reader->contents().statistics.messages)
    std::abort();
  wayfare::LogTime last = wayfare::LogTime::from_nanoseconds(0);
  reader->read({McapOrder::log_time}, [&](const McapMessage& m) {
    if (!reader->contents().indexed && m.log_time < last) std::abort();
    last = m.log_time;
    return true;
  });
  return 0;
}
