#include "ros/dds/names.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <utility>

#include <wayfare/ros/serialise.hpp>

namespace wayfare::ros::dds {
namespace {

constexpr std::string_view kMiddle = "::dds_::";

std::string replaced(std::string text, std::string_view from, std::string_view to) {
  for (std::size_t at = 0; (at = text.find(from, at)) != text.npos; at += to.size())
    text.replace(at, from.size(), to);
  return text;
}

}  // namespace

std::string dds_type(std::string_view ros1_name) {
  std::string name = ros2_name(ros1_name);
  const std::size_t last = name.rfind('/');
  if (last == name.npos) return name;
  const std::string type = name.substr(last + 1);
  return replaced(name.substr(0, last), "/", "::") + std::string(kMiddle) + type + "_";
}

std::string ros1_type(std::string_view dds_name) {
  const std::size_t middle = dds_name.find(kMiddle);
  if (middle == dds_name.npos || !dds_name.ends_with('_')) return std::string(dds_name);
  std::string_view type = dds_name.substr(middle + kMiddle.size());
  type.remove_suffix(1);
  std::string name = replaced(std::string(dds_name.substr(0, middle)), "::", "/");
  return ros1_name(name.append("/").append(type));
}

bool is_token(std::string_view text) {
  const auto is_part = [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_';
  };
  return !text.empty() && std::all_of(text.begin(), text.end(), is_part) &&
         std::isdigit(static_cast<unsigned char>(text.front())) == 0;
}

Result<std::string> absolute(std::string_view topic, const NodeName& node) {
  const std::string ns = node.ns == "/" ? "" : node.ns;
  std::string full;
  if (topic.starts_with('/')) {
    full = topic;
  } else if (topic == "~" || topic.starts_with("~/")) {
    full = ns + "/" + node.name + std::string(topic.substr(1));
  } else {
    full = ns + "/" + std::string(topic);
  }
  for (std::string_view rest = full; !rest.empty();) {
    rest.remove_prefix(1);  // a slash
    const std::size_t end = std::min(rest.find('/'), rest.size());
    if (!is_token(rest.substr(0, end)))
      return Error{ErrorCode::invalid,
                   "is no name of ROS 2: letters, digits and _ between slashes, no digit first",
                   std::string(topic)};
    rest.remove_prefix(end);
  }
  return full;
}

}  // namespace wayfare::ros::dds
