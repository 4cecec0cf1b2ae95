#pragma once

// Fields of structures by their names, for writing and reading them as JSON.

#include <concepts>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include <Eigen/Core>
#include <nlohmann/json.hpp>

#include "logger/message_text.hpp"

namespace wayfare::logger::message_text {

/// Writes numbers as a list.
template <class Numbers>
void put_list(std::string& out, const Numbers& numbers) {
  out += '[';
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    if (i != 0) out += ',';
    if constexpr (sizeof(numbers[i]) == 1) {
      put(out, static_cast<int>(numbers[i]));
    } else {
      put(out, numbers[i]);
    }
  }
  out += ']';
}

/// Writes `,"name":value` of what is present.
class FieldWriter {
 public:
  explicit FieldWriter(std::string& out) : out_(out) {}

  template <class T>
  void operator()(const char* name, const std::optional<T>& value) {
    if (!value) return;
    key(name);
    write(*value);
  }
  template <class T>
  void operator()(const char* name, const std::vector<T>& values) {
    if (values.empty()) return;
    key(name);
    put_list(out_, values);
  }
  template <class T>
  requires std::integral<T> || std::floating_point<T>
  void operator()(const char* name, T value) {
    key(name);
    write(value);
  }

 private:
  void key(const char* name) {
    out_ += ",\"";
    out_ += name;
    out_ += "\":";
  }
  template <class T>
  requires std::integral<T> || std::floating_point<T>
  void write(T value) {
    if constexpr (std::same_as<T, bool>) {
      out_ += value ? "true" : "false";
    } else if constexpr (sizeof(T) == 1) {
      put(out_, static_cast<int>(value));
    } else {
      put(out_, value);
    }
  }
  template <int Rows, int Columns>
  void write(const Eigen::Matrix<double, Rows, Columns>& m) {
    for (Eigen::Index i = 0; i < m.size(); ++i) {
      out_ += i == 0 ? '[' : ',';
      put(out_, m.data()[i]);
    }
    out_ += ']';
  }

  std::string& out_;
};

/// Reads fields that are present; `good` becomes false where one is of another type.
class FieldReader {
 public:
  explicit FieldReader(const nlohmann::json& from) : from_(from) {}

  template <class T>
  void operator()(const char* name, std::optional<T>& value) {
    const auto it = from_.find(name);
    if (it == from_.end() || it->is_null()) return;
    T read{};
    if (take(*it, read)) value = read;
  }
  template <class T>
  void operator()(const char* name, std::vector<T>& values) {
    const auto it = from_.find(name);
    if (it == from_.end()) return;
    good_ = good_ && it->is_array();
    if (!good_) return;
    for (const nlohmann::json& element : *it) {
      T read{};
      if (take(element, read)) values.push_back(read);
    }
  }
  template <class T>
  requires std::integral<T> || std::floating_point<T>
  void operator()(const char* name, T& value) {
    const auto it = from_.find(name);
    if (it != from_.end()) take(*it, value);
  }
  [[nodiscard]] bool good() const { return good_; }

 private:
  bool take(const nlohmann::json& from, bool& to) {
    good_ = good_ && from.is_boolean();
    if (good_) to = from.get<bool>();
    return good_;
  }
  /// Where it is a number that the type can have.
  template <std::integral T>
  bool take(const nlohmann::json& from, T& to) {
    good_ = good_ && from.is_number_integer();
    if (!good_) return false;
    if (from.is_number_unsigned()) {
      const auto n = from.get<std::uint64_t>();
      good_ = n <= static_cast<std::uint64_t>(std::numeric_limits<T>::max());
      to = static_cast<T>(n);
    } else {
      const auto n = from.get<std::int64_t>();
      good_ = n < 0 && std::is_signed_v<T> &&
              n >= static_cast<std::int64_t>(std::numeric_limits<T>::min());
      to = static_cast<T>(n);
    }
    return good_;
  }
  template <std::floating_point T>
  bool take(const nlohmann::json& from, T& to) {
    good_ = good_ && (from.is_number() || from.is_null());
    if (!good_) return false;
    to = from.is_null() ? std::numeric_limits<T>::quiet_NaN() : static_cast<T>(from.get<double>());
    return true;
  }
  template <int Rows, int Columns>
  bool take(const nlohmann::json& from, Eigen::Matrix<double, Rows, Columns>& to) {
    good_ = good_ && from.is_array() && from.size() == static_cast<std::size_t>(to.size());
    for (std::size_t i = 0; good_ && i < from.size(); ++i) take(from[i], to.data()[i]);
    return good_;
  }

  const nlohmann::json& from_;
  bool good_ = true;
};

/// `,"name":{…}` with the fields that `visit(value, field)` names; nothing where there is no value.
template <class T, class Visit>
void add_object(std::string& out, const char* name, const std::optional<T>& value, Visit visit) {
  if (!value) return;
  std::string fields;
  FieldWriter writer(fields);
  visit(*value, writer);
  out += std::string(",\"") + name + "\":{" + fields.substr(1) + '}';
}

/// The inverse; false where it is no such object.
template <class T, class Visit>
bool read_object(const nlohmann::json& from, const char* name, std::optional<T>& value,
                 Visit visit) {
  const auto it = from.find(name);
  if (it == from.end()) return true;
  if (!it->is_object()) return false;
  FieldReader reader(*it);
  T read{};
  visit(read, reader);
  value = read;
  return reader.good();
}

}  // namespace wayfare::logger::message_text
