#pragma once

// The filter with all its memory as one copyable value, so that late measurements are processed by
// replay from a copy.

#include <array>
#include <optional>
#include <string>
#include <vector>

#include <wayfare/nav/gnss_ins.hpp>
#include <wayfare/nav/ins_filter.hpp>

#include "nav/gnss_ins/receiver_clocks.hpp"
#include "nav/gnss_ins/zero_velocity_detector.hpp"

namespace wayfare::nav {

/// Innovations and notices; closed during replay.
struct EventLog {
  std::vector<InnovationRecord> innovations;
  std::vector<GnssInsNotice> notices;
  bool open = true;

  void note(LogTime time, std::string text) {
    if (open) notices.push_back({time, std::move(text)});
  }
};

class InsEngine {
 public:
  using Filter = InsRangeFilter;
  using State = Filter::State;

  InsEngine(const GnssInsOptions& options, const GnssInsStart& start, const ImuSample& first);

  [[nodiscard]] LogTime time() const { return last_.time; }
  [[nodiscard]] const ImuSample& last_sample() const { return last_; }
  /// Propagates to `sample`'s time; `in_gap`: readings in between are missing.
  void advance(const ImuSample& sample, bool in_gap, EventLog& events);
  void apply(const RangeEpoch& epoch, EventLog& events);
  void apply(const GnssFix& fix, EventLog& events);

  [[nodiscard]] GnssInsEstimate estimate() const;
  [[nodiscard]] GnssInsPoint point() const;
  /// Measurements have been rejected for so long that the filter should be reinitialised.
  [[nodiscard]] bool lost() const { return lost_; }

 private:
  void predict(const ImuInterval& imu, bool in_gap);
  void add_vibration(double dt_s);
  void constrain(EventLog& events);
  void update_standstill(EventLog& events);
  void update_non_holonomic(EventLog& events);
  void note_full_epoch();
  void record(EventLog& events, InnovationRecord::Kind kind, SatelliteId id,
              const ScalarUpdate<double>& u) const;
  /// Inflates the covariance after long rejection; `since`: start of the rejections.
  void reopen(std::optional<LogTime>& since, int accepted, int total, EventLog& events);
  [[nodiscard]] NavState nav() const;

  GnssInsOptions options_;
  Filter filter_;
  ImuSample last_;
  RecentReadings recent_;
  ZeroVelocityDetector zero_velocity_;
  std::optional<LogTime> last_constraint_, last_full_epoch_;
  double epoch_interval_s_ = 1.0;
  bool lost_ = false;
  ReceiverClocks clocks_;
  std::optional<LogTime> ranges_rejected_since_, rates_rejected_since_;
};

}  // namespace wayfare::nav
