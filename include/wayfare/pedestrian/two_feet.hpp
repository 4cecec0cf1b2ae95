#pragma once

// Two foot-mounted trackers with a bound on their distance.

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>

#include <Eigen/Core>

#include <wayfare/core/angle.hpp>
#include <wayfare/core/result.hpp>
#include <wayfare/pedestrian/foot_tracker.hpp>

namespace wayfare {

/// Trackers and geometry of a BasicTwoFeet.
struct TwoFeetParameters {
  FootParameters foot;  ///< of both trackers
  /// Largest distance of the units, m, that of a long step; zero disables the constraint.
  double farthest_m = 1.0;
  /// Initial position and heading (counter-clockwise) of the right unit in the axes of the left
  /// one's FootPose.
  Eigen::Vector3d right_from_left_m = {0.0, -0.2, 0.0};
  Angle right_from_left;  ///< counter-clockwise
};

/// One tracker per foot, and an upper bound on their distance (Skog et al. 2012): positions further
/// apart are projected onto the bound, each shifted in proportion to its variance. Headings and
/// biases are not corrected: a joint filter converges to headings that neither foot had. Both need
/// the same clock. `Statistic` is a ZeroVelocityStatistic.
template <class Statistic>
class BasicTwoFeet {
 public:
  using Tracker = BasicFootTracker<Statistic>;  ///< of each foot
  /// Which foot.
  enum class Side {
    left,   ///< left foot, which has the axes
    right,  ///< right foot
  };

  /// With SHOE or ARED, by FootParameters::statistic.
  explicit BasicTwoFeet(
      const TwoFeetParameters& parameters = {}) requires std::same_as<Statistic, ShoeOrAred>
      : BasicTwoFeet(parameters, ShoeOrAred(parameters.foot)) {}
  /// With any statistic.
  BasicTwoFeet(const TwoFeetParameters& parameters, const Statistic& statistic)
      : p_(parameters),
        feet_{Tracker(parameters.foot, statistic), Tracker(parameters.foot, statistic)} {}

  /// Passes poses to `sink(Side, const FootPose&)`, each in its foot's axes (see position()).
  template <class Sink>
  UpdateStatus add(Side side, const ImuSample& sample, Sink&& sink) {
    return foot(side).add(sample, [&](const FootPose& pose) { handle(side, pose, sink); });
  }
  /// Passes the remaining poses of both feet to `sink`, at the end of a recording.
  template <class Sink>
  void finish(Sink&& sink) {
    for (const Side side : {Side::left, Side::right})
      foot(side).finish([&](const FootPose& pose) { handle(side, pose, sink); });
  }

  /// The tracker of one foot.
  [[nodiscard]] const Tracker& tracker(Side side) const {
    return feet_[static_cast<std::size_t>(side)];
  }
  /// In the left foot's axes, relative to its start.
  [[nodiscard]] Eigen::Vector3d position(Side side) const {
    const Eigen::Vector3d& p = tracker(side).filter().position();
    return side == Side::left ? p : Eigen::Vector3d(p_.right_from_left_m + right_rotation() * p);
  }
  /// Midpoint and mean heading of the feet.
  [[nodiscard]] OdometrySample odometry() const {
    const FootPose &l = tracker(Side::left).pose(), &r = tracker(Side::right).pose();
    const Eigen::Vector3d middle = 0.5 * (position(Side::left) + position(Side::right));
    const Angle heading =
        (l.heading + Angle::radians(0.5 * (r.heading - l.heading).wrapped().radians())).wrapped();
    return {std::max(l.time, r.time),
            Transform2<frame::Odom, frame::Base>(SE2d(middle.x(), middle.y(), heading))};
  }
  /// Number of projections onto the distance bound.
  [[nodiscard]] std::uint64_t projections() const { return projections_; }

 private:
  Tracker& foot(Side side) { return feet_[static_cast<std::size_t>(side)]; }
  [[nodiscard]] SO3d right_rotation() const {
    return SO3d::exp({0.0, 0.0, p_.right_from_left.radians()});
  }

  template <class Sink>
  void handle(Side side, const FootPose& pose, Sink&& sink) {
    sink(side, pose);
    if (pose.stance > 0.5) project(side);
  }

  /// Projects the feet onto the bound while `side` is in stance.
  void project(Side side) {
    const Tracker& other = tracker(side == Side::left ? Side::right : Side::left);
    if (!(p_.farthest_m > 0.0) || !other.ready()) return;
    constexpr double kTogether_s = 0.05;
    const double apart_s = to_seconds(tracker(side).pose().time - other.pose().time);
    if (!(std::abs(apart_s) < kTogether_s)) return;
    const Eigen::Vector3d between = position(Side::right) - position(Side::left);
    const double distance = between.norm();
    if (!(distance > p_.farthest_m)) return;
    const Eigen::Vector3d u = between / distance;
    const Eigen::Vector3d own = right_rotation().inverse() * u;  // in the right foot's axes
    FootFilter &l = foot(Side::left).filter(), &r = foot(Side::right).filter();
    const auto variance = [](const FootFilter& f, const Eigen::Vector3d& along) {
      return along.dot(f.covariance().topLeftCorner<3, 3>() * along);
    };
    const double of_left = variance(l, u), of_right = variance(r, own);
    const double excess = distance - p_.farthest_m;
    const double part = of_left + of_right > 0.0 ? of_left / (of_left + of_right) : 0.5;
    l.shift(part * excess * u);
    r.shift(-(1.0 - part) * excess * own);
    ++projections_;
  }

  TwoFeetParameters p_;
  std::array<Tracker, 2> feet_;
  std::uint64_t projections_ = 0;
};
using TwoFeet = BasicTwoFeet<ShoeOrAred>;  ///< by SHOE or ARED

/// How units of unknown mounting are placed: see TwoFeetParameters.
struct FeetMounting {
  /// M, initial position of the right unit.
  Eigen::Vector3d right_from_left_m = Eigen::Vector3d::Zero();
  Angle right_from_left;  ///< initial heading of the right unit
};

/// From the tracks of both feet, each in its own axes and from its own start: their directions are
/// the same where they are first `reach_m` from the start. The feet begin `width_m` apart, side by
/// side. An error if a foot does not get that far.
[[nodiscard]] inline Result<FeetMounting> feet_mounting(std::span<const Eigen::Vector2d> left,
                                                        std::span<const Eigen::Vector2d> right,
                                                        double width_m, double reach_m = 5.0) {
  const auto far = [&](const Eigen::Vector2d& p) { return p.norm() >= reach_m; };
  const auto l = std::find_if(left.begin(), left.end(), far);
  const auto r = std::find_if(right.begin(), right.end(), far);
  if (l == left.end() || r == right.end())
    return Error{ErrorCode::degenerate,
                 "the feet do not get far enough from the start to compare their headings"};
  const Eigen::Vector2d ahead = l->normalized();
  return FeetMounting{
      width_m * Eigen::Vector3d(ahead.y(), -ahead.x(), 0.0),
      Angle::radians(std::atan2(l->y(), l->x()) - std::atan2(r->y(), r->x())).wrapped()};
}

}  // namespace wayfare
