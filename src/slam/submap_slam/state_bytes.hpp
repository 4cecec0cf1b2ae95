#pragma once

// Serialisation with one list of fields for both directions: little endian, every vector preceded
// by its length.

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/detail/bytes.hpp>
#include <wayfare/core/se2.hpp>
#include <wayfare/core/time.hpp>

namespace wayfare {

class StateWriter {
 public:
  static constexpr bool kReads = false;
  std::vector<std::uint8_t> bytes;

  template <decode::Number T>
  void number(const T& value) {
    bytes.resize(bytes.size() + sizeof(T));
    decode::store_le(value, bytes.data() + bytes.size() - sizeof(T));
  }
  [[nodiscard]] static bool ok() { return true; }
};

/// Stops reading at the first fault.
class StateReader {
 public:
  static constexpr bool kReads = true;
  explicit StateReader(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

  template <decode::Number T>
  void number(T& value) {
    if (!ok_ || left() < sizeof(T)) return fail();
    value = decode::load_le<T>(bytes_.data() + at_);
    at_ += sizeof(T);
    if constexpr (std::floating_point<T>)
      if (!std::isfinite(value)) fail();
  }
  void fail() { ok_ = false; }
  [[nodiscard]] bool ok() const { return ok_; }
  [[nodiscard]] std::size_t at() const { return at_; }
  [[nodiscard]] std::size_t left() const { return bytes_.size() - at_; }

 private:
  std::span<const std::uint8_t> bytes_;
  std::size_t at_ = 0;
  bool ok_ = true;
};

template <class A, decode::Number T>
void field(A& a, T& value) {
  a.number(value);
}
template <class A>
void field(A& a, bool& value) {
  std::uint8_t byte = value ? 1 : 0;
  a.number(byte);
  value = byte != 0;
}
template <class A>
void field(A& a, LogTime& time) {
  std::int64_t ns = time.nanoseconds();
  a.number(ns);
  time = LogTime::from_nanoseconds(ns);
}
template <class A, int R, int C>
void field(A& a, Eigen::Matrix<double, R, C>& m) {
  for (double& x : m.reshaped()) a.number(x);
}
template <class A>
void field(A& a, SE2d& pose) {
  double v[4] = {pose.x(), pose.y(), pose.rotation().cos(), pose.rotation().sin()};
  for (double& x : v) a.number(x);
  if constexpr (A::kReads) {
    if (!(std::abs(v[2] * v[2] + v[3] * v[3] - 1) < 1e-6)) return a.fail();
    pose = SE2d(Eigen::Vector2d(v[0], v[1]), SO2d::from_unit_complex(v[2], v[3]));
  }
}
template <class A, class T, class Each>
void each(A& a, std::vector<T>& values, const Each& one) {
  std::uint64_t n = values.size();
  a.number(n);
  if constexpr (A::kReads) {
    if (!a.ok() || n > a.left()) return a.fail();  // every value takes at least one byte
    values.clear();
    for (std::uint64_t i = 0; i < n && a.ok(); ++i) one(values.emplace_back());
  } else {
    for (T& value : values) one(value);
  }
}
template <class A, class T, class Inner>
void optional_field(A& a, std::optional<T>& value, const Inner& inner) {
  bool has = value.has_value();
  field(a, has);
  if constexpr (A::kReads) value = has ? std::optional<T>(T{}) : std::nullopt;
  if (has) inner(*value);
}

}  // namespace wayfare
