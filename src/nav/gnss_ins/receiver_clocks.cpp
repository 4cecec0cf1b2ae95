#include "nav/gnss_ins/receiver_clocks.hpp"

#include <algorithm>
#include <cmath>

#include <wayfare/core/statistics.hpp>

namespace wayfare::nav {
namespace {

constexpr double kLightMillisecond_m = 299792.458;
constexpr double kUnknownClock_m2 = 1e4;

double robust_sigma(const std::vector<double>& v, double centre) {
  std::vector<double> d;
  for (double x : v) d.push_back(std::abs(x - centre));
  return 1.4826 * upper_median_of(d);
}

RangeEpoch of_system(const RangeEpoch& epoch, GnssSystem system) {
  RangeEpoch own{epoch.time, {}};
  for (const CorrectedRange& s : epoch.satellites)
    if (s.satellite.system == system) own.satellites.push_back(s);
  return own;
}

/// Innovations and their sigmas of the usable measurements.
template <class Residuals, class Usable, class ModelOf>
Residuals residuals(const InsRangeFilter& filter, const RangeEpoch& epoch, const Usable& usable,
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
void restart(InsRangeFilter& filter, int i, double step, double variance) {
  InsRangeFilter::State x = filter.state();
  x.clock[i] += step;
  filter.ekf().set_state(x);
  filter.ekf().reset_variance(ins_state::kClock + i, variance);
}

}  // namespace

int ReceiverClocks::offset_of(GnssSystem system) const {
  if (system == reference_) return -1;
  const int i = static_cast<int>(system);
  return i < static_cast<int>(reference_) ? i : i - 1;
}

ReceiverClocks::Residuals ReceiverClocks::ranges(const InsRangeFilter& filter,
                                                 const RangeEpoch& epoch) const {
  return residuals<Residuals>(filter, epoch, has_range, [&](const CorrectedRange& s) {
    return filter.range_model(s, range_sigma_m(s), offset_of(s.satellite.system));
  });
}

ReceiverClocks::Residuals ReceiverClocks::rates(const InsRangeFilter& filter,
                                                const RangeEpoch& epoch) const {
  return residuals<Residuals>(filter, epoch, has_rate, [&](const CorrectedRange& s) {
    return filter.range_rate_model(s, rate_sigma_mps(s));
  });
}

bool ReceiverClocks::prepare(InsRangeFilter& filter, const RangeEpoch& epoch, std::string& notice) {
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

void ReceiverClocks::set(InsRangeFilter& filter, const RangeEpoch& epoch) {
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
  restart(filter, 1, drifts ? upper_median_of(rate.innovation) : 0.0, drifts ? 1e2 : 1e6);
  known_ = true;
  initialised_ = {};
  initialised(reference_) = true;
}

void ReceiverClocks::add_new_systems(InsRangeFilter& filter, const RangeEpoch& epoch) {
  for (int i = 0; i < kGnssSystems; ++i) {
    const auto system = static_cast<GnssSystem>(i);
    if (initialised(system)) continue;
    Residuals range = ranges(filter, of_system(epoch, system));
    if (range.innovation.empty()) continue;
    restart(filter, 2 + offset_of(system), upper_median_of(range.innovation), kUnknownClock_m2);
    initialised(system) = true;
  }
}

double ReceiverClocks::correct_jump(InsRangeFilter& filter, const RangeEpoch& epoch) const {
  Residuals range = ranges(filter, epoch);
  if (range.innovation.empty()) return 0.0;
  const double shift = upper_median_of(range.innovation), sigma = upper_median_of(range.sigma);
  const double scatter = robust_sigma(range.innovation, shift);
  const double whole = std::round(shift / kLightMillisecond_m) * kLightMillisecond_m;
  const bool millisecond =
      whole != 0.0 && std::abs(shift - whole) < std::max(100.0, gate_sigma_ * sigma);
  const bool common = range.innovation.size() >= 4 && std::abs(shift) > 30.0 &&
                      std::abs(shift) > gate_sigma_ * sigma && scatter < 0.2 * std::abs(shift);
  if (!millisecond && !common) return 0.0;
  filter.jump_clock(millisecond && !common ? whole : shift, 30.0);
  return shift;
}

}  // namespace wayfare::nav
