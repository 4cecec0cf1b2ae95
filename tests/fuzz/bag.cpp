#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>

#include <wayfare/io/bag.hpp>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace wayfare::io;
  const BagReadOptions options{std::size_t{1} << 22U, 10};
  std::string bytes(reinterpret_cast<const char*>(data), size);
  // Fragments from the middle of a bag are read, too.
  if (!bytes.starts_with("#ROSBAG V2.0\n")) bytes = "#ROSBAG V2.0\n" + bytes;
  const auto bag = BagReader::parse(bytes, "fuzz", options);
  if (!bag) std::abort();
  std::uint64_t messages = 0;
  const auto problems = bag->read([&](const BagMessage& m) {
    if (m.connection == nullptr || m.connection->topic.empty()) std::abort();
    ++messages;
    return true;
  });
  if (problems.first().size() > 10) std::abort();
  // Counting and reading from the front agree.
  if (!bag->contents().indexed && messages != bag->contents().messages) std::abort();
  return 0;
}
