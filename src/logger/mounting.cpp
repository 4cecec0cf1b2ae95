#include <cmath>

#include <nlohmann/json.hpp>

#include <wayfare/io/mcap.hpp>
#include <wayfare/logger/device_messages.hpp>

#include "logger/message_text.hpp"

namespace wayfare::logger {
namespace {

using nlohmann::json;
using namespace message_text;

/// Four numbers of an object, or none.
std::optional<Eigen::Vector4d> numbers_of(const json& from, const char* key, bool with_w) {
  const auto it = from.find(key);
  if (it == from.end() || !it->is_object()) return std::nullopt;
  const auto x = number(*it, "x"), y = number(*it, "y"), z = number(*it, "z");
  const auto w = with_w ? number(*it, "w") : std::optional(0.0);
  if (!x || !y || !z || !w) return std::nullopt;
  return Eigen::Vector4d(*x, *y, *z, *w);
}

std::optional<Mounting> mounting_of(const json& from) {
  if (!from.is_object()) return std::nullopt;
  const auto parent = from.find("parent_frame_id"), child = from.find("child_frame_id");
  const auto at = numbers_of(from, "translation", false), q = numbers_of(from, "rotation", true);
  if (parent == from.end() || !parent->is_string() || child == from.end() || !child->is_string() ||
      !at || !q || std::abs(q->norm() - 1.0) > 1e-3)
    return std::nullopt;
  return Mounting{
      parent->get<std::string>(), child->get<std::string>(),
      SE3d(at->head<3>(), SO3d(Eigen::Quaterniond((*q)[3], (*q)[0], (*q)[1], (*q)[2])))};
}

}  // namespace

MessageSchema transforms_schema() {
  static const std::string schema = R"({"title":"foxglove.FrameTransforms","type":"object",)"
                                    R"("properties":{"transforms":{"type":"array","items":)" +
                                    schema_json("foxglove.FrameTransform", false,
                                                R"("parent_frame_id":{"type":"string"},)"
                                                R"("child_frame_id":{"type":"string"},)"
                                                R"("translation":{"type":"object"},)"
                                                R"("rotation":{"type":"object"})") +
                                    "}}}";
  return {"foxglove.FrameTransforms", schema};
}

std::string transforms_json(std::span<const Mounting> mountings, LogTime time) {
  std::string out = R"({"transforms":[)";
  for (const Mounting& m : mountings) {
    if (out.back() != '[') out += ',';
    const auto [sec, nsec] = seconds_and_rest(time);
    const Eigen::Vector3d& at = m.pose.translation();
    const Eigen::Quaterniond& q = m.pose.rotation().quaternion();
    out += R"({"timestamp":{"sec":)";
    put(out, sec);
    out += R"(,"nsec":)";
    put(out, nsec);
    out += R"(},"parent_frame_id":")" + json_escaped(m.parent) + R"(","child_frame_id":")" +
           json_escaped(m.child) + R"(","translation":{"x":)";
    put(out, at.x());
    out += R"(,"y":)";
    put(out, at.y());
    out += R"(,"z":)";
    put(out, at.z());
    out += R"(},"rotation":{"x":)";
    put(out, q.x());
    out += R"(,"y":)";
    put(out, q.y());
    out += R"(,"z":)";
    put(out, q.z());
    out += R"(,"w":)";
    put(out, q.w());
    out += "}}";
  }
  return out + "]}";
}

Result<std::vector<Mounting>> parse_transforms(std::string_view text) {
  const json message = json::parse(text, nullptr, false);
  const Error wrong = malformed("foxglove.FrameTransforms");
  if (!message.is_object()) return wrong;
  const auto list = message.find("transforms");
  if (list == message.end() || !list->is_array()) return wrong;
  std::vector<Mounting> mountings;
  for (const json& element : *list) {
    auto mounting = mounting_of(element);
    if (!mounting) return wrong;
    mountings.push_back(std::move(*mounting));
  }
  return mountings;
}

Result<std::vector<Mounting>> read_mountings(const std::string& path) {
  const auto reader = io::McapReader::open(path);
  if (!reader) return reader.error();
  std::vector<Mounting> mountings;
  static_cast<void>(
      reader->read({io::McapOrder::file, {"/tf_static"}}, [&](const io::McapMessage& message) {
        if (auto read = parse_transforms(message.data)) mountings = std::move(*read);
        return mountings.empty();
      }));
  return mountings;
}

}  // namespace wayfare::logger
