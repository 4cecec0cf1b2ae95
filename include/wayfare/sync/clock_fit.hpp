#pragma once

// Linear relation of two clocks of constant rate, from pairs of stamps of the same instants.

#include <cmath>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/core/time.hpp>

namespace wayfare {

/// One instant on a device's clock and on the recording's.
template <class Device>
struct ClockPair {
  Time<Device> device;
  LogTime log;
};

struct ClockFitOptions {
  /// Stamps on the log's clock are late, never early, by a varying delay (messages wait to be
  /// read): the line is then fitted to the earliest ones instead of the mean.
  bool late = false;
  /// Pairs further from the line than this many standard deviations are rejected.
  double gate_sigma = 3.0;
  int rounds = 8;
};

/// log = log_origin + rate · (device − device_origin).
template <class Device>
struct ClockFit {
  Time<Device> device_origin;
  LogTime log_origin;
  double rate = 1.0;
  double residual_s = 0.0;  ///< standard deviation of the pairs used
  std::size_t used = 0;

  [[nodiscard]] LogTime operator()(Time<Device> device) const {
    const double since_s = to_seconds(device - device_origin);
    return log_origin + (device - device_origin) + from_seconds((rate - 1.0) * since_s);
  }
};

/// Iterated least squares with outlier rejection. Requires two distinct instants.
template <class Device>
[[nodiscard]] Result<ClockFit<Device>> fit_clock(std::span<const ClockPair<Device>> pairs,
                                                 const ClockFitOptions& options = {}) {
  const Error degenerate{ErrorCode::degenerate,
                         "a clock fit requires stamps of at least two instants"};
  if (pairs.size() < 2) return degenerate;
  ClockFit<Device> fit;
  fit.device_origin = pairs.front().device;
  fit.log_origin = pairs.front().log;
  const LogTime log_start = pairs.front().log;
  std::vector<char> used(pairs.size(), 1);
  const auto x = [&](std::size_t i) { return to_seconds(pairs[i].device - fit.device_origin); };
  // The log's clock minus the device's: small numbers.
  const auto y = [&](std::size_t i) { return to_seconds(pairs[i].log - log_start) - x(i); };
  double slope = 0.0, offset = 0.0;
  for (int round = 0; round < options.rounds; ++round) {
    double n = 0.0, mx = 0.0, my = 0.0, sxx = 0.0, sxy = 0.0, squares = 0.0;
    for (std::size_t i = 0; i < pairs.size(); ++i)
      if (used[i] != 0) n += 1.0, mx += x(i), my += y(i);
    mx /= n, my /= n;
    for (std::size_t i = 0; i < pairs.size(); ++i)
      if (used[i] != 0) sxx += (x(i) - mx) * (x(i) - mx), sxy += (x(i) - mx) * (y(i) - my);
    if (!(n >= 2.0) || !(sxx > 0.0)) return degenerate;
    slope = sxy / sxx;
    offset = my - slope * mx;
    const auto residual = [&](std::size_t i) { return y(i) - offset - slope * x(i); };
    for (std::size_t i = 0; i < pairs.size(); ++i)
      if (used[i] != 0) squares += residual(i) * residual(i);
    fit.used = static_cast<std::size_t>(n);
    fit.residual_s = std::sqrt(squares / n);
    if (round + 1 == options.rounds) break;
    std::size_t kept = 0;
    std::vector<char> next(pairs.size(), 0);
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      const double upper =
          options.late ? 0.5 * fit.residual_s : options.gate_sigma * fit.residual_s;
      next[i] = residual(i) <= upper && residual(i) >= -options.gate_sigma * fit.residual_s;
      kept += next[i] != 0 ? 1 : 0;
    }
    // The line through the earliest stamps uses at least a tenth of all.
    if (kept < 2 || (options.late && 10 * kept < pairs.size())) break;
    used = std::move(next);
  }
  fit.rate = 1.0 + slope;
  fit.log_origin = log_start + from_seconds(offset);
  return fit;
}

}  // namespace wayfare
