#pragma once

// Receiver clock handling: reference system, initialisation of the other systems' offsets, and
// clock jumps.

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include <wayfare/nav/gnss_ins.hpp>
#include <wayfare/nav/ins_filter.hpp>

namespace wayfare::nav {

inline constexpr int kOffsets = kGnssSystems - 1;
using InsRangeFilter = InsFilter<double, kOffsets>;

[[nodiscard]] inline bool has_range(const CorrectedRange& s) {
  return std::isfinite(s.range_m) && s.position_ecef_m.allFinite() && s.range_sigma_m > 0.0;
}
[[nodiscard]] inline bool has_rate(const CorrectedRange& s) {
  return std::isfinite(s.range_rate_mps) && s.position_ecef_m.allFinite() &&
         s.velocity_ecef_mps.allFinite() && s.range_rate_sigma_mps > 0.0;
}

class ReceiverClocks {
 public:
  ReceiverClocks(double range_sigma_scale, double gate_sigma)
      : sigma_scale_(range_sigma_scale), gate_sigma_(gate_sigma) {}

  /// Initialises the filter's clocks for the ranges of an epoch. False if no clock can be
  /// determined yet; `notice` is set on events.
  [[nodiscard]] bool prepare(InsRangeFilter& filter, const RangeEpoch& epoch, std::string& notice);

  /// Index of a system's clock offset; −1 for the reference system.
  [[nodiscard]] int offset_of(GnssSystem system) const;
  [[nodiscard]] double range_sigma_m(const CorrectedRange& s) const {
    return s.range_sigma_m * sigma_scale_;
  }
  [[nodiscard]] double rate_sigma_mps(const CorrectedRange& s) const {
    return s.range_rate_sigma_mps * sigma_scale_;
  }

 private:
  /// Innovations before any update.
  struct Residuals {
    std::vector<double> innovation, sigma;
  };

  void set(InsRangeFilter& filter, const RangeEpoch& epoch);
  void add_new_systems(InsRangeFilter& filter, const RangeEpoch& epoch);
  /// Returns the jump, or zero.
  double correct_jump(InsRangeFilter& filter, const RangeEpoch& epoch) const;
  [[nodiscard]] Residuals ranges(const InsRangeFilter& filter, const RangeEpoch& epoch) const;
  [[nodiscard]] Residuals rates(const InsRangeFilter& filter, const RangeEpoch& epoch) const;
  [[nodiscard]] bool& initialised(GnssSystem system) {
    return initialised_[static_cast<std::size_t>(system)];
  }

  double sigma_scale_, gate_sigma_;
  bool known_ = false;
  GnssSystem reference_ = GnssSystem::gps;
  std::array<bool, kGnssSystems> initialised_{};
};

}  // namespace wayfare::nav
