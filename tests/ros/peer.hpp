#pragma once

// ROS 1's own headers as a peer. They are C++17, unlike the rest of the tree; neither includes the
// other.

#include <string>

namespace peer {

struct Kind {
  std::string name, md5, definition;
};

/// The definition in ROS's generated headers of a message of this name; empty if not supported.
Kind kind_of(const std::string& name);

/// `bytes` read as a message of this name and written again; throws if invalid.
std::string written_again(const std::string& name, const std::string& bytes);

}  // namespace peer
