#pragma once

// ROS 1's own headers at work. They are C++17, which the rest of the tree is not: they know nothing
// of it, nor it of them.

#include <string>

namespace peer {

struct Kind {
  std::string name, md5, definition;
};

/// What ROS's generated headers say of a message named so; empty where it is not asked about.
Kind kind_of(const std::string& name);

/// `bytes` read as a message named so and written again; throws where they are none.
std::string written_again(const std::string& name, const std::string& bytes);

}  // namespace peer
