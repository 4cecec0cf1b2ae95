#pragma once

// A heading told from outside, by a map for one, as a measurement of the AHRS's own state: of its
// attitude and, through what they have in common, of the gyro's bias; late as it may come.

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include <Eigen/Core>

#include <wayfare/core/angle.hpp>
#include <wayfare/core/time.hpp>
#include <wayfare/inertial/ahrs_parameters.hpp>
#include <wayfare/inertial/attitude.hpp>
#include <wayfare/inertial/detail/ahrs_filter.hpp>
#include <wayfare/inertial/detail/heading_track.hpp>

namespace wayfare {

/// Where the body's AhrsParameters::heading_axis pointed.
struct HeadingFix {
  LogTime time;           ///< when it did; up to AhrsParameters::heading_history_s ago
  Angle compass;          ///< clockwise from north, or from what the AHRS takes for it
  double variance = 0.0;  ///< rad², of an error that is another at each fix
};

/// How an axis of the body points in east-north-up.
template <class T>
struct AxisHeading {
  T radians;                   ///< counter-clockwise from east
  Eigen::Matrix<T, 3, 1> row;  ///< its derivative by a turn about the world's axes
  bool level;                  ///< whether it has a heading at all: not within 8° of the vertical

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

/// The heading ψₛ of an earlier time is today's less what the gyro turned since: ψₛ = ψ − (Σω −
/// Σh·b) − w. So the fix is one of ψ and of the bias b at once, with the row (h, Σh), and its error
/// has the gyro's noise w since then in common with the state, which the gain allows for: the same
/// as carrying the state of then along (Roumeliotis and Burdick 2002) as long as nothing but the
/// gyro told of the heading in between.
template <class T>
class ExternalHeading {
 public:
  using Vector = Eigen::Matrix<T, 3, 1>;
  using Filter = AhrsFilter<T>;

  struct Outcome {
    UpdateStatus status = UpdateStatus::used;
    bool take_as_it_is = false;  ///< nothing is known, or known better: turn by `off`
    T off = T(0), sigma = T(0);
  };

  explicit ExternalHeading(const AhrsParameters& p)
      : axis_(p.heading_axis.template cast<T>()),
        gate2_(T(p.heading_gate_sigmas * p.heading_gate_sigmas)),
        patience_s_(p.lost_heading_s),
        track_(p.heading_history_s) {}

  [[nodiscard]] bool on() const { return track_.on(); }
  [[nodiscard]] const HeadingTrack& track() const { return track_; }
  [[nodiscard]] AxisHeading<T> now(const Filter& filter) const {
    return AxisHeading<T>::of(filter.rotation(), axis_);
  }
  /// Of the last fix judged: squared innovation over its variance.
  [[nodiscard]] T nis() const { return nis_; }

  /// The attitude begins anew: nothing of before can be compared with.
  void forget() {
    track_.forget();
    last_.reset();
    refused_.reset();
    settled_ = track_.now().variance;
  }

  /// A reading that turns the filter for dt: what to pass to end_turn() after it did.
  struct Turn {
    T radians;
    HeadingTrack::Sum part;
  };
  [[nodiscard]] Turn begin_turn(const Filter& filter, T dt, T angle_variance) const {
    const AxisHeading<T> from = now(filter);
    const Vector by_bias = filter.rotation().transpose() * from.row * dt;
    return {from.radians,
            {double(by_bias.dot(filter.bias())), by_bias.template cast<double>(),
             double(angle_variance * from.row.squaredNorm())}};
  }
  void end_turn(LogTime time, Turn turn, const Filter& filter) {
    turn.part.turned += double(wrap_to_pi(now(filter).radians - turn.radians));
    track_.add(time, turn.part);
  }

  /// `known`: whether the filter has a heading to compare with.
  Outcome take(Filter& filter, const HeadingFix& fix, bool known) {
    if (!std::isfinite(fix.compass.radians()) || !std::isfinite(fix.variance) ||
        !(fix.variance > 0.0))
      return {UpdateStatus::missing};
    const auto then = track_.at(fix.time);
    if (!then) return {track_.to_come(fix.time) ? UpdateStatus::waiting : UpdateStatus::late};
    if (last_ && fix.time <= *last_) return {UpdateStatus::late};
    const AxisHeading<T> here = now(filter);
    if (!here.level) return {UpdateStatus::waiting};
    last_ = fix.time;
    const HeadingTrack::Sum since = track_.now() - *then;
    const T turn = T(since.turn(filter.bias().template cast<double>()));
    const T off = wrap_to_pi(T(std::numbers::pi / 2 - fix.compass.radians()) + turn - here.radians);
    const T variance = T(fix.variance + std::abs(since.variance));
    if (!known) return as_it_is(off, variance);
    const Vector b = since.by_bias.template cast<T>();
    const Row row{{here.row[0], here.row[1], here.row[2], b[0], b[1], b[2]}};
    // What the gyro added before the last fix that fix has seen to.
    const T shared =
        T(std::clamp(since.variance, 0.0, std::max(track_.now().variance - settled_, 0.0)));
    const T expected = std::max(filter.variance_of(row) - T(2) * shared, T(0)) + variance;
    nis_ = off * off / expected;
    if (nis_ > gate2_) return refuse(fix, off, variance);
    filter.observe_shared(row, off, variance, shared);
    filter.apply();
    settle();
    return {};
  }

  /// The heading was told by something else: what the gyro added before is seen to.
  void settle() {
    settled_ = track_.now().variance;
    refused_.reset();
  }

 private:
  using Row = IndexedRow<T, 0, 1, 2, 3, 4, 5>;
  struct Refused {
    LogTime since;
    T off;
  };

  Outcome as_it_is(T off, T variance) {
    settle();
    return {UpdateStatus::used, true, off, std::sqrt(variance)};
  }

  /// Those that are off alike for long are right after all.
  Outcome refuse(const HeadingFix& fix, T off, T variance) {
    constexpr T kAlike = T(3);  // standard deviations of the fix
    const bool alike =
        refused_ && square(wrap_to_pi(off - refused_->off)) < square(kAlike) * variance;
    if (!alike) refused_ = Refused{fix.time, off};
    refused_->off = off;
    if (to_seconds(fix.time - refused_->since) < patience_s_) return {UpdateStatus::disturbed};
    return as_it_is(off, variance);
  }
  static T square(T x) { return x * x; }

  Vector axis_;
  T gate2_;
  double patience_s_;
  HeadingTrack track_;
  double settled_ = 0.0;  // the track's variance at the last fix that was used
  std::optional<LogTime> last_;
  std::optional<Refused> refused_;
  T nis_ = std::numeric_limits<T>::quiet_NaN();
};

}  // namespace wayfare
