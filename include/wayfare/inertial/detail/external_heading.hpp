#pragma once

// External headings, for example from a map, as possibly delayed measurements of the AHRS's
// attitude and, through their covariance, gyro bias.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <optional>

#include <Eigen/Core>

#include <wayfare/core/angle.hpp>
#include <wayfare/core/time.hpp>
#include <wayfare/inertial/ahrs_parameters.hpp>
#include <wayfare/inertial/attitude.hpp>
#include <wayfare/inertial/detail/ahrs_filter.hpp>

namespace wayfare {

/// Recent heading changes from the gyro alone, as sums over its readings, to use delayed headings.
/// No heap allocation.
class HeadingTrack {
 public:
  /// Since the beginning: heading change without bias correction, rad; its derivative by minus the
  /// bias along each body axis, s; variance gained by noise, rad².
  struct Sum {
    double angle = 0.0;                                 ///< heading change, rad
    Eigen::Vector3d by_bias = Eigen::Vector3d::Zero();  ///< s
    double variance = 0.0;                              ///< rad²

    /// Of consecutive intervals.
    Sum operator+(const Sum& o) const {
      return {angle + o.angle, by_bias + o.by_bias, variance + o.variance};
    }
    /// Of the interval between.
    Sum operator-(const Sum& o) const {
      return {angle - o.angle, by_bias - o.by_bias, variance - o.variance};
    }
    /// Of a part of the interval.
    Sum operator*(double k) const { return {k * angle, k * by_bias, k * variance}; }
    /// Heading change corrected for a bias.
    [[nodiscard]] double rotation(const Eigen::Vector3d& bias) const {
      return angle - by_bias.dot(bias);
    }
  };

  /// Keeps `history_s`; zero: nothing.
  explicit HeadingTrack(double history_s)
      : history_s_(history_s), spacing_s_(history_s / double(kEntries - 3)) {}

  /// Whether a history is kept.
  [[nodiscard]] bool on() const { return history_s_ > 0.0; }
  /// Before another start.
  void forget() { count_ = 0; }

  /// Adds one reading's part, valid at `time`; times increase.
  void add(LogTime time, const Sum& part) {
    sum_ = sum_ + part;
    if (count_ < 2 || to_seconds(entry(0).time - entry(1).time) >= spacing_s_) {
      newest_ = (newest_ + 1) % kEntries;
      count_ = std::min(count_ + 1, kEntries);
    }
    entries_[newest_] = {time, sum_};
  }

  /// Since the beginning.
  [[nodiscard]] const Sum& now() const { return sum_; }
  /// Interpolated between readings and extrapolated briefly beyond the last; none if further in the
  /// future or older than the history.
  [[nodiscard]] std::optional<Sum> at(LogTime time) const {
    if (count_ == 0 || to_seconds(entry(0).time - time) > history_s_) return std::nullopt;
    if (time == entry(0).time) return entry(0).sum;
    if (to_seconds(time - entry(0).time) > kAhead_s) return std::nullopt;
    for (std::size_t age = 1; age < count_; ++age)
      if (entry(age).time <= time || (age == 1 && time > entry(0).time))
        return between(entry(age), entry(age - 1), time);
    return std::nullopt;
  }
  /// Whether `time` is beyond the extrapolation.
  [[nodiscard]] bool in_future(LogTime time) const {
    return count_ == 0 || to_seconds(time - entry(0).time) > kAhead_s;
  }

 private:
  static constexpr std::size_t kEntries = 256;
  static constexpr double kAhead_s = 0.05;
  struct Entry {
    LogTime time;
    Sum sum;
  };

  [[nodiscard]] const Entry& entry(std::size_t age) const {
    return entries_[(newest_ + kEntries - age) % kEntries];
  }
  static Sum between(const Entry& a, const Entry& b, LogTime time) {
    return a.sum + (b.sum - a.sum) * (to_seconds(time - a.time) / to_seconds(b.time - a.time));
  }

  double history_s_, spacing_s_;
  Sum sum_;
  std::array<Entry, kEntries> entries_{};
  std::size_t newest_ = 0, count_ = 0;
};

/// External heading of the body's AhrsParameters::heading_axis.
struct HeadingFix {
  LogTime time;           ///< of validity; up to AhrsParameters::heading_history_s ago
  Angle compass;          ///< clockwise from the AHRS's north
  double variance = 0.0;  ///< rad², of an error independent between fixes
};

/// Heading of a body axis in east-north-up.
template <class T>
struct AxisHeading {
  T radians;                   ///< counter-clockwise from east
  Eigen::Matrix<T, 3, 1> row;  ///< its derivative by a rotation about the world axes
  bool level;                  ///< not within 8° of the vertical: the heading is defined

  /// With w = R·axis and w' = θ×w: ψ' = (wₓw'ᵧ − wᵧw'ₓ)/(wₓ² + wᵧ²).
  static AxisHeading of(const Eigen::Matrix<T, 3, 3>& r_enu_body,
                        const Eigen::Matrix<T, 3, 1>& axis) {
    const Eigen::Matrix<T, 3, 1> w = r_enu_body * axis;
    const T flat2 = w.template head<2>().squaredNorm();
    constexpr T kLeast2 = T(0.02);
    if (!(flat2 > kLeast2 * w.squaredNorm())) return {T(0), {T(0), T(0), T(1)}, false};
    const T up = w.z() / flat2;
    return {std::atan2(w.y(), w.x()), {-w.x() * up, -w.y() * up, T(1)}, true};
  }
};

/// The heading ψₛ at an earlier time is the current one less the gyro's rotation since: ψₛ = ψ −
/// (Σω − Σh·b) − w. The fix therefore measures ψ and the bias b with the row (h, Σh), and its error
/// is correlated with the state through the gyro noise w since then, as far as other measurements
/// have not removed it from the heading, which the gain accounts for.
/// Equivalent to stochastic cloning (Roumeliotis and Burdick 2002) if only the gyro changed the
/// heading in between.
template <class T>
class ExternalHeading {
 public:
  using Vector = Eigen::Matrix<T, 3, 1>;  ///< of three components
  using Filter = AhrsFilter<T>;           ///< state and covariance

  /// What became of a fix.
  struct Outcome {
    UpdateStatus status = UpdateStatus::used;  ///< used, or why not
    bool reset = false;                        ///< heading unknown or lost: rotate it by `off`
    T off = T(0),                              ///< rad
        sigma = T(0);                          ///< its standard deviation
  };

  /// Without a history where AhrsParameters::heading_history_s is zero.
  explicit ExternalHeading(const AhrsParameters& p)
      : axis_(p.heading_axis.template cast<T>()),
        gate2_(T(p.heading_gate_sigmas * p.heading_gate_sigmas)),
        patience_s_(p.lost_heading_s),
        track_(p.heading_history_s) {}

  /// Whether external headings are used.
  [[nodiscard]] bool on() const { return track_.on(); }
  /// Heading changes by the gyro.
  [[nodiscard]] const HeadingTrack& track() const { return track_; }
  /// Heading of the axis now.
  [[nodiscard]] AxisHeading<T> now(const Filter& filter) const {
    return AxisHeading<T>::of(filter.rotation(), axis_);
  }
  /// Normalised innovation squared of the last fix gated.
  [[nodiscard]] T nis() const { return nis_; }

  /// Discards the history, after a restart of the attitude.
  void forget() {
    track_.forget();
    last_.reset();
    rejected_.reset();
    settled_ = track_.now().variance;
  }

  /// Called before a reading rotates the filter for dt; the result is passed to end_turn() after
  /// it.
  struct Turn {
    T radians;               ///< heading before the turn
    HeadingTrack::Sum part;  ///< of the gyro's noise and bias
  };
  /// Before the turn.
  [[nodiscard]] Turn begin_turn(const Filter& filter, T dt, T angle_variance) const {
    const AxisHeading<T> from = now(filter);
    const Vector by_bias = filter.rotation().transpose() * from.row * dt;
    return {from.radians,
            {double(by_bias.dot(filter.bias())), by_bias.template cast<double>(),
             double(angle_variance * from.row.squaredNorm())}};
  }
  /// After the turn, at the time of its reading.
  void end_turn(LogTime time, Turn turn, const Filter& filter) {
    turn.part.angle += double(wrap_to_pi(now(filter).radians - turn.radians));
    track_.add(time, turn.part);
  }

  /// `known`: whether the filter has a heading.
  Outcome update(Filter& filter, const HeadingFix& fix, bool known) {
    if (!std::isfinite(fix.compass.radians()) || !std::isfinite(fix.variance) ||
        !(fix.variance > 0.0))
      return {UpdateStatus::missing};
    const auto then = track_.at(fix.time);
    if (!then) return {track_.in_future(fix.time) ? UpdateStatus::waiting : UpdateStatus::late};
    if (last_ && fix.time <= *last_) return {UpdateStatus::late};
    const AxisHeading<T> here = now(filter);
    if (!here.level) return {UpdateStatus::waiting};
    last_ = fix.time;
    const HeadingTrack::Sum since = track_.now() - *then;
    const T rotation = T(since.rotation(filter.bias().template cast<double>()));
    const T off =
        wrap_to_pi(T(std::numbers::pi / 2 - fix.compass.radians()) + rotation - here.radians);
    const T variance = T(fix.variance + std::abs(since.variance));
    if (!known) return reset(off, variance);
    const Vector b = since.by_bias.template cast<T>();
    const Row row{{here.row[0], here.row[1], here.row[2], b[0], b[1], b[2]}};
    // The last fix has removed the correlation from before it.
    const T shared = filter.consistent_share(
        T(std::clamp(since.variance, 0.0, std::max(track_.now().variance - settled_, 0.0))),
        variance);
    const T expected = std::max(filter.variance_of(row) - T(2) * shared, T(0)) + variance;
    nis_ = off * off / expected;
    if (nis_ > gate2_) return reject(fix, off, variance);
    filter.observe_shared(row, off, variance, shared);
    filter.apply();
    settle();
    return {};
  }

  /// The heading was updated: gyro noise from before is no longer shared.
  void settle() {
    settled_ = track_.now().variance;
    rejected_.reset();
  }

 private:
  using Row = IndexedRow<T, 0, 1, 2, 3, 4, 5>;
  struct Rejected {
    LogTime since;
    T off;
  };

  Outcome reset(T off, T variance) {
    settle();
    return {UpdateStatus::used, true, off, std::sqrt(variance)};
  }

  /// Rejected fixes that agree with each other for long enough reset the heading.
  Outcome reject(const HeadingFix& fix, T off, T variance) {
    constexpr T kConsistent = T(3);  // standard deviations of the fix
    const bool consistent =
        rejected_ && square(wrap_to_pi(off - rejected_->off)) < square(kConsistent) * variance;
    if (!consistent) rejected_ = Rejected{fix.time, off};
    rejected_->off = off;
    if (to_seconds(fix.time - rejected_->since) < patience_s_) return {UpdateStatus::disturbed};
    return reset(off, variance);
  }
  static T square(T x) { return x * x; }

  Vector axis_;
  T gate2_;
  double patience_s_;
  HeadingTrack track_;
  double settled_ = 0.0;  // the track's variance at the last fix that was used
  std::optional<LogTime> last_;
  std::optional<Rejected> rejected_;
  T nis_ = std::numeric_limits<T>::quiet_NaN();
};

}  // namespace wayfare
