#pragma once

// Carrier phases of two epochs as a measurement of inertial navigation. Their difference has no
// ambiguity while the receiver tracks the signal; it measures how far the antenna has moved along
// the line of sight, and by how much the receiver's clock has (van Graas and Soloviev 2004,
// "Precise velocity estimation using a stand-alone GPS receiver"; Groves 2013, section 14.1.2). The
// position of the earlier epoch is a state (stochastic cloning: Roumeliotis and Burdick 2002), so
// that what the two positions have in common, and the path between them, is accounted for: neither
// a constant velocity nor that of the middle of the interval is assumed. From
//   φ = |p − s| + c + N + ε
// at two epochs: φ₂ − φ₁ = |p₂ − s₂| − |p₁ − s₁| + c₂ − c₁ + ε₂ − ε₁, of variance 2σ². Successive
// differences share an ε, with correlation −½. They are taken as independent: that is right for the
// velocity, to which only the newest contributes much, and cautious for the sum of many, where all
// but the first and last ε cancel.

#include <Eigen/Core>

#include <wayfare/filter/blocks.hpp>
#include <wayfare/filter/sequential_update.hpp>
#include <wayfare/gnss/range_model.hpp>
#include <wayfare/inertial/ins_state.hpp>

namespace wayfare {

/// How carrier phases are used.
struct CarrierPhaseOptions {
  /// Multiplies the standard deviation of every phase.
  double sigma_scale = 1.0;
  /// Changes with a normalised innovation above this, σ, given all others, are cycle slips.
  double gate_sigma = 4.0;
  /// Epochs that are further apart are not compared, s.
  double longest_interval_s = 2.5;
};

namespace ins {

/// Antenna position in Earth-fixed axes (m) and clock bias (m) at an earlier epoch.
template <class T>
struct EarlierAntenna : RandomConstant<4, T> {
  using Value = Eigen::Matrix<T, 4, 1>;  ///< m
  /// Member of states.
  struct Storage {
    Value earlier = Value::Zero();  ///< x, y, z, clock bias, m
  };
  static constexpr auto kMember = &Storage::earlier;  ///< where states keep it
  static constexpr BlockNames<4> kNames{"earlier antenna x", "earlier antenna y",
                                        "earlier antenna z", "earlier clock bias"};  ///< of its
                                                                                     ///< errors
};

}  // namespace ins

/// Process model of one step that replaces EarlierAntenna by the state's antenna and clock; the
/// error of the copy is then wholly that of the state.
template <class T, int Offsets = 0>
struct CloneAntenna {
  const LocalTangentPlane& plane;  ///< of the state's positions; must outlive this
  T clock_anchor_m;                ///< from which the state's clock bias counts
  Eigen::Matrix<T, 3, 1> lever_m;  ///< the unit's axes

  /// State, Φ and Q = 0.
  template <class S>
  struct Step {
    S state;          ///< with the copy
    SquareOf<S> phi,  ///< identity but for the rows of the copy
        q;            ///< zero
  };
  /// The copy is made of `x`.
  template <class... Further>
  [[nodiscard]] auto operator()(const InsState<T, Offsets, Further...>& x) const {
    using S = InsState<T, Offsets, Further...>;
    using Vector3 = Eigen::Matrix<T, 3, 1>;
    constexpr int k = S::template index<ins::EarlierAntenna<T>>();
    const AntennaView<T> antenna(x, plane, lever_m, Vector3::Zero());
    const Eigen::Matrix<T, 3, 3> ecef_anchor =
        plane.rotation_ecef_ned_at_anchor().template cast<T>();
    Step<S> step{x, SquareOf<S>::Identity(), SquareOf<S>::Zero()};
    step.state.earlier.template head<3>() =
        plane.ecef_m().template cast<T>() + ecef_anchor * antenna.position_m;
    step.state.earlier[3] = clock_anchor_m + x.clock[0];
    auto rows = step.phi.template middleRows<4>(k);
    rows.setZero();
    rows.template block<3, 3>(0, ins_state::kPosition) =
        ecef_anchor * antenna.anchor_local * antenna.plane_scale.asDiagonal();
    rows.template block<3, 3>(0, ins_state::kAttitude) =
        -(ecef_anchor * antenna.anchor_unit * skew(lever_m));
    rows(3, ins_state::kClock) = T(1);
    return step;
  }
};

/// φ₂ − φ₁ − (|p₂ − s₂| − |p₁ − s₁| + c₂ − c₁) with p₁ and c₁ of EarlierAntenna.
template <class T, int Offsets = 0>
struct PhaseChangeModel {
  RangeModel<T, Offsets> now;  ///< of the second phase; its variance is not used
  Eigen::Matrix<T, 3, 1> earlier_satellite_ecef_m;  ///< s₁
  T earlier_phase_m,                                ///< φ₁
      variance;                                     ///< of the difference, m²

  static constexpr int kEntries = 8 + 4;  ///< numbers of a row that are not zero
  using Row = SparseRow<T, kEntries>;     ///< the nonzero numbers of H

  /// Innovation, row and variance at a state.
  template <class... Further>
  [[nodiscard]] ScalarMeasurement<T, Row> operator()(
      const InsState<T, Offsets, Further...>& x) const {
    constexpr int k = InsState<T, Offsets, Further...>::template index<ins::EarlierAntenna<T>>();
    const auto second = now(x);
    const Eigen::Matrix<T, 3, 1> line = earlier_satellite_ecef_m - x.earlier.template head<3>();
    const T range = line.norm();
    Row row;
    for (std::size_t i = 0; i < 8; ++i) {
      row.index[i] = second.row.index[i];
      row.value[i] = second.row.value[i];
    }
    for (int i = 0; i < 3; ++i) {
      row.index[static_cast<std::size_t>(8 + i)] = k + i;
      row.value[static_cast<std::size_t>(8 + i)] = line[i] / range;
    }
    row.index[11] = k + 3;
    row.value[11] = T(-1);
    return {second.innovation - (earlier_phase_m - range - x.earlier[3]), row, variance};
  }
};

}  // namespace wayfare
