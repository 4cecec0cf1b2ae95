#pragma once

// The filter with all its memory as one copyable value, so that late measurements are processed by
// replay from a copy.

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include <Eigen/Eigenvalues>

#include <wayfare/inertial/ins_measurements.hpp>
#include <wayfare/nav/gnss_ins.hpp>
#include <wayfare/nav/ins_filter.hpp>

#include "nav/gnss_ins/arrivals.hpp"
#include "nav/gnss_ins/coarse_start.hpp"
#include "nav/gnss_ins/event_log.hpp"
#include "nav/gnss_ins/gnss_errors.hpp"
#include "nav/gnss_ins/initial_filter.hpp"
#include "nav/gnss_ins/ins_view.hpp"
#include "nav/gnss_ins/on_earth.hpp"
#include "nav/gnss_ins/phase_changes.hpp"
#include "nav/gnss_ins/receiver_clocks.hpp"
#include "nav/gnss_ins/wheel_updates.hpp"
#include "nav/gnss_ins/zero_velocity_detector.hpp"

namespace wayfare::nav {

/// `Further`: blocks of the state besides those of InsState.
template <class... Further>
class InsEngine {
 public:
  using Filter = InsRangeFilter<Further...>;
  using State = typename Filter::State;

  InsEngine(const GnssInsOptions& options, const GnssInsStart& start, const ImuSample& first)
      : options_(options),
        filter_(initial_filter<Further...>(options, start)),
        heading_unknown_(start.heading_sigma_rad > kUnknownHeading_rad),
        last_(first),
        clocks_(options.range_sigma_scale, options.gate_sigma),
        errors_(options) {
    if (options.carrier_phase) phases_.emplace(options.clock, *options.carrier_phase);
    if (options.odometer) wheels_.emplace(options, *options.odometer);
    last_.time = start.nav.time;
  }

  [[nodiscard]] LogTime time() const { return last_.time; }
  [[nodiscard]] const ImuSample& last_sample() const { return last_; }
  /// Propagates to `sample`'s time; `in_gap`: readings in between are missing.
  void advance(const ImuSample& sample, bool in_gap, EventLog& events) {
    const double dt = to_seconds(sample.time - last_.time);
    if (dt <= 0.0) return;
    // Long steps are subdivided: the coefficients are constant within a step.
    const int parts = static_cast<int>(std::clamp(std::ceil(dt / 0.1), 1.0, 1e6));
    ImuInterval imu = between(last_, sample);
    imu.dt_s = dt / parts;
    const Vector3d rate_step = (imu.end_rate_radps - imu.begin_rate_radps) / parts;
    const Vector3d force_step = (imu.end_force_mps2 - imu.begin_force_mps2) / parts;
    for (int i = 0; i < parts; ++i) {
      imu.end_rate_radps = imu.begin_rate_radps + rate_step;
      imu.end_force_mps2 = imu.begin_force_mps2 + force_step;
      predict(imu, in_gap);
      imu.begin_rate_radps = imu.end_rate_radps;
      imu.begin_force_mps2 = imu.end_force_mps2;
    }
    last_ = sample;
    if (in_gap) {
      recent_.forget();
      zero_velocity_.forget();
    } else {
      recent_.add(sample, dt);
    }
    constrain(events);
  }

  void apply(const RangeEpoch& epoch, EventLog& events) {
    std::string notice;
    const bool ready = clocks_.prepare(filter_, epoch, notice);
    if (!notice.empty()) events.note(last_.time, notice);
    if (!ready) return;
    errors_.advance(filter_, last_.time);
    if (!notice.empty()) forget_phases();
    if constexpr (kAided) {
      if (phases_)
        phases_->update(filter_, epoch, [&](SatelliteId id, const ScalarUpdate<double>& u) {
          record(events, Kind::phase, id, u);
        });
    }
    int ranges = 0, ranges_in = 0, rates = 0, rates_in = 0;
    for (const CorrectedRange& s : epoch.satellites) {
      if (has_range(s)) {
        const auto u = errors_.update_range(filter_, s, clocks_.range_sigma_m(s),
                                            clocks_.offset_of(s.satellite.system));
        record(events, Kind::range, s.satellite, u);
        ++ranges;
        ranges_in += u.accepted ? 1 : 0;
      }
      if (has_rate(s)) {
        const auto u = errors_.update_range_rate(filter_, s, clocks_.rate_sigma_mps(s));
        record(events, Kind::range_rate, s.satellite, u);
        ++rates;
        rates_in += u.accepted ? 1 : 0;
      }
    }
    reopen(ranges_rejected_since_, ranges_in, ranges, events);
    reopen(rates_rejected_since_, rates_in, rates, events);
    if constexpr (kAided)
      if (phases_) phases_->keep(filter_, epoch);
    if (ranges_in < 4) return;
    full_epochs_.add(last_.time);
    if (rates_in >= 4) zero_velocity_.learn(recent_, filter_.state().velocity_mps.norm());
  }

  void apply(const GnssFix& fix, EventLog& events) {
    const Vector3d lever = options_.q_body_imu.inverse() * options_.antenna_lever_arm_m;
    const double scale = options_.range_sigma_scale * options_.range_sigma_scale;
    // Along the axes of the covariance; one rejected permanently is a lock-out as well, since the
    // others cannot correct it.
    errors_.advance(filter_, last_.time);
    const auto update = [&](Kind kind, const Eigen::Matrix3d& covariance, const auto& model) {
      const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(covariance);
      bool all = true;
      for (int i = 0; i < 3; ++i) {
        const Vector3d axis = axes.eigenvectors().col(i);
        const auto measured = model(axis, scale * axes.eigenvalues()[i]);
        const auto u = kind == Kind::position
                           ? errors_.update_fix(filter_, measured, axis, scale * covariance)
                           : errors_.update(filter_, measured);
        record(events, kind, {}, u);
        all = all && u.accepted;
      }
      return all;
    };
    const Vector3d at = filter_.plane().offset(fix.position);
    const bool position_in = update(
        Kind::position, fix.position_covariance_ned_m2, [&](const Vector3d& axis, double variance) {
          return AntennaPositionModel<double, kOffsets>{filter_.plane(), at, axis, lever, variance};
        });
    reopen(ranges_rejected_since_, position_in ? 1 : 0, 1, events);
    if (position_in) full_epochs_.add(last_.time);
    if (!fix.velocity_ned_mps) return;
    const bool velocity_in = update(
        Kind::velocity, fix.velocity_covariance_ned, [&](const Vector3d& axis, double variance) {
          return AntennaVelocityModel<double, kOffsets>{*fix.velocity_ned_mps, axis, lever,
                                                        filter_.gyro_radps(), variance};
        });
    reopen(rates_rejected_since_, velocity_in ? 1 : 0, 1, events);
    if (velocity_in) zero_velocity_.learn(recent_, filter_.state().velocity_mps.norm());
  }

  void apply(const WheelSpeed& wheels, EventLog& events) {
    if constexpr (kAided) {
      if (!wheels_) return;
      const bool inflated = wheels_->update(filter_, wheels, [&](const ScalarUpdate<double>& u) {
        record(events, Kind::wheels, {}, u);
      });
      if (inflated) events.note(last_.time, "wheels rejected for long: the covariance is inflated");
      if (inflated) forget_phases();
    }
  }

  /// Its steps are written to `tape` from now on; null: to none.
  void record_to(SmootherTape<State>* tape) { filter_.ekf().recorder().tape = tape; }
  /// The estimate.
  [[nodiscard]] InsView<State> view() const {
    return {last_.time, filter_.plane(), filter_.clock_anchor_m(), filter_.state(),
            filter_.covariance()};
  }

  /// Measurements have been rejected for so long that the filter should be reinitialised.
  [[nodiscard]] bool lost() const { return lost_; }
  /// False where the navigation equations are not valid.
  [[nodiscard]] bool on_earth() const {
    return is_on_earth(filter_.position()) && filter_.state().velocity_mps.squaredNorm() < 1e10;
  }

 private:
  using Kind = InnovationRecord::Kind;
  using Vector3d = Eigen::Vector3d;
  static constexpr bool kAided = kIsAided<State>;

  void forget_phases() {
    if (phases_) phases_->forget();
  }

  void predict(const ImuInterval& imu, bool in_gap) {
    filter_.predict(imu);
    add_vibration(imu.dt_s);
    if (heading_unknown_) forget_heading(imu.dt_s);
    if (!in_gap) return;
    // Unknown motion, independent from second to second: white noise of density a²·1 s.
    using namespace ins_state;
    const double v = options_.gap_acceleration_mps2 * options_.gap_acceleration_mps2 * imu.dt_s;
    const double w = options_.gap_turn_rate_radps * options_.gap_turn_rate_radps * imu.dt_s;
    for (int i = 0; i < 3; ++i) {
      filter_.ekf().add_variance(kVelocity + i, v);
      filter_.ekf().add_variance(kAttitude + i, w);
    }
  }

  /// Keeps the error of an unknown heading independent of all others, since nothing linear in it
  /// holds; the accelerations in its place are noise of the velocity.
  void forget_heading(double dt_s) {
    using namespace ins_state;
    const Vector3d down = filter_.state().q_nu.inverse() * Vector3d::UnitZ();
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - down * down.transpose();
    struct Step {
      State state;
      typename Filter::Square phi, q;
    };
    Step step{filter_.state(), Filter::Square::Identity(), Filter::Square::Zero()};
    step.phi.template block<3, 3>(kAttitude, kAttitude) = across;
    step.q.template block<3, 3>(kAttitude, kAttitude) =
        kNoHeadingSigma_rad * kNoHeadingSigma_rad * down * down.transpose();
    const double a = options_.gap_acceleration_mps2;
    for (int i = 0; i < 2; ++i) step.q(kVelocity + i, kVelocity + i) = a * a * dt_s;
    filter_.ekf().predict([&step](const State&) { return step; });
  }

  void add_vibration(double dt_s) {
    // Variation beyond the unit's own noise is vibration; its aliased fraction is an error of each
    // reading, constant for a step.
    const Eigen::Array3d own =
        2.0 * options_.imu.gyro_white_rad_per_sqrt_s.array().square() / std::max(dt_s, 1e-3);
    const Eigen::Array3d vibration = (recent_.vibration_radps2().array() - own).max(0.0);
    const double angle = options_.gyro_vibration_share * dt_s;
    for (int i = 0; i < 3; ++i)
      filter_.ekf().add_variance(ins_state::kAttitude + i, angle * angle * vibration[i]);
  }

  void constrain(EventLog& events) {
    if (last_constraint_ && to_seconds(last_.time - *last_constraint_) < 0.099) return;
    last_constraint_ = last_.time;
    if (options_.zero_velocity_updates) update_standstill(events);
    if (options_.non_holonomic_in_outage) update_non_holonomic(events);
  }

  void update_standstill(EventLog& events) {
    const auto velocity_variance =
        filter_.covariance().diagonal().template segment<3>(ins_state::kVelocity);
    if (!zero_velocity_.update(
            last_.time, recent_,
            {filter_.state().gyro_bias_radps, filter_.state().velocity_mps.norm(),
             std::sqrt(velocity_variance.sum())}))
      return;
    for (int axis = 0; axis < 3; ++axis) {
      const auto v = filter_.ekf().update(VelocityModel<double, kOffsets>{axis, 0.0, 0.05 * 0.05},
                                          options_.gate_sigma);
      record(events, Kind::standstill, {}, v);
      if (!v.accepted) return;
    }
    // The mean of half a second, used at 10 Hz: each value counts for a fifth.
    const double sigma = 3e-4 + 0.3 * recent_.rate_spread_radps();
    for (int axis = 0; axis < 3; ++axis) {
      const double measured = recent_.mean_rate_radps()[axis];
      filter_.ekf().update(ZeroTurnRateModel<double, kOffsets>{axis, measured, sigma * sigma},
                           options_.gate_sigma);
    }
  }

  void update_non_holonomic(EventLog& events) {
    const bool with_satellites = full_epochs_.are_recent(last_.time);
    if constexpr (kAided)
      if (wheels_)
        return wheels_->update_across(filter_, with_satellites, [&](const ScalarUpdate<double>& u) {
          record(events, Kind::constraint, {}, u);
        });
    if (with_satellites) return;
    if (filter_.state().velocity_mps.norm() < 0.5) return;
    const double sigma = options_.non_holonomic_sigma_mps;
    for (int axis = 1; axis < 3; ++axis) {
      const Vector3d direction = options_.q_body_imu.inverse() * Vector3d::Unit(axis);
      const auto u = filter_.ekf().update(
          BodyVelocityModel<double, kOffsets>{direction, Vector3d::Zero(), filter_.gyro_radps(),
                                              0.0, sigma * sigma},
          options_.gate_sigma);
      record(events, Kind::constraint, {}, u);
    }
  }

  void record(EventLog& events, Kind kind, SatelliteId id, const ScalarUpdate<double>& u) const {
    if (!events.open) return;
    events.innovations.push_back(
        {last_.time, kind, id, u.innovation, std::sqrt(std::max(u.variance, 0.0)), u.accepted});
  }

  /// Inflates the covariance after long rejection; `since`: start of the rejections.
  void reopen(std::optional<LogTime>& since, int accepted, int total, EventLog& events) {
    if (total == 0) return;
    if (2 * accepted >= total) {
      since.reset();
      return;
    }
    if (!since) since = last_.time;
    const double rejected_s = to_seconds(last_.time - *since);
    if (rejected_s < options_.gate_reopen_s) return;
    using namespace ins_state;
    const auto worst = [this](int first) {
      return filter_.covariance().diagonal().template segment<3>(first).maxCoeff();
    };
    if (worst(kPosition) < 1e8) inflate(filter_, kPosition, 6);
    // Tilt and heading are more reliable, and essential: inflated less.
    if (worst(kAttitude) < 0.15 * 0.15) inflate(filter_, kAttitude, 3);
    inflate(filter_, kClock, 2);
    forget_phases();
    events.note(last_.time, "most ranges or rates rejected for long: the covariance is inflated");
    if (rejected_s > 10.0 * options_.gate_reopen_s) lost_ = true;
  }

  GnssInsOptions options_;
  Filter filter_;
  bool heading_unknown_;
  ImuSample last_;
  RecentReadings recent_;
  ZeroVelocityDetector zero_velocity_;
  std::optional<LogTime> last_constraint_;
  FullEpochs full_epochs_;
  bool lost_ = false;
  ReceiverClocks clocks_;
  GnssErrors<Filter> errors_;
  std::optional<PhaseChanges<Filter>> phases_;  ///< of a filter with EarlierAntenna
  std::optional<WheelUpdates<Filter>> wheels_;  ///< of a filter with Odometer
  std::optional<LogTime> ranges_rejected_since_, rates_rejected_since_;
};

}  // namespace wayfare::nav
