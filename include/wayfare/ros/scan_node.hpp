#pragma once

// Base of the nodes that process scans: queues of scans and odometry in order of time, the mounting
// of the sensors, and waiting for what is missing.

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <wayfare/core/frame.hpp>
#include <wayfare/core/result.hpp>
#include <wayfare/core/se2.hpp>
#include <wayfare/core/time.hpp>
#include <wayfare/ros/convert.hpp>
#include <wayfare/ros/detail/node_output.hpp>
#include <wayfare/ros/messages.hpp>
#include <wayfare/sensors/measurements.hpp>
#include <wayfare/sensors/scans.hpp>

namespace wayfare::ros {

/// Frames, mounting of the laser and waiting of a node that processes scans.
struct ScanNodeOptions {
  std::string map_frame = "map",  ///< of poses and map
      odom_frame = "odom",        ///< of the odometry
      base_frame = "base_link";   ///< of the robot
  /// Mounting of the laser; if empty, from transforms.
  std::optional<Transform2<frame::Base, frame::Laser>> T_base_laser{};

  // Seconds by the caller's clock.
  double patience_s = 2.0;  ///< longest wait of a scan for other data of its time

  // Seconds by the messages' clock.
  double jump_back_s = 1.0;  ///< scans this much earlier than the last restart the node
  double post_date_s = 0.1;  ///< transforms are stamped later by this, to be valid until the next
  double particle_period_s = 0.5;    ///< between clouds of particles, where there is a filter
  double odometry_gap_s = 0.5;       ///< odometry older than this is not used for a scan
  std::size_t scans_waiting = 2000;  ///< capacity; the oldest are dropped
};

/// Queues and waiting of a node. Times `now_s` are of a monotonic clock with any origin. Not
/// thread-safe.
class ScanNode {
 public:
  /// The missing input; empty if none.
  [[nodiscard]] const std::string& waits_for() const { return waits_for_; }
  /// Messages that were left out, by what they are, such as "scan" or "odometry".
  [[nodiscard]] const std::map<std::string, std::uint64_t>& left_out() const { return left_out_; }

 protected:
  /// Scans of a sensor.
  template <class Scan>
  struct Sensed {
    std::deque<Scan> scans;                 ///< not processed yet
    std::optional<LogTime> last_received;   ///< time of the latest scan
    std::string frame;                      ///< of the first scan; others are dropped
    std::optional<LevelMounting> mounting;  ///< once known
  };
  /// A stream for which scans wait.
  struct Awaited {
    const char* name;               ///< in notices
    std::optional<LogTime> last{};  ///< heard
    bool silent = false;            ///< waited for in vain: not waited for until it is heard

    /// A sample of this time is there.
    void hear(LogTime time) { last = time, silent = false; }
  };
  /// What restarts where time goes back.
  struct Restart {
    std::string what;                      ///< in the notice, such as "begins a new map"
    std::function<void(LogTime at)> done;  ///< clears the queues
  };

  /// Without messages.
  explicit ScanNode(const ScanNodeOptions& options) : common_(options) {}

  /// Reports a message that is left out, and counts it by `kind`; `about` identifies the notice.
  void leave_out(const std::string& kind, const std::string& about, std::string text, double now_s,
                 Severity severity = Severity::error);
  /// Queues a scan if it is valid, of the sensor's frame and later than those before.
  template <class Scan>
  void enqueue(Sensed<Scan>& to, Result<Scan> scan, const Header& header, double now_s,
               const Restart& restart);
  /// Whether the mounting of a sensor is known, by `given` or by transforms; else waits for it.
  template <class Scan>
  [[nodiscard]] bool is_mounted(Sensed<Scan>& sensed, const std::optional<SE2d>& given,
                                double now_s);

  /// The sample of a message; nothing of one that is invalid, or not later than those before. A
  /// step back by more than `jump_back_s` drops those.
  [[nodiscard]] std::optional<OdometrySample> next_odometry(const Odometry& message, double now_s);
  /// Of a sample that is the next.
  void add_odometry(const OdometrySample& sample);
  /// Drops the samples after a time.
  void forget_odometry_after(LogTime time);
  /// At a time; nothing further than `odometry_gap_s` outside the samples.
  [[nodiscard]] std::optional<Transform2<frame::Odom, frame::Base>> odometry_at(LogTime time) const;
  /// The transform from map to odometry, post-dated.
  [[nodiscard]] TransformStamped map_to_odom(const SE2d& T_map_base, const SE2d& T_odom_base,
                                             LogTime time) const;

  /// Whether a cloud of particles is to be published at a time; if so, it is the last one.
  [[nodiscard]] bool cloud_is_due(LogTime time);

  /// Whether a stream has reached the time, or was waited for in vain.
  [[nodiscard]] bool has_reached(Awaited& stream, LogTime time, double now_s);
  /// `what` is missing: reported once it is missing for `patience_s`.
  void wait_for(std::string what, double now_s);
  /// Whether it is.
  [[nodiscard]] bool waited_in_vain(double now_s) const {
    return now_s >= *blocked_s_ + common_.patience_s;
  }
  /// Nothing is missing.
  void stop_waiting() { blocked_s_.reset(), waits_for_.clear(); }

  ScanNodeOptions common_;                ///< of all nodes
  FrameTree frames_;                      ///< by /tf and /tf_static
  std::vector<OdometrySample> odometry_;  ///< in order of time
  Awaited odometry_heard_{"odometry"};    ///< the latest of them
  Notices notices_;                       ///< not taken yet
  std::optional<LogTime> last_cloud_;     ///< of particles

 private:
  std::optional<double> blocked_s_;
  std::string waits_for_;
  std::map<std::string, std::uint64_t> left_out_;
};

}  // namespace wayfare::ros
