#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include <wayfare/core/result.hpp>
#include <wayfare/core/se2.hpp>
#include <wayfare/core/se3.hpp>
#include <wayfare/core/time.hpp>
#include <wayfare/sensors/deskew.hpp>

namespace wayfare {

/// Limits of interpolation.
struct PoseHistoryOptions {
  Duration largest_gap{500'000'000};  ///< between poses further apart nothing is known
  /// This far before the first pose, and beyond the latest, the motion between the two nearest goes
  /// on.
  Duration beyond{20'000'000};
  /// Poses that follow each other faster are thinned to this.
  Duration spacing{2'000'000};
};

/// The latest poses of a carrier as they come, SE2d or SE3d: a motion for `deskew` during
/// operation. The last 256 poses; does not allocate.
template <class Pose>
class PoseHistory {
 public:
  /// Without poses.
  explicit PoseHistory(const PoseHistoryOptions& options = {}) : options_(options) {}

  /// Errors: a pose that is not finite, or not later than the one before it. It is then left out.
  Result<void> add(LogTime time, const Pose& pose) {
    if (!detail::finite_pose(pose)) return Error{ErrorCode::invalid, "the pose is not finite"};
    if (count_ > 0 && time <= entry(0).time)
      return Error{ErrorCode::invalid, "the pose is not later than the one before it"};
    if (count_ < 2 || time - entry(1).time >= options_.spacing) {
      newest_ = (newest_ + 1) % kEntries;
      count_ = count_ < kEntries ? count_ + 1 : kEntries;
    }
    entries_[newest_] = {time, pose};
    return {};
  }
  void clear() { count_ = 0; }  ///< forgets all poses

  /// Along the constant twist between the poses around `time`; nothing in a gap, or too far from
  /// all poses.
  [[nodiscard]] std::optional<Pose> operator()(LogTime time) const {
    if (count_ == 0) return std::nullopt;
    if (time == entry(0).time) return entry(0).pose;
    if (count_ < 2 || time - entry(0).time > options_.beyond ||
        entry(count_ - 1).time - time > options_.beyond)
      return std::nullopt;
    std::size_t age = 1;
    while (age + 1 < count_ && time < entry(age).time) ++age;
    return between(entry(age), entry(age - 1), time);
  }

 private:
  static constexpr std::size_t kEntries = 256;
  struct Entry {
    LogTime time;
    Pose pose;
  };

  [[nodiscard]] const Entry& entry(std::size_t age) const {
    return entries_[(newest_ + kEntries - age) % kEntries];
  }
  [[nodiscard]] std::optional<Pose> between(const Entry& a, const Entry& b, LogTime time) const {
    if (b.time - a.time > options_.largest_gap) return std::nullopt;
    return interpolate(a.pose, b.pose, to_seconds(time - a.time) / to_seconds(b.time - a.time));
  }

  PoseHistoryOptions options_;
  std::array<Entry, kEntries> entries_{};
  std::size_t newest_ = 0, count_ = 0;
};

}  // namespace wayfare
