#pragma once

// The network sockets of this process.

#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>
#include <string>
#include <system_error>
#include <vector>

namespace wayfare::testing {

/// Local addresses, such as 0100007F:1F9A (hexadecimal, as /proc/net/tcp has them), of all TCP
/// sockets that this process listens on and of all its UDP sockets.
inline std::vector<std::string> listened_addresses() {
  std::set<std::string> own;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd")) {
    std::error_code gone;
    const std::string target = std::filesystem::read_symlink(entry.path(), gone).string();
    if (target.starts_with("socket:[")) own.insert(target.substr(8, target.size() - 9));
  }
  std::vector<std::string> addresses;
  for (const std::string table : {"tcp", "tcp6", "udp", "udp6"}) {
    std::ifstream lines("/proc/self/net/" + table);
    for (std::string line; std::getline(lines, line);) {
      std::istringstream words(line);
      std::vector<std::string> fields;
      for (std::string word; words >> word;) fields.push_back(word);
      constexpr std::size_t kLocal = 1, kState = 3, kInode = 9;
      const bool listens = fields.size() > kInode && (table[0] == 'u' || fields[kState] == "0A");
      if (listens && own.contains(fields[kInode])) addresses.push_back(fields[kLocal]);
    }
  }
  return addresses;
}

}  // namespace wayfare::testing
