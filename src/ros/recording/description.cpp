#include "ros/recording/description.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <map>
#include <system_error>

namespace wayfare::ros {
namespace {

constexpr std::string_view kSpace = " \t\r\n";
constexpr const char* kRadarSpeed = "wayfare_radar_max_speed";

/// The tags of an XML text, in order; text, comments and declarations are skipped.
class Tags {
 public:
  explicit Tags(std::string_view text) : left_(text) {}

  bool next() {
    for (;;) {
      const std::size_t begin = left_.find('<');
      if (begin == left_.npos) return false;
      left_.remove_prefix(begin);
      const bool comment = left_.starts_with("<!--");
      const std::size_t end = comment ? left_.find("-->") : end_of_tag();
      if (end == left_.npos) return false;
      tag_ = left_.substr(1, end - 1);
      left_.remove_prefix(end + 1);
      if (!comment && !tag_.starts_with('?') && !tag_.starts_with('!')) return true;
    }
  }

  /// "joint" of `<joint name="a">`, "/joint" of its end.
  [[nodiscard]] std::string_view name() const {
    const std::string_view name = tag_.substr(0, tag_.find_first_of(" \t\r\n"));
    return name.size() > 1 && name.ends_with('/') ? name.substr(0, name.size() - 1) : name;
  }
  [[nodiscard]] bool is_empty() const { return tag_.ends_with('/'); }
  /// Empty if there is none.
  [[nodiscard]] std::string_view attribute(std::string_view name) const {
    for (std::size_t at = tag_.find('='); at != tag_.npos;) {
      const std::size_t open = tag_.find_first_of("\"'", at);
      const std::size_t close = open == tag_.npos ? open : tag_.find(tag_[open], open + 1);
      if (close == tag_.npos) return {};
      const std::size_t last = tag_.find_last_not_of(kSpace, at - 1);
      const std::size_t before = tag_.find_last_of(kSpace, last);
      if (before != tag_.npos && tag_.substr(before + 1, last - before) == name)
        return tag_.substr(open + 1, close - open - 1);
      at = tag_.find('=', close);
    }
    return {};
  }

 private:
  [[nodiscard]] std::size_t end_of_tag() const {
    char quote = '\0';
    for (std::size_t i = 1; i < left_.size(); ++i) {
      const char c = left_[i];
      if (quote == '\0' && c == '>') return i;
      if (quote == '\0' && (c == '"' || c == '\'')) {
        quote = c;
      } else if (c == quote) {
        quote = '\0';
      }
    }
    return left_.npos;
  }

  std::string_view left_, tag_;
};

/// Takes a number off the front of `text`.
std::optional<double> take_number(std::string_view& text) {
  const std::size_t begin = text.find_first_not_of(kSpace);
  if (begin == text.npos) return std::nullopt;
  double value = 0.0;
  const char* const end = text.data() + text.size();
  const auto [stop, failed] = std::from_chars(text.data() + begin, end, value);
  if (failed != std::errc() || !std::isfinite(value)) return std::nullopt;
  text = {stop, static_cast<std::size_t>(end - stop)};
  return value;
}

std::optional<double> number_of(std::string_view text) { return take_number(text); }

struct Joint {
  std::string_view parent, child;
  std::optional<double> y_m = 0.0;  ///< of its origin
};

struct Parts {
  std::map<std::string_view, Joint> joints;
  std::map<std::string_view, double> radii_m;  ///< of links
  std::optional<double> radar_max_speed_mps;
};

Parts parts_of(std::string_view urdf) {
  Parts parts;
  std::string_view link;
  Joint* joint = nullptr;
  for (Tags tags(urdf); tags.next();) {
    const std::string_view tag = tags.name();
    if (tag == "link") link = tags.attribute("name");
    if (tag == "joint" && !tags.is_empty()) joint = &parts.joints[tags.attribute("name")];
    if (tag == "/joint") joint = nullptr;
    if (tag == "cylinder" || tag == "sphere")
      if (const auto radius_m = number_of(tags.attribute("radius")))
        parts.radii_m.try_emplace(link, *radius_m);
    if (tag == kRadarSpeed) parts.radar_max_speed_mps = number_of(tags.attribute("value"));
    if (joint == nullptr) continue;
    if (tag == "parent") joint->parent = tags.attribute("link");
    if (tag == "child") joint->child = tags.attribute("link");
    if (tag == "origin" && !tags.attribute("xyz").empty()) {
      std::string_view xyz = tags.attribute("xyz");
      joint->y_m = take_number(xyz) ? take_number(xyz) : std::nullopt;
    }
  }
  return parts;
}

std::string text_of(double value) {
  std::array<char, 32> text{};
  return {text.data(), std::to_chars(text.data(), text.data() + text.size(), value).ptr};
}

std::string wheel(const std::string& joint, double y_m, const RobotTopics& topics) {
  const std::string link = joint + "_wheel";
  return "  <link name=\"" + link + "\">\n    <collision><geometry><cylinder radius=\"" +
         text_of(topics.wheel_radius_m) + "\" length=\"0.02\"/></geometry></collision>\n" +
         "  </link>\n  <joint name=\"" + joint + "\" type=\"continuous\">\n    <parent link=\"" +
         topics.base_frame + "\"/>\n    <child link=\"" + link + "\"/>\n    <origin xyz=\"0 " +
         text_of(y_m) + " 0\" rpy=\"-1.5707963267948966 0 0\"/>\n    <axis xyz=\"0 0 1\"/>\n" +
         "  </joint>\n";
}

}  // namespace

Result<RobotDescription> describe(std::string_view urdf, std::string_view left,
                                  std::string_view right) {
  const Parts parts = parts_of(urdf);
  RobotDescription d;
  d.radar_max_speed_mps = parts.radar_max_speed_mps;
  const auto l = parts.joints.find(left), r = parts.joints.find(right);
  if (l == parts.joints.end() || r == parts.joints.end()) return d;
  if (l->second.parent == r->second.parent && l->second.y_m && r->second.y_m)
    d.wheel_base_m = *l->second.y_m - *r->second.y_m;
  const auto left_m = parts.radii_m.find(l->second.child),
             right_m = parts.radii_m.find(r->second.child);
  if (left_m == parts.radii_m.end() || right_m == parts.radii_m.end()) return d;
  if (left_m->second != right_m->second)
    return Error{ErrorCode::invalid, "has wheels of different radii: " + text_of(left_m->second) +
                                         " and " + text_of(right_m->second) + " m"};
  d.wheel_radius_m = left_m->second;
  return d;
}

std::string urdf_of(const Recording& recording, const RobotTopics& topics) {
  const double speed = recording.radar_max_speed_m_s;
  if (recording.wheels.empty() && !(speed > 0.0)) return {};
  std::string text = "<?xml version=\"1.0\"?>\n<robot name=\"robot\">\n  <link name=\"" +
                     topics.base_frame + "\"/>\n";
  const double half_m = 0.5 * recording.wheel_base_m;
  if (!recording.wheels.empty())
    text += wheel(topics.left_wheel, half_m, topics) + wheel(topics.right_wheel, -half_m, topics);
  if (speed > 0.0)
    text += std::string("  <") + kRadarSpeed + " value=\"" + text_of(speed) + "\"/>\n";
  return text + "</robot>\n";
}

}  // namespace wayfare::ros
