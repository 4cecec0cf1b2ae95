#pragma once

#include <map>
#include <string>
#include <string_view>

#include <wayfare/core/result.hpp>
#include <wayfare/ros/messages.hpp>

namespace wayfare::ros {

/// Frames as transforms tell of them, each under its parent; of a transform told again the last
/// stands. Frames are named without the slash ROS 1 once put before them.
class FrameTree {
 public:
  void add(const TransformStamped& transform);

  [[nodiscard]] bool empty() const { return parents_.empty(); }

  /// The pose of `frame` in `base`; of neighbours to the bit as it was told. Errors: nothing leads
  /// from one to the other (the frames there are are named), or a rotation is none.
  [[nodiscard]] Result<TransformParts> find(std::string_view base, std::string_view frame) const;

 private:
  struct Parent {
    std::string name;
    TransformParts transform;
  };

  std::map<std::string, Parent, std::less<>> parents_;
};

}  // namespace wayfare::ros
