#pragma once

// The text of a message's definition, from its list of fields.

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include <wayfare/ros/serialise.hpp>

namespace wayfare::ros {

class Describer {
 public:
  explicit Describer(Dialect dialect) : dialect_(dialect) {}

  template <class T>
  void operator()(const char* name, const T& value) {
    line(type_of(value), name);
  }
  void ros1_only(const char* name, std::uint32_t value) {
    if (dialect_ == Dialect::ros1) line(type_of(value), name);
  }

  template <class M>
  [[nodiscard]] std::string whole(const M& message) {
    body(message);
    std::string text = own_;
    for (const auto& [name, definition] : within_)
      text += std::string(80, '=') + "\nMSG: " + name + "\n" + definition;
    return text;
  }

 private:
  void line(const std::string& type, const char* name) { own_ += type + " " + name + "\n"; }

  template <class M>
  void body(const M& message) {
    own_ += M::kType.constants;
    M::fields(message, *this);
  }

  template <class T>
  requires std::is_arithmetic_v<T>
  static std::string type_of(T) {
    if constexpr (std::is_same_v<T, bool>) return "bool";
    const char* kind = std::is_floating_point_v<T> ? "float" : std::is_signed_v<T> ? "int" : "uint";
    return kind + std::to_string(8 * sizeof(T));
  }
  static std::string type_of(const std::string&) { return "string"; }
  std::string type_of(const Stamp&) {
    if (dialect_ == Dialect::ros1) return "time";
    add("builtin_interfaces/Time", "int32 sec\nuint32 nanosec\n");
    return "builtin_interfaces/Time";
  }
  template <class T>
  std::string type_of(const std::vector<T>&) {
    return type_of(T{}) + "[]";
  }
  template <class T, std::size_t N>
  std::string type_of(const std::array<T, N>&) {
    return type_of(T{}) + "[" + std::to_string(N) + "]";
  }
  template <class M>
  requires requires { M::kType; }
  std::string type_of(const M& message) {
    const std::string name(M::kType.name);
    for (const auto& there : within_)
      if (there.name == name) return name;
    const std::size_t place = within_.size();
    within_.push_back({name, {}});
    std::string outer;
    outer.swap(own_);
    body(message);
    outer.swap(own_);
    within_[place].definition = std::move(outer);
    return name;
  }
  void add(const std::string& name, const std::string& definition) {
    for (const auto& there : within_)
      if (there.name == name) return;
    within_.push_back({name, definition});
  }

  struct Part {
    std::string name, definition;
  };
  Dialect dialect_;
  std::string own_;
  std::vector<Part> within_;
};

}  // namespace wayfare::ros
