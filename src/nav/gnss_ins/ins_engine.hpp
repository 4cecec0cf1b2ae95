#pragma once

// The filter and all that it remembers between measurements, as one value that can be copied: a
// late measurement goes back to a copy and lives the time since again.

#include <array>
#include <optional>
#include <string>
#include <vector>

#include <wayfare/nav/gnss_ins.hpp>
#include <wayfare/nav/ins_filter.hpp>

#include "nav/gnss_ins/receiver_clocks.hpp"
#include "nav/gnss_ins/recent_readings.hpp"
#include "nav/gnss_ins/zero_velocity_detector.hpp"

namespace wayfare::nav {

/// What the engine tells about: nothing while it lives time again.
struct Diary {
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
  /// To `sample`'s time; `in_gap`: readings between are missing.
  void advance(const ImuSample& sample, bool in_gap, Diary& diary);
  void apply(const RangeEpoch& epoch, Diary& diary);
  void apply(const GnssFix& fix, Diary& diary);

  [[nodiscard]] GnssInsEstimate estimate() const;
  [[nodiscard]] GnssInsPoint point() const;
  /// Measurements have disagreed for so long that starting anew is better.
  [[nodiscard]] bool lost() const { return lost_; }

 private:
  /// Doubt: how long measurements of one kind have been refused.
  struct Doubt {
    std::optional<LogTime> since;
  };

  void predict(const ImuInterval& imu, bool in_gap);
  void add_vibration(double dt_s);
  void constrain(Diary& diary);
  void hold_still(Diary& diary);
  void hold_wheels(Diary& diary);
  void note_full_epoch();
  void record(Diary& diary, InnovationRecord::Kind kind, SatelliteId id,
              const ScalarUpdate<double>& u) const;
  void reopen(Doubt& doubt, int accepted, int total, Diary& diary);
  [[nodiscard]] NavState nav() const;

  GnssInsOptions options_;
  Filter filter_;
  ImuSample last_;
  RecentReadings recent_;
  ZeroVelocityDetector zero_velocity_;
  std::optional<LogTime> last_hold_, last_full_epoch_;
  double epoch_interval_s_ = 1.0;
  bool lost_ = false;
  ReceiverClocks clocks_;
  Doubt range_doubt_, rate_doubt_;
};

}  // namespace wayfare::nav
