#pragma once

// Saved states of the systems: their fields as bytes, with a format's name at the beginning and a
// digest at the end.

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/LU>

#include <wayfare/core/detail/bytes.hpp>
#include <wayfare/core/result.hpp>
#include <wayfare/graph/pose_graph.hpp>
#include <wayfare/slam/detail/loops.hpp>
#include <wayfare/slam/detail/motion.hpp>
#include <wayfare/slam/scan_outcome.hpp>

namespace wayfare {

/// FNV-1a, to detect a damaged file.
inline std::uint64_t digest(std::span<const std::uint8_t> bytes) {
  std::uint64_t hash = 0xcbf29ce484222325;
  for (const std::uint8_t b : bytes) hash = (hash ^ b) * 0x100000001b3;
  return hash;
}

inline bool in(int index, std::size_t size) {
  return index >= 0 && static_cast<std::size_t>(index) < size;
}

/// Of a counter that is still to be increased.
inline bool is_count(int n) { return n >= 0 && n < std::numeric_limits<int>::max() / 2; }

/// Whether search and optimisation can use it: it and its inverse are positive definite.
inline bool is_information(const Eigen::Matrix3d& m) {
  return is_positive_definite(m) && is_positive_definite(m.inverse());
}

/// Beyond it sums of poses lose their meaning, and products of them may overflow.
inline constexpr double kFarthest_m = 1e12;

inline bool is_near(const SE2d& pose) {
  return pose.translation().cwiseAbs().maxCoeff() < kFarthest_m;
}

/// Whether all edges join poses of the graph.
inline bool has_valid_edges(const PoseGraph2& graph, const std::vector<PoseEdge<SE2d>>& edges) {
  const std::size_t poses = graph.poses.size();
  return std::ranges::all_of(edges, [&](const PoseEdge<SE2d>& x) {
    return in(x.from, poses) && in(x.to, poses) && x.from != x.to && is_near(x.measurement) &&
           is_information(x.information);
  });
}

// Serialisation with one list of fields for both directions: little endian, every vector preceded
// by its length.

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
  /// With the digest at the end.
  [[nodiscard]] std::vector<std::uint8_t> finished() && {
    number(digest(bytes));
    return std::move(bytes);
  }
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
template <class A, class... T>
void fields(A& a, T&... values) {
  (field(a, values), ...);
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
template <class A>
void field(A& a, std::string& text) {
  std::vector<char> letters(text.begin(), text.end());
  each(a, letters, [&](char& c) {
    auto byte = static_cast<std::uint8_t>(c);
    a.number(byte);
    c = static_cast<char>(byte);
  });
  text.assign(letters.begin(), letters.end());
}
template <class A>
void field(A& a, MatcherErrors& errors) {
  field(a, errors.count);
  field(a, errors.first);
}
template <class A, class T, class Inner>
void optional_field(A& a, std::optional<T>& value, const Inner& inner) {
  bool has = value.has_value();
  field(a, has);
  if constexpr (A::kReads) value = has ? std::optional<T>(T{}) : std::nullopt;
  if (has) inner(*value);
}

template <class A>
void field(A& a, std::vector<PoseEdge<SE2d>>& edges) {
  each(a, edges,
       [&](PoseEdge<SE2d>& e) { fields(a, e.from, e.to, e.measurement, e.information, e.robust); });
}
template <class A>
void field(A& a, std::vector<ScanPose>& scans) {
  each(a, scans, [&](ScanPose& s) { fields(a, s.time, s.node, s.T_node_base); });
}

/// The fields of a MotionModel.
struct MotionState {
  template <class A>
  static void fields(A& a, MotionModel& model) {
    optional_field(a, model.last_, [&](auto& last) {
      wayfare::fields(a, last.time, last.pose);
      optional_field(a, last.odometry, [&](SE2d& pose) { field(a, pose); });
    });
    wayfare::fields(a, model.velocity_from_.time, model.velocity_from_.pose, model.mean_interval_s_,
                    model.velocity_);
  }

  /// Whether they are those of a model that has had a scan, or of a new one.
  static bool is_valid(const MotionModel& m, bool has_scan) {
    return m.last_.has_value() == has_scan &&
           (!m.last_ || (is_near(m.last_->pose) && is_near(m.last_->odometry.value_or(SE2d())))) &&
           is_near(m.velocity_from_.pose) && m.mean_interval_s_ >= 0.0 &&
           m.velocity_.cwiseAbs().maxCoeff() < kFarthest_m;
  }
};

/// What is wrong at a byte of a saved state.
[[nodiscard]] inline Error state_fault(const std::string& what, std::size_t at) {
  return Error{ErrorCode::parse, what, "saved map", 0, at};
}

/// The name of its format, and what is between that and the digest.
struct OpenedState {
  std::uint64_t format = 0;
  std::span<const std::uint8_t> content;
};

/// Of bytes in one of these formats. Errors: another format, the digest differs.
[[nodiscard]] inline Result<OpenedState> open_state(std::span<const std::uint8_t> bytes,
                                                    std::initializer_list<std::uint64_t> formats,
                                                    const std::string& what) {
  constexpr std::size_t kName = sizeof(std::uint64_t), kFrame = 2 * kName;
  const std::uint64_t format =
      bytes.size() < kFrame ? 0 : decode::load_le<std::uint64_t>(bytes.data());
  if (std::ranges::find(formats, format) == formats.end()) return state_fault("not " + what, 0);
  const auto content = bytes.first(bytes.size() - kName);
  if (decode::load_le<std::uint64_t>(bytes.data() + content.size()) != digest(content))
    return state_fault("damaged or truncated: the digest at its end does not match",
                       content.size());
  return OpenedState{format, content.subspan(kName)};
}

}  // namespace wayfare
