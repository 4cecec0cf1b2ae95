#pragma once

// What is known of the receiver's clocks: which satellite system keeps the time, which others have
// been met, and whether it has jumped.

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

  /// Makes the filter ready for the ranges of an epoch. False where no clock can be known yet;
  /// `said` is what there is to tell, or empty.
  [[nodiscard]] bool prepare(InsRangeFilter& filter, const RangeEpoch& epoch, std::string& said);

  /// Which further clock of the filter a system has; −1 for the one that keeps the time.
  [[nodiscard]] int offset_of(GnssSystem system) const;
  [[nodiscard]] double range_sigma_m(const CorrectedRange& s) const {
    return s.range_sigma_m * sigma_scale_;
  }
  [[nodiscard]] double rate_sigma_mps(const CorrectedRange& s) const {
    return s.range_rate_sigma_mps * sigma_scale_;
  }

 private:
  /// Where measurements stand against their prediction before any of them is used.
  struct Residuals {
    std::vector<double> innovation, sigma;
  };

  void set(InsRangeFilter& filter, const RangeEpoch& epoch);
  void meet_new_systems(InsRangeFilter& filter, const RangeEpoch& epoch);
  /// By how much, or zero.
  double mend_jump(InsRangeFilter& filter, const RangeEpoch& epoch) const;
  [[nodiscard]] Residuals ranges(const InsRangeFilter& filter, const RangeEpoch& epoch) const;
  [[nodiscard]] Residuals rates(const InsRangeFilter& filter, const RangeEpoch& epoch) const;
  [[nodiscard]] bool& met(GnssSystem system) { return met_[static_cast<std::size_t>(system)]; }

  double sigma_scale_, gate_sigma_;
  bool known_ = false;
  GnssSystem reference_ = GnssSystem::gps;
  std::array<bool, kGnssSystems> met_{};
};

}  // namespace wayfare::nav
