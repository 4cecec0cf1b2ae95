#pragma once

// Linear relation of two clocks of constant rate, from pairs of stamps of the same instants.
//
// Estimates a device's clock relative to the host's from arriving measurements: they are delayed by
// a varying time that is never below the minimum delay of the link, so that the line lies below all
// arrivals. Of the lines below them, the one with the smallest sum of distances touches the lower
// convex hull at the edge above the mean of the device's times (Moon, Skelly, Towsley 1999).

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <deque>
#include <span>
#include <string>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/core/time.hpp>

namespace wayfare {

/// One instant on a device's clock and on the recording's.
template <class Device>
struct ClockPair {
  Time<Device> device;  ///< time by the device's clock
  LogTime log;          ///< the same instant by the recording's
};

/// Rejection of outliers in fit_clock.
struct ClockFitOptions {
  /// Stamps on the log's clock are late, never early, by a varying delay (messages wait to be
  /// read): the line is then fitted to the earliest ones instead of the mean.
  bool late = false;
  /// Pairs further from the line than this many standard deviations are rejected.
  double gate_sigma = 3.0;
  int rounds = 8;  ///< of rejection and fit; at least one fit is made
};

/// log = log_origin + rate · (device − device_origin).
template <class Device>
struct ClockFit {
  Time<Device> device_origin;  ///< time of the first pair
  LogTime log_origin;          ///< the line's value at device_origin
  double rate = 1.0;           ///< seconds of the log per second of the device
  double residual_s = 0.0;     ///< standard deviation of the pairs used
  std::size_t used = 0;        ///< number of pairs the last fit used

  /// The log's time at which the device's clock showed `device`.
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
  const int rounds = std::max(options.rounds, 1);
  for (int round = 0; round < rounds; ++round) {
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
    if (round + 1 == rounds) break;
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

/// Window of arrivals and bounds of a ClockEnvelope.
struct ClockEnvelopeOptions {
  Duration window = std::chrono::seconds(60);        ///< older arrivals are dropped
  Duration bucket = std::chrono::milliseconds(250);  ///< the earliest arrival of each is used
  Duration settle = std::chrono::seconds(5);         ///< until then, equal rates are assumed
  Duration jump =
      std::chrono::seconds(1);  ///< a larger offset is taken for a restart of the device
  double max_drift = 5e-4;      ///< rates further from 1 are rejected
};

/// Host times of a device's stamps, from delayed arrivals, one after the other.
class ClockEnvelope {
 public:
  /// Without arrivals yet.
  explicit ClockEnvelope(const ClockEnvelopeOptions& options = {}) : options_(options) {}

  /// The time of a measurement with the device's stamp `device` that arrived at `arrived`, up to
  /// the minimum delay of the link; never later than the arrival.
  LogTime add(Time<DeviceClock> device, LogTime arrived) {
    if (!buckets_.empty()) {
      const Duration off = arrived - line_(device);
      const bool backwards = device < buckets_.back().device;
      if (off > options_.jump || off < -options_.jump || backwards) restart();
    }
    insert({device, arrived});
    return std::min(line_(device), arrived);
  }

  /// The current line; undefined before the first arrival.
  [[nodiscard]] LogTime operator()(Time<DeviceClock> device) const { return line_(device); }
  /// Seconds of the host per second of the device.
  [[nodiscard]] double rate() const { return line_.rate; }
  /// Number of resets of the fit: the device's clock jumped or ran backwards.
  [[nodiscard]] std::size_t restarts() const { return restarts_; }

 private:
  struct Arrival {
    Time<DeviceClock> device;
    LogTime log;
    [[nodiscard]] Duration ahead() const {
      return detail::saturated_difference(log.since_epoch(), device.since_epoch());
    }
  };

  void restart() {
    buckets_.clear();
    line_.rate = 1.0;
    ++restarts_;
  }

  void insert(const Arrival& a) {
    if (buckets_.empty() || a.device - bucket_start_ >= options_.bucket) {
      bucket_start_ = a.device;
      buckets_.push_back(a);
      while (a.device - buckets_.front().device > options_.window) buckets_.pop_front();
      fit();
    } else if (a.ahead() < buckets_.back().ahead()) {
      buckets_.back() = a;
    }
    // No measurement arrives before it was made.
    if (line_(a.device) > a.log) line_.log_origin = line_.log_origin - (line_(a.device) - a.log);
  }

  void fit() {
    const Arrival& first = buckets_.front();
    const auto x = [&](const Arrival& a) { return to_seconds(a.device - first.device); };
    const auto y = [&](const Arrival& a) {
      return to_seconds(detail::saturated_difference(a.ahead(), first.ahead()));
    };
    double mean = 0.0, least = 0.0;
    std::vector<const Arrival*> hull;
    for (const Arrival& a : buckets_) {
      mean += x(a) / static_cast<double>(buckets_.size());
      least = std::min(least, y(a));
      while (hull.size() >= 2) {
        const Arrival &p = *hull[hull.size() - 2], &q = *hull.back();
        if ((x(q) - x(p)) * (y(a) - y(p)) - (y(q) - y(p)) * (x(a) - x(p)) > 0.0) break;
        hull.pop_back();
      }
      hull.push_back(&a);
    }
    double slope = 0.0, offset = least;
    for (std::size_t i = 1; i < hull.size(); ++i) {
      const Arrival &p = *hull[i - 1], &q = *hull[i];
      if (x(q) < mean) continue;
      const double s = (y(q) - y(p)) / (x(q) - x(p));
      if (x(buckets_.back()) >= to_seconds(options_.settle) && std::abs(s) <= options_.max_drift) {
        slope = s;
        offset = y(p) - s * x(p);
      }
      break;
    }
    line_ = {first.device, first.log + from_seconds(offset), 1.0 + slope};
  }

  ClockEnvelopeOptions options_;
  std::deque<Arrival> buckets_;
  Time<DeviceClock> bucket_start_;
  ClockFit<DeviceClock> line_;
  std::size_t restarts_ = 0;
};

}  // namespace wayfare
