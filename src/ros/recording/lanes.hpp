#pragma once

// Topics of a recording read together: each message parsed, stamped and converted to a measurement,
// in one pass over the file. Frames of the recording: the sensors' mounting on the robot, and its
// odometry by transforms.

#include <algorithm>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <wayfare/core/se3.hpp>
#include <wayfare/ros/convert.hpp>
#include <wayfare/ros/recording.hpp>

#include "ros/recording/transform_chain.hpp"

namespace wayfare::ros {

/// The topic of `type` to read: `named`, which must exist, or else the only one; empty if there is
/// none. `except` is in use by another, unless named. Errors: missing, or several of them.
[[nodiscard]] Result<std::string> choose_topic(const RecordingFile& file, std::string_view type,
                                               const std::string& named, const char* what,
                                               const std::string& except = {});

/// Whether a recording is usable without a topic.
enum class Need { required, optional };

class Lanes {
 public:
  Lanes(const RecordingFile& file, const TopicNames& names) : file_(file), names_(names) {}

  /// Converts the messages M of `topic` with their times by `convert`, into `out` in order of time.
  /// Nothing if `topic` is empty. An optional topic that cannot be used is dropped and reported.
  template <class M, class Value, class Convert>
  void add(const std::string& topic, std::vector<Value>& out, Convert convert,
           Need need = Need::required) {
    if (topic.empty()) return;
    Lane& lane = lanes_[topic];
    if (need == Need::optional) lane.leave_out = [&out] { out.clear(); };
    lane.stamped = true;
    lane.take = [this, &out, convert](const RecordedMessage& raw, Lane& own) -> Result<void> {
      const auto message = from_bytes<M>(raw.data, raw.topic.dialect);
      if (!message) return message.error();
      const bool by_receipt = names_.stamps == StampSource::received;
      const auto time = by_receipt ? Result<LogTime>(raw.received) : time_of(message->header.stamp);
      if (!time) return time.error();
      Result<Value> value = convert(*message, *time);
      if (!value) return value.error();
      out.push_back(*std::move(value));
      own.late.push_back(*time - raw.received);
      return {};
    };
    sort_.push_back([&out] {
      std::stable_sort(out.begin(), out.end(),
                       [](const Value& a, const Value& b) { return a.time < b.time; });
    });
  }

  /// Every message of `topic`, with any stamp.
  template <class M>
  void visit(const std::string& topic, std::function<void(const M&)> visit) {
    lanes_[topic].take = [visit](const RecordedMessage& raw, Lane&) -> Result<void> {
      const auto message = from_bytes<M>(raw.data, raw.topic.dialect);
      if (!message) return message.error();
      visit(*message);
      return {};
    };
  }

  /// Reads the file. Errors: a topic without usable messages; topics on different clocks.
  [[nodiscard]] Result<void> run(io::Problems& problems);

 private:
  struct Lane {
    std::function<Result<void>(const RecordedMessage&, Lane&)> take;
    std::function<void()> leave_out;  ///< if optional
    bool stamped = false;
    std::size_t messages = 0;
    std::vector<Duration> late;  ///< stamp minus receipt, of each message used
    std::optional<Error> first_fault;
  };

  [[nodiscard]] Result<void> check_clocks(io::Problems& problems);
  [[nodiscard]] static Result<void> refuse(const Lane& lane, Error fault, io::Problems& problems);

  const RecordingFile& file_;
  const TopicNames& names_;
  std::map<std::string, Lane> lanes_;
  std::vector<std::function<void()>> sort_;
};

struct Layout {
  FrameTree tree;
  std::vector<OdometrySample> by_transforms;  ///< from `odom`, in the order of the messages
  std::string odometry_child;                 ///< child of the odometry, else of these transforms
  std::vector<std::string> truth_frames;      ///< parent and child of the true poses, or none …
  Trajectory truth;                           ///< … and those, in the order of the messages
  TransformChain chain;                       ///< with those frames, all transforms over time

  /// Adds all transforms while the file is read; errors in one are reported in `problems`.
  void listen(Lanes& lanes, const RecordingFile& file, io::Problems& problems);
  /// The robot's frame: as named, else the odometry's child, else `base_link`.
  [[nodiscard]] std::string base_frame(const TopicNames& names) const;

 private:
  void take(const TfMessage& message, bool is_static, io::Problems& problems);
  void take(const TransformStamped& transform, io::Problems& problems);
};

/// All messages of a topic have one frame, that of the first.
[[nodiscard]] Result<void> take_frame(const Header& header, std::optional<std::string>& frame);

/// Mounting of the sensor of `frame` on the robot; without a transform, at its centre, with a note.
/// Errors: not level.
[[nodiscard]] Result<LevelMounting> mounting_of(const FrameTree& tree, const std::string& base,
                                                const std::string& frame, io::Problems& problems);

}  // namespace wayfare::ros
