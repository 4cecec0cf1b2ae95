#pragma once

#include <map>
#include <string>
#include <string_view>

#include <wayfare/core/result.hpp>
#include <wayfare/ros/messages.hpp>

namespace wayfare::ros {

/// Frames and their parents, from transforms; the last one for each frame applies. Frame names are
/// without the leading slash of early ROS 1.
class FrameTree {
 public:
  void add(const TransformStamped& transform);

  [[nodiscard]] bool empty() const { return parents_.empty(); }

  /// The pose of `frame` in `base`, bit-exact between parent and child. Errors: the frames are not
  /// connected (the known frames are listed), or a rotation is invalid.
  [[nodiscard]] Result<TransformParts> find(std::string_view base, std::string_view frame) const;

 private:
  struct Parent {
    std::string name;
    TransformParts transform;
  };

  std::map<std::string, Parent, std::less<>> parents_;
};

}  // namespace wayfare::ros
