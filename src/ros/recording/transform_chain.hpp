#pragma once

// The pose of a frame in another over time, by the transforms between them.

#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include <wayfare/core/se3.hpp>
#include <wayfare/io/text_file.hpp>
#include <wayfare/ros/convert.hpp>

namespace wayfare::ros {

struct TimedPose {
  LogTime time;
  SE3d pose;
};

class TransformChain {
 public:
  /// One that `is_static` applies at every time. Invalid ones are reported and left out.
  void add(const TransformStamped& transform, bool is_static, io::Problems& problems);

  /// In the plane of `base`, at the times of the most frequent transform between the frames; the
  /// others are interpolated over at most two seconds. Errors: frames that are not connected, or
  /// transforms that never change or have no time in common.
  [[nodiscard]] Result<Trajectory> poses(std::string_view base, std::string_view frame) const;

 private:
  struct Link {
    std::string parent;
    bool is_static = false;
    std::vector<TimedPose> poses = {};  ///< in the parent, in the order of the messages
  };
  /// A frame and its link to the parent.
  using Named = std::map<std::string, Link, std::less<>>::const_pointer;

  /// Links from a frame to the first without a parent.
  [[nodiscard]] std::vector<Named> way_up(std::string_view frame) const;
  [[nodiscard]] Error broken(std::string_view base, std::string_view frame) const;

  std::map<std::string, Link, std::less<>> links_;
};

}  // namespace wayfare::ros
