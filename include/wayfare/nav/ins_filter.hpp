#pragma once

// The 23-state filter for one vehicle or, on packs, for many at once that share the recording but
// differ in noise, initial state and accepted measurements.

#include <array>
#include <cmath>
#include <optional>
#include <span>
#include <tuple>

#include <Eigen/Core>

#include <wayfare/filter/ekf.hpp>
#include <wayfare/gnss/range_model.hpp>
#include <wayfare/inertial/ins_model.hpp>
#include <wayfare/inertial/ins_state.hpp>
#include <wayfare/sensors/measurements.hpp>

namespace wayfare {

/// An Ekf of InsState on a tangent plane, with its process and measurements. `T`: a scalar or a
/// pack of lanes; `Offsets`: number of inter-system clock offsets; `Recorder`: of the Ekf;
/// `Further`: blocks that follow and move by themselves.
template <class T, int Offsets = 0, class Recorder = NoRecorder, class... Further>
class InsFilter {
 public:
  /// Position on the plane, velocity, attitude, sensors, clock.
  using State = InsState<T, Offsets, Further...>;
  using Vector3 = Eigen::Matrix<T, 3, 1>;   ///< of three components
  using Filter = Ekf<State, Recorder>;      ///< the filter inside
  using Square = typename Filter::Square;   ///< covariances
  using Update = ScalarUpdate<T>;           ///< result of an update, lane by lane
  static constexpr int kDof = State::kDof;  ///< number of errors

  InsFilter() = default;
  /// `lever_m` from the unit to the antenna in the unit's axes. Positions of `state` are on a plane
  /// tangent at `anchor`; its clock bias is relative to `clock_anchor_m`.
  InsFilter(const Geodetic& anchor, double clock_anchor_m, const State& state,
            const Square& covariance, const InsNoise<T>& noise, const Eigen::Vector3d& lever_m,
            const Further&... further)
      : plane_(anchor),
        clock_anchor_m_(clock_anchor_m),
        noise_(noise),
        further_(further...),
        model_(plane_, noise_, further...),
        lever_m_(lever_m.cast<T>()),
        filter_(state, covariance) {}

  /// Tangent at the anchor.
  [[nodiscard]] const LocalTangentPlane& plane() const { return plane_; }
  /// Receiver clock bias from which that of the state counts, m.
  [[nodiscard]] double clock_anchor_m() const { return clock_anchor_m_; }
  /// Of all lanes.
  [[nodiscard]] const State& state() const { return filter_.state(); }
  /// Of the errors of state().
  [[nodiscard]] const Square& covariance() const { return filter_.covariance(); }
  /// For other measurements.
  [[nodiscard]] Filter& ekf() { return filter_; }
  /// The filter inside.
  [[nodiscard]] const Filter& ekf() const { return filter_; }
  /// From the unit to the antenna, the unit's axes.
  [[nodiscard]] const Vector3& lever_m() const { return lever_m_; }
  /// The unit's raw turn rate at the newest prediction.
  [[nodiscard]] const Vector3& gyro_radps() const { return gyro_radps_; }

  /// Position of lane `i`.
  [[nodiscard]] Geodetic position(int i = 0) const {
    Eigen::Vector3d x;
    for (int k = 0; k < 3; ++k) x[k] = static_cast<double>(lane(state().position_m[k], i));
    return plane_.geodetic(x);
  }
  /// Receiver clock bias of lane `i`, m.
  [[nodiscard]] double clock_bias_m(int i = 0) const {
    return clock_anchor_m_ + static_cast<double>(lane(state().clock[0], i));
  }

  /// Advances state and covariance over an interval of readings.
  void predict(const ImuInterval& imu) {
    gyro_radps_ = imu.end_rate_radps.cast<T>();
    filter_.predict(model_, imu);
    if (any(state().position_m.squaredNorm() > T(kRange_m * kRange_m))) recentre();
    const T clock = state().clock[0];
    if (any(clock * clock > T(kRange_m * kRange_m))) recentre_clock();
  }

  /// `clock_offset`: index of the system's clock offset (−1: none).
  Update update_range(const CorrectedRange& satellite, const T& sigma_m, const T& gate_sigma,
                      int clock_offset = -1, const MaskOf<T>& enabled = true) {
    return filter_.update(range_model(satellite, sigma_m, clock_offset), gate_sigma, enabled);
  }
  /// By the Doppler shift; `gate_sigma` as of update_range.
  Update update_range_rate(const CorrectedRange& satellite, const T& sigma_mps, const T& gate_sigma,
                           const MaskOf<T>& enabled = true) {
    return filter_.update(range_rate_model(satellite, sigma_mps), gate_sigma, enabled);
  }
  /// The measurement of update_range.
  [[nodiscard]] RangeModel<T, Offsets> range_model(const CorrectedRange& satellite,
                                                   const T& sigma_m, int clock_offset = -1) const {
    const SatelliteView view(satellite, plane_);
    return {plane_,
            view,
            satellite.range_m - view.anchor_range_m - clock_anchor_m_,
            sigma_m * sigma_m,
            lever_m_,
            clock_offset};
  }
  /// The measurement of update_range_rate.
  [[nodiscard]] RangeRateModel<T, Offsets> range_rate_model(const CorrectedRange& satellite,
                                                            const T& sigma_mps) const {
    return {plane_,
            SatelliteView(satellite, plane_),
            satellite.range_rate_mps,
            sigma_mps * sigma_mps,
            lever_m_,
            gyro_radps_};
  }

  /// The receiver clock has jumped by `jump_m`, with standard deviation `sigma_m`.
  void jump_clock(double jump_m, const T& sigma_m) {
    clock_anchor_m_ += jump_m;
    filter_.add_variance(ins_state::kClock, sigma_m * sigma_m);
  }

 private:
  static constexpr double kRange_m = 5000.0;

  void recentre() {
    const LocalTangentPlane next(position());
    State x = state();
    for (int i = 0; i < LaneOf<T>::kLanes; ++i) {
      const Eigen::Vector3d moved = next.offset(position(i));
      for (int k = 0; k < 3; ++k) set_lane(x.position_m[k], i, moved[k]);
    }
    plane_ = next;
    model_ = model();
    filter_.set_state(x);
  }
  void recentre_clock() {
    const double shift = static_cast<double>(lane(state().clock[0], 0));
    State x = state();
    x.clock[0] -= T(shift);
    clock_anchor_m_ += shift;
    filter_.set_state(x);
  }

  using Model = InsModel<T, Offsets, Further...>;
  [[nodiscard]] Model model() const {
    return std::apply([this](const auto&... f) { return Model(plane_, noise_, f...); }, further_);
  }

  LocalTangentPlane plane_;
  double clock_anchor_m_ = 0.0;
  InsNoise<T> noise_;
  [[no_unique_address]] std::tuple<Further...> further_;
  Model model_ = model();
  Vector3 lever_m_ = Vector3::Zero(), gyro_radps_ = Vector3::Zero();
  Filter filter_;
};

}  // namespace wayfare
