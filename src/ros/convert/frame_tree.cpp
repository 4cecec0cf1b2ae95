#include <wayfare/ros/convert.hpp>

#include <cmath>
#include <optional>
#include <vector>

#include <wayfare/core/se3.hpp>

namespace wayfare::ros {
namespace {

std::string_view without_slash(std::string_view name) {
  if (name.starts_with('/')) name.remove_prefix(1);
  return name;
}

std::optional<SE3d> rigid(const TransformParts& t) {
  const Eigen::Quaterniond q(t.rotation.w, t.rotation.x, t.rotation.y, t.rotation.z);
  const Eigen::Vector3d at(t.translation.x, t.translation.y, t.translation.z);
  if (!at.allFinite() || !(std::abs(q.squaredNorm() - 1.0) < 1e-2)) return std::nullopt;
  return SE3d(at, SO3d(q));
}

TransformParts parts(const SE3d& t) {
  const auto& q = t.rotation().quaternion();
  return {{t.translation().x(), t.translation().y(), t.translation().z()},
          {q.x(), q.y(), q.z(), q.w()}};
}

}  // namespace

void FrameTree::add(const TransformStamped& t) {
  parents_[std::string(without_slash(t.child_frame_id))] = {std::string(frame_of(t.header)),
                                                            t.transform};
}

Result<TransformParts> FrameTree::find(std::string_view base, std::string_view frame) const {
  base = without_slash(base), frame = without_slash(frame);
  if (base == frame) return TransformParts{{}, {0.0, 0.0, 0.0, 1.0}};
  const auto direct = parents_.find(frame);
  if (direct != parents_.end() && direct->second.name == base) return direct->second.transform;
  // Up from both, to the first common frame. No path is longer than the number of frames.
  struct Step {
    std::string_view name;
    SE3d pose;  ///< of the start of the path, in `name`
  };
  const auto way_up = [&](std::string_view from) {
    std::vector<Step> path{{from, SE3d()}};
    while (path.size() <= parents_.size()) {
      const auto up = parents_.find(path.back().name);
      const auto T = up == parents_.end() ? std::nullopt : rigid(up->second.transform);
      if (!T) break;
      path.push_back({up->second.name, *T * path.back().pose});
    }
    return path;
  };
  const auto up_frame = way_up(frame), up_base = way_up(base);
  for (const Step& a : up_frame)
    for (const Step& b : up_base)
      if (a.name == b.name) return parts(b.pose.inverse() * a.pose);
  std::string there;
  for (const auto& [child, parent] : parents_)
    there += (there.empty() ? "" : ", ") + parent.name + " -> " + child;
  return Error{ErrorCode::not_found, "no transform leads from '" + std::string(base) + "' to '" +
                                         std::string(frame) + "'" +
                                         (there.empty() ? "" : "; there are " + there)};
}

}  // namespace wayfare::ros
