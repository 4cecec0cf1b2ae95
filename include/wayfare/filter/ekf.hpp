#pragma once

// The extended Kalman filter in error-state form, on any manifold and any scalar, a SIMD pack
// included. Models are const objects of the caller; the filter contains only state and covariance.

#include <cmath>
#include <concepts>
#include <limits>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include <wayfare/core/manifold.hpp>
#include <wayfare/core/pack.hpp>
#include <wayfare/filter/detail/gain.hpp>
#include <wayfare/filter/gate.hpp>
#include <wayfare/filter/measurement.hpp>
#include <wayfare/filter/process_model.hpp>
#include <wayfare/filter/sequential_update.hpp>

namespace wayfare {

/// Records nothing; costs nothing.
struct NoRecorder {};

/// State and covariance of an extended Kalman filter, moved by `predict` and corrected by `update`.
/// A Recorder other than NoRecorder stores each linear step, for example a TapeRecorder, from whose
/// tape the estimates are smoothed. It has `predicted(step)`, with the step of the process;
/// `updated(rows, gain, inverse, innovation)`, with the rows of H as the measurement gives them, K,
/// S⁻¹ and ν; and `reset(i)`, of error i.
template <Manifold M, class Recorder = NoRecorder>
class Ekf {
  static constexpr bool kRecords = !std::same_as<Recorder, NoRecorder>;

 public:
  using State = M;                                      ///< a manifold
  using Scalar = typename ManifoldTraits<M>::Scalar;    ///< floating point, or a SIMD pack
  using Tangent = TangentOf<M>;                         ///< an error of the state
  using Square = SquareOf<M>;                           ///< a covariance of errors
  static constexpr int kDof = ManifoldTraits<M>::kDof;  ///< number of errors

  Ekf() : state_(manifold_origin<M>()), covariance_(Square::Identity()) {}
  /// `covariance` is that of the error τ in truth = state ⊞ τ, positive definite.
  Ekf(const M& state, const Square& covariance) : state_(state), covariance_(covariance) {}

  /// The estimate.
  [[nodiscard]] const M& state() const { return state_; }
  /// Of the error τ in truth = state ⊞ τ.
  [[nodiscard]] const Square& covariance() const { return covariance_; }
  /// Replaces the estimate; the covariance stays.
  void set_state(const M& state) { state_ = state; }
  /// The recorder of the steps.
  [[nodiscard]] Recorder& recorder() { return recorder_; }

  /// x ← f(x, u), P ← Φ P Φᵀ + Q by a ProcessModel, which is called with the state and `input`.
  template <class Process, class... Input>
  requires ProcessModel<Process, M, Input...>
  void predict(const Process& process, const Input&... input) {
    const auto step = process(state_, input...);
    if constexpr (kRecords) recorder_.predicted(step);
    state_ = step.state;
    if constexpr (SparseProcessStep<decltype(step), M>) {
      step.propagate(covariance_);
    } else {
      const Square next = step.phi * covariance_ * step.phi.transpose() + step.q;
      covariance_ = Scalar(0.5) * (next + next.transpose());
    }
  }

  /// Updates with a scalar measurement. It is rejected where |innovation| exceeds `gate_sigma` of
  /// its own σ, where it or its variance is not finite, and in lanes that are not `enabled`.
  template <class Model>
  requires ScalarMeasurementModel<Model, M> ScalarUpdate<Scalar> update(
      const Model& model, const Scalar& gate_sigma = std::numeric_limits<float>::max(),
      const MaskOf<Scalar>& enabled = true) {
    return update(model, detail::SigmaLimit<Scalar>{gate_sigma}, enabled);
  }
  /// The same with an UpdateGate. The result's variance is that before the gate's weight.
  template <class Model, class Gate>
  requires(ScalarMeasurementModel<Model, M> && !std::convertible_to<Gate, Scalar>)
      ScalarUpdate<Scalar> update(const Model& model, const Gate& gate,
                                  const MaskOf<Scalar>& enabled = true) {
    static_assert(detail::check_gate<Gate, Scalar, 1>());
    const auto measured = measure(model, state_);
    const Tangent g = covariance_times(measured.row);
    const Scalar s = row_times(measured.row, g) + measured.variance;
    const Scalar nu = measured.innovation;
    const Innovation<Scalar, 1> innovation{nu, s, nu * nu / s};
    Scalar weight(1);
    // Written so that NaN, infinity and a variance that is not positive are rejected.
    const MaskOf<Scalar> accepted = enabled && (s > Scalar(0)) && is_finite(s) &&
                                    is_finite(innovation.nis) &&
                                    detail::passes(gate, innovation, weight);
    if (!any(accepted)) return {nu, s, accepted};
    if constexpr (detail::kGivesWeight<Gate, Scalar, 1>) {
      const Scalar variance = measured.variance / select(accepted, weight, Scalar(1));
      correct(measured.row, g, row_times(measured.row, g) + variance, variance, nu, accepted);
    } else {
      correct(measured.row, g, s, measured.variance, nu, accepted);
    }
    return {nu, s, accepted};
  }

  /// Updates with a scalar measurement whose noise is correlated with the error of the state:
  /// `cross` is their covariance (Simon 2006, section 7.1). The weight of an UpdateGate divides the
  /// variance of the innovation, noise and prediction together.
  template <class Model, class Gate>
  requires(ScalarMeasurementModel<Model, M>&& std::floating_point<Scalar>)
      ScalarUpdate<Scalar> update_correlated(const Model& model, const Tangent& cross,
                                             const Gate& gate) {
    const auto measured = measure(model, state_);
    const Tangent g = covariance_times(measured.row) + cross;
    const Scalar s = row_times(measured.row, g) + row_times(measured.row, cross);
    const Scalar variance = s + measured.variance, nu = measured.innovation;
    const Innovation<Scalar, 1> innovation{nu, variance, nu * nu / variance};
    Scalar weight(1);
    const bool accepted = variance > Scalar(0) && is_finite(innovation.nis) &&
                          detail::passes(gate, innovation, weight);
    const Scalar used = variance / weight;
    if (accepted) correct(measured.row, g, used, used, nu, accepted);
    return {nu, variance, accepted};
  }

  /// Updates with a vector measurement. It is rejected where its normalised innovation squared
  /// exceeds `nis_limit`, where it is not finite, and where HPHᵀ + R is not positive definite. For
  /// scalars only, not packs.
  template <class Model>
  requires VectorMeasurementModel<Model, M>
  auto update(const Model& model, Scalar nis_limit = std::numeric_limits<Scalar>::max()) {
    return update(model, detail::NisLimit<Scalar>{nis_limit});
  }
  /// The same with an UpdateGate. The result's covariance is that before the gate's weight.
  template <class Model, class Gate>
  requires(VectorMeasurementModel<Model, M> &&
           !std::convertible_to<Gate, Scalar>) auto update(const Model& model, const Gate& gate) {
    auto m = measure(model, state_);
    constexpr int kRows = decltype(m.innovation)::RowsAtCompileTime;
    static_assert(detail::check_gate<Gate, Scalar, kRows>());
    const auto g = covariance_times(m.rows);
    VectorUpdate<Scalar, kRows> u{m.innovation, m.covariance,
                                  std::numeric_limits<Scalar>::quiet_NaN(), false};
    add_rows_times(m.rows, g, u.covariance);
    auto k = g;
    const auto nis = detail::solve_gain(u.covariance, u.innovation, k);
    if (!nis) return u;
    u.nis = *nis;
    Scalar weight(1);
    u.accepted =
        detail::passes(gate, Innovation<Scalar, kRows>{u.innovation, u.covariance, u.nis}, weight);
    if (!u.accepted) return u;
    if constexpr (detail::kGivesWeight<Gate, Scalar, kRows>) {
      m.covariance /= weight;
      auto weighted = m.covariance;
      add_rows_times(m.rows, g, weighted);
      k = g;
      u.accepted = detail::solve_gain(weighted, u.innovation, k).has_value();
      if (!u.accepted) return u;
    }
    if constexpr (kRecords) {
      using Inverse = Eigen::Matrix<Scalar, kRows, kRows>;
      auto s = m.covariance;
      add_rows_times(m.rows, g, s);
      recorder_.updated(m.rows, k, Inverse(s.llt().solve(Inverse::Identity())), u.innovation);
    }
    // Joseph's form, (I − K H) P (I − K H)ᵀ + K R Kᵀ, one factor after the other.
    detail::subtract_product(covariance_, k, g);
    auto left = covariance_times(m.rows);
    detail::subtract_product(left, k, m.covariance);  // R = Rᵀ
    detail::subtract_product(covariance_, left, k);
    for (int j = 0; j < kDof; ++j)
      for (int i = 0; i < j; ++i)
        covariance_(i, j) = covariance_(j, i) =
            Scalar(0.5) * (covariance_(i, j) + covariance_(j, i));
    Tangent tau = Tangent::Zero();
    for (int j = 0; j < kRows; ++j)
      for (int i = 0; i < kDof; ++i) tau[i] += k(i, j) * u.innovation[j];
    state_ = ManifoldTraits<M>::plus(state_, tau);
    return u;
  }

  /// Says what is missing in a type that is no measurement of this state.
  template <class Model, class... Gate>
  requires(!MeasurementModel<Model, M>) void update(const Model&, const Gate&...) {
    static_assert(detail::check_measurement<Model, M>());
  }

  /// σ of a measurement's innovation, without an update.
  template <class Row>
  [[nodiscard]] Scalar predicted_sigma(const ScalarMeasurement<Scalar, Row>& m) const {
    using std::sqrt;
    return sqrt(row_times(m.row, covariance_times(m.row)) + m.variance);
  }

  /// Updates with a vector measurement: innovation z − h(x), H, and the noise covariance R, not
  /// necessarily diagonal. False, without a change, where HPHᵀ + R is not positive definite or the
  /// normalised innovation squared exceeds `nis_limit`. For scalars only, not packs.
  template <int Rows>
  requires std::floating_point<Scalar>
  bool update_block(const Eigen::Matrix<Scalar, Rows, 1>& innovation,
                    const Eigen::Matrix<Scalar, Rows, kDof>& h,
                    const Eigen::Matrix<Scalar, Rows, Rows>& r,
                    Scalar nis_limit = std::numeric_limits<Scalar>::max()) {
    const Eigen::Matrix<Scalar, kDof, Rows> g = covariance_ * h.transpose();
    const Eigen::Matrix<Scalar, Rows, Rows> s = h * g + r;
    const Eigen::LLT<Eigen::Matrix<Scalar, Rows, Rows>> llt(s);
    if (llt.info() != Eigen::Success || !innovation.allFinite() || !s.allFinite()) return false;
    if (!(innovation.dot(llt.solve(innovation)) <= nis_limit)) return false;
    const Eigen::Matrix<Scalar, kDof, Rows> k = llt.solve(g.transpose()).transpose();
    if constexpr (kRecords) {
      using Inverse = Eigen::Matrix<Scalar, Rows, Rows>;
      recorder_.updated(h, k, Inverse(llt.solve(Inverse::Identity())), innovation);
    }
    const Square keep = Square::Identity() - k * h;
    const Square next = keep * covariance_ * keep.transpose() + k * r * k.transpose();
    covariance_ = Scalar(0.5) * (next + next.transpose());
    state_ = ManifoldTraits<M>::plus(state_, k * innovation);
    return true;
  }

  /// Adds `variance` to error i.
  void add_variance(int i, const Scalar& variance) { covariance_(i, i) += variance; }

  /// Resets error i to this variance, uncorrelated with all others.
  void reset_variance(int i, const Scalar& variance, const MaskOf<Scalar>& where = true) {
    if constexpr (kRecords) recorder_.reset(i);
    for (int j = 0; j < kDof; ++j) {
      const Scalar kept = select(where, j == i ? variance : Scalar(0), covariance_(i, j));
      covariance_(i, j) = kept;
      covariance_(j, i) = kept;
    }
  }

  /// Multiplies the standard deviations of errors first … first + count − 1 by `factor` and keeps
  /// all correlations.
  void scale_sigma(int first, int count, const Scalar& factor) {
    covariance_.middleRows(first, count) *= factor;
    covariance_.middleCols(first, count) *= factor;
  }

 private:
  template <int K>
  [[nodiscard]] Tangent covariance_times(const SparseRow<Scalar, K>& row) const {
    Tangent g;
    const Scalar* p = covariance_.data();
    for (int i = 0; i < kDof; ++i) g[i] = row.value[0] * p[kDof * row.index[0] + i];
    for (std::size_t k = 1; k < K; ++k) {
      const Scalar* column = p + kDof * row.index[k];
      for (int i = 0; i < kDof; ++i) g[i] += row.value[k] * column[i];
    }
    return g;
  }
  [[nodiscard]] Tangent covariance_times(const Eigen::Matrix<Scalar, 1, kDof>& row) const {
    return covariance_ * row.transpose();
  }
  template <int Rows, int K>
  [[nodiscard]] Eigen::Matrix<Scalar, kDof, Rows> covariance_times(
      const SparseRows<Scalar, Rows, K>& rows) const {
    Eigen::Matrix<Scalar, kDof, Rows> g = Eigen::Matrix<Scalar, kDof, Rows>::Zero();
    for (int r = 0; r < Rows; ++r)
      for (std::size_t k = 0; k < K; ++k)
        for (int i = 0; i < kDof; ++i)
          g(i, r) += covariance_(i, rows.index[k]) * rows.value(r, static_cast<int>(k));
    return g;
  }
  template <int Rows>
  requires(Rows > 1) [[nodiscard]] Eigen::Matrix<Scalar, kDof, Rows> covariance_times(
      const Eigen::Matrix<Scalar, Rows, kDof>& rows) const {
    return covariance_ * rows.transpose();
  }
  template <int Rows, int K>
  static void add_rows_times(const SparseRows<Scalar, Rows, K>& rows,
                             const Eigen::Matrix<Scalar, kDof, Rows>& g,
                             Eigen::Matrix<Scalar, Rows, Rows>& sum) {
    for (int c = 0; c < Rows; ++c)
      for (std::size_t k = 0; k < K; ++k)
        for (int r = 0; r < Rows; ++r)
          sum(r, c) += rows.value(r, static_cast<int>(k)) * g(rows.index[k], c);
  }
  template <int Rows>
  static void add_rows_times(const Eigen::Matrix<Scalar, Rows, kDof>& rows,
                             const Eigen::Matrix<Scalar, kDof, Rows>& g,
                             Eigen::Matrix<Scalar, Rows, Rows>& sum) {
    sum += rows * g;
  }
  template <int K>
  [[nodiscard]] static Scalar row_times(const SparseRow<Scalar, K>& row, const Tangent& g) {
    Scalar sum = row.value[0] * g[row.index[0]];
    for (std::size_t k = 1; k < K; ++k) sum += row.value[k] * g[row.index[k]];
    return sum;
  }
  [[nodiscard]] static Scalar row_times(const Eigen::Matrix<Scalar, 1, kDof>& row,
                                        const Tangent& g) {
    return row.dot(g);
  }

  /// P − k s kᵀ as an exactly symmetric product. Where the measurement is so much more accurate
  /// than the prediction that rounding errors matter, the result is corrected to satisfy P hᵀ = R
  /// k, which is the purpose of Joseph's form (I − k h) P (I − k h)ᵀ + k R kᵀ.
  template <class Row>
  void correct(const Row& row, const Tangent& g, const Scalar& s, const Scalar& r, const Scalar& nu,
               const MaskOf<Scalar>& accepted) {
    using std::sqrt;
    const Scalar safe = select(accepted, s, Scalar(1)), root = Scalar(1) / sqrt(safe);
    Tangent u, k;
    for (int i = 0; i < kDof; ++i) {
      const Scalar gi = select(accepted, g[i], Scalar(0));
      u[i] = gi * root;
      k[i] = gi / safe;
    }
    if constexpr (kRecords) {
      using One = Eigen::Matrix<Scalar, 1, 1>;
      recorder_.updated(row, k, One(Scalar(1) / safe), One(nu));
    }
    Scalar* p = covariance_.data();
    for (int j = 0; j < kDof; ++j) {
      const Scalar uj = u[j];
      for (int i = 0; i < kDof; ++i) p[kDof * j + i] -= u[i] * uj;
    }
    using Lane = typename LaneOf<Scalar>::Type;
    const Scalar digits_left = Scalar(Lane(1e-4) / std::numeric_limits<Lane>::epsilon());
    const MaskOf<Scalar> ill_conditioned = accepted && (s > digits_left * r);
    if (any(ill_conditioned)) remove_rounding_error(row, k, r, ill_conditioned);
    state_ = ManifoldTraits<M>::plus(state_, k * select(accepted, nu, Scalar(0)));
  }

  /// Removes the rounding error e = P hᵀ − R k: P − e kᵀ − k eᵀ + (h e) k kᵀ.
  template <class Row>
  void remove_rounding_error(const Row& row, const Tangent& k, const Scalar& r,
                             const MaskOf<Scalar>& where) {
    Tangent e = covariance_times(row);
    for (int i = 0; i < kDof; ++i) e[i] = select(where, e[i] - r * k[i], Scalar(0));
    const Tangent m = e - (Scalar(0.5) * row_times(row, e)) * k;
    for (int j = 0; j < kDof; ++j) {
      for (int i = 0; i <= j; ++i) {
        const Scalar next = covariance_(i, j) - (m[i] * k[j] + k[i] * m[j]);
        covariance_(i, j) = next;
        covariance_(j, i) = next;
      }
    }
  }

  M state_;
  Square covariance_;
  [[no_unique_address]] Recorder recorder_;
};

}  // namespace wayfare
