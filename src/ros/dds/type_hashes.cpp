#include <array>

#include <wayfare/ros/ros2_node.hpp>

namespace wayfare::ros {
namespace {

struct TypeHash {
  std::string_view type, hash;
};

constexpr std::array<TypeHash, 0> kHashes{};

}  // namespace

std::string_view type_hash(std::string_view ros1_name) {
  for (const TypeHash& h : kHashes)
    if (h.type == ros1_name) return h.hash;
  return {};
}

}  // namespace wayfare::ros
