#pragma once

// Receiver clock handling: reference system, initialisation of the other systems' offsets, and
// clock jumps.

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include <wayfare/core/statistics.hpp>
#include <wayfare/nav/gnss_ins.hpp>
#include <wayfare/nav/ins_filter.hpp>

#include "nav/gnss_ins/correlated_errors.hpp"

namespace wayfare::nav {

inline constexpr int kOffsets = kGnssSystems - 1;
/// With further blocks of states.
template <class... Further>
using InsRangeFilter =
    InsFilter<double, kOffsets, CorrelatedErrors<InsState<double, kOffsets, Further...>>,
              Further...>;

/// Multiplies standard deviations of the state's errors by 1.5, with the correlations as they are.
template <class Filter>
void inflate(Filter& filter, int first, int count) {
  filter.ekf().scale_sigma(first, count, 1.5);
  filter.ekf().recorder().scale_sigma(first, count, 1.5);
}

// Of these values: finite, and within limits that exclude overflow and the loss of all digits.
[[nodiscard]] inline bool is_usable_sigma(double sigma) { return sigma > 1e-6 && sigma < 1e9; }
[[nodiscard]] inline bool has_range(const CorrectedRange& s) {
  return std::abs(s.range_m) < 1e12 && s.position_ecef_m.squaredNorm() < 1e20 &&
         is_usable_sigma(s.range_sigma_m);
}
[[nodiscard]] inline bool has_rate(const CorrectedRange& s) {
  return std::abs(s.range_rate_mps) < 1e8 && s.position_ecef_m.squaredNorm() < 1e20 &&
         s.velocity_ecef_mps.squaredNorm() < 1e16 && is_usable_sigma(s.range_rate_sigma_mps);
}

class ReceiverClocks {
 public:
  ReceiverClocks(double range_sigma_scale, double gate_sigma)
      : sigma_scale_(range_sigma_scale), gate_sigma_(gate_sigma) {}

  /// Initialises the filter's clocks for the ranges of an epoch. False if no clock can be
  /// determined yet; `notice` is set on events.
  template <class F>
  [[nodiscard]] bool prepare(F& filter, const RangeEpoch& epoch, std::string& notice) {
    if (!known_) {
      set(filter, epoch);
      if (!known_) return false;
      notice = "receiver clock set from the first ranges";
    }
    add_new_systems(filter, epoch);
    const double jump_m = correct_jump(filter, epoch);
    if (jump_m != 0.0)
      notice = "receiver clock jumped by " + std::to_string(std::llround(jump_m)) + " m";
    return true;
  }

  /// Index of a system's clock offset; −1 for the reference system.
  [[nodiscard]] int offset_of(GnssSystem system) const {
    if (system == reference_) return -1;
    const int i = static_cast<int>(system);
    return i < static_cast<int>(reference_) ? i : i - 1;
  }

  [[nodiscard]] double range_sigma_m(const CorrectedRange& s) const {
    return s.range_sigma_m * sigma_scale_;
  }
  [[nodiscard]] double rate_sigma_mps(const CorrectedRange& s) const {
    return s.range_rate_sigma_mps * sigma_scale_;
  }

 private:
  static constexpr double kLightMillisecond_m = 299792.458;
  static constexpr double kUnknownClock_m2 = 1e4;

  /// Innovations before any update, and their standard deviations.
  struct Residuals {
    std::vector<double> innovation, sigma;
  };

  static RangeEpoch of_system(const RangeEpoch& epoch, GnssSystem system) {
    RangeEpoch own{epoch.time, {}};
    for (const CorrectedRange& s : epoch.satellites)
      if (s.satellite.system == system) own.satellites.push_back(s);
    return own;
  }

  /// Of the usable measurements.
  template <class F, class Usable, class ModelOf>
  static Residuals residuals(const F& filter, const RangeEpoch& epoch, const Usable& usable,
                             const ModelOf& model_of) {
    Residuals r;
    for (const CorrectedRange& s : epoch.satellites) {
      if (!usable(s)) continue;
      const auto m = model_of(s)(filter.state());
      if (!std::isfinite(m.innovation)) continue;
      r.innovation.push_back(m.innovation);
      r.sigma.push_back(filter.ekf().predicted_sigma(m));
    }
    return r;
  }

  /// Adds `step` to clock `i` of the state and resets its variance.
  template <class F>
  static void restart(F& filter, int i, double step, double variance) {
    typename F::State x = filter.state();
    x.clock[i] += step;
    filter.ekf().set_state(x);
    filter.ekf().reset_variance(ins_state::kClock + i, variance);
  }

  template <class F>
  void set(F& filter, const RangeEpoch& epoch) {
    std::array<int, kGnssSystems> count{};
    for (const CorrectedRange& s : epoch.satellites)
      if (has_range(s)) ++count[static_cast<std::size_t>(s.satellite.system)];
    const auto most = std::max_element(count.begin(), count.end());
    if (*most == 0) return;
    reference_ = static_cast<GnssSystem>(most - count.begin());
    const RangeEpoch own = of_system(epoch, reference_);
    Residuals range = ranges(filter, own), rate = rates(filter, own);
    if (range.innovation.empty()) return;
    filter.jump_clock(upper_median_of(range.innovation), 0.0);
    filter.ekf().reset_variance(ins_state::kClock, kUnknownClock_m2);
    const bool drifts = !rate.innovation.empty();
    restart(filter, 1, upper_median_of(rate.innovation), drifts ? 1e2 : 1e6);
    known_ = true;
    initialised_ = {};
    initialised(reference_) = true;
  }

  template <class F>
  void add_new_systems(F& filter, const RangeEpoch& epoch) {
    for (int i = 0; i < kGnssSystems; ++i) {
      const auto system = static_cast<GnssSystem>(i);
      if (initialised(system)) continue;
      Residuals range = ranges(filter, of_system(epoch, system));
      if (range.innovation.empty()) continue;
      restart(filter, 2 + offset_of(system), upper_median_of(range.innovation), kUnknownClock_m2);
      initialised(system) = true;
    }
  }

  /// Returns the jump, or zero.
  template <class F>
  double correct_jump(F& filter, const RangeEpoch& epoch) const {
    Residuals range = ranges(filter, epoch);
    if (range.innovation.empty()) return 0.0;
    const double shift = upper_median_of(range.innovation), sigma = upper_median_of(range.sigma);
    for (double& x : range.innovation) x = std::abs(x - shift);
    const double scatter = 1.4826 * upper_median_of(range.innovation);
    const double whole = std::round(shift / kLightMillisecond_m) * kLightMillisecond_m;
    const bool millisecond =
        whole != 0.0 && std::abs(shift - whole) < std::max(100.0, gate_sigma_ * sigma);
    const bool common = range.innovation.size() >= 4 && std::abs(shift) > 30.0 &&
                        std::abs(shift) > gate_sigma_ * sigma && scatter < 0.2 * std::abs(shift);
    if (!millisecond && !common) return 0.0;
    filter.jump_clock(millisecond && !common ? whole : shift, 30.0);
    return shift;
  }

  template <class F>
  [[nodiscard]] Residuals ranges(const F& filter, const RangeEpoch& epoch) const {
    return residuals(filter, epoch, has_range, [&](const CorrectedRange& s) {
      return filter.range_model(s, range_sigma_m(s), offset_of(s.satellite.system));
    });
  }

  template <class F>
  [[nodiscard]] Residuals rates(const F& filter, const RangeEpoch& epoch) const {
    return residuals(filter, epoch, has_rate, [&](const CorrectedRange& s) {
      return filter.range_rate_model(s, rate_sigma_mps(s));
    });
  }

  [[nodiscard]] bool& initialised(GnssSystem system) {
    return initialised_[static_cast<std::size_t>(system)];
  }

  double sigma_scale_, gate_sigma_;
  bool known_ = false;
  GnssSystem reference_ = GnssSystem::gps;
  std::array<bool, kGnssSystems> initialised_{};
};

}  // namespace wayfare::nav
