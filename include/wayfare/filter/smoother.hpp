#pragma once

// Smoothing: estimates by all measurements of an interval, those that came later included. An Ekf
// with a TapeRecorder writes its steps to a SmootherTape, which is then read backwards (the adjoint
// form of Bryson and Frazier for discrete measurements: Bierman 1973, "Fixed interval smoothing
// with discrete measurements"). No covariance is inverted, so that states of any uncertainty may be
// among them.

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/manifold.hpp>
#include <wayfare/filter/sequential_update.hpp>

namespace wayfare {

/// What the measurements after an instant say of the errors at it: the smoothed error is −P λ, its
/// covariance P − P Λ P. Zero where there are none.
template <Manifold M>
struct SmootherAdjoint {
  TangentOf<M> vector = TangentOf<M>::Zero();  ///< λ
  SquareOf<M> matrix = SquareOf<M>::Zero();    ///< Λ
};

/// The linear steps of an Ekf, and the estimates at marks between them. About 10 kB for a step and
/// a mark of 27 errors.
template <Manifold M>
class SmootherTape {
 public:
  using Scalar = typename ManifoldTraits<M>::Scalar;    ///< floating point
  using Tangent = TangentOf<M>;                         ///< an error of the state
  using Square = SquareOf<M>;                           ///< a covariance of errors
  static constexpr int kDof = ManifoldTraits<M>::kDof;  ///< number of errors

  /// An estimate by the measurements up to it.
  struct Mark {
    M state;            ///< filtered
    Square covariance;  ///< of its errors
  };
  /// A place on the tape.
  struct Place {
    std::size_t steps = 0,  ///< written before it
        entries = 0,        ///< of their matrices
        numbers = 0,        ///< of their updates
        marks = 0;          ///< among the steps
    /// The same place after the first `removed` were removed.
    Place& operator-=(const Place& removed) {
      steps -= removed.steps, entries -= removed.entries;
      numbers -= removed.numbers, marks -= removed.marks;
      return *this;
    }
  };

  /// x ← Φ x.
  void predicted(const Square& phi) {
    for (int j = 0; j < kDof; ++j)
      for (int i = 0; i < kDof; ++i) {
        const Scalar x = phi(i, j) - (i == j ? Scalar(1) : Scalar(0));
        if (x != Scalar(0))
          entries_.push_back({static_cast<std::int16_t>(i), static_cast<std::int16_t>(j), x});
      }
    steps_.push_back({Kind::transition, 0});
    close();
  }
  /// x ← x + K ν. `rows`: H, dense or sparse; `gain`: K; `inverse`: S⁻¹; `innovation`: ν.
  template <class Rows, class Gain, class Inverse, class Innovation>
  void updated(const Rows& rows, const Gain& gain, const Inverse& inverse,
               const Innovation& innovation) {
    constexpr int n = Inverse::RowsAtCompileTime;
    write(transposed<n>(rows));
    write(Eigen::Matrix<Scalar, kDof, n>(gain));
    write(Eigen::Matrix<Scalar, n, n>(inverse));
    write(Eigen::Matrix<Scalar, n, 1>(inverse * innovation));
    steps_.push_back({Kind::update, n});
    close();
  }
  /// Error i was replaced by one that is independent of all before it.
  void reset(int i) {
    steps_.push_back({Kind::reset, i});
    close();
  }
  /// All errors were: what follows says nothing of what was before.
  void restart() {
    steps_.push_back({Kind::restart, 0});
    close();
  }
  /// An instant of which the smoothed estimate is wanted.
  void mark(const M& state, const Square& covariance) {
    marks_.push_back({state, covariance});
    steps_.push_back({Kind::mark, 0});
    close();
  }

  /// Where the next step will be.
  [[nodiscard]] Place end() const {
    return {steps_.size(), entries_.size(), numbers_.size(), marks_.size()};
  }
  /// Removes what was written after `place`, an earlier end().
  void truncate(const Place& place) {
    steps_.resize(place.steps);
    entries_.resize(place.entries);
    numbers_.resize(place.numbers);
    marks_.resize(place.marks);
  }
  /// Removes the first `marks` marks and all that was written before the last of them; returns
  /// what was removed.
  Place drop_marks(std::size_t marks) {
    if (marks == 0) return {};
    std::size_t step = 0;
    for (std::size_t seen = 0; seen < marks; ++step)
      if (steps_[step].kind == Kind::mark) ++seen;
    const Place from{step, steps_[step - 1].entries, steps_[step - 1].numbers, marks};
    erase(steps_, step), erase(entries_, from.entries), erase(numbers_, from.numbers);
    erase(marks_, marks);
    for (Step& s : steps_) s.entries -= from.entries, s.numbers -= from.numbers;
    return from;
  }
  /// Number of marks.
  [[nodiscard]] std::size_t marks() const { return marks_.size(); }

  /// Reads the tape from its end to its beginning. `adjoint` is that of its end and becomes that of
  /// its beginning. At each mark calls smoothed(its number, its Mark, adjoint), where the number
  /// counts from zero and `adjoint` is that of the mark.
  template <class Smoothed>
  requires std::invocable < Smoothed, std::size_t, const Mark&, const SmootherAdjoint<M>
  & > void back(SmootherAdjoint<M>& adjoint, Smoothed&& smoothed) const {
    std::size_t mark = marks_.size();
    for (std::size_t i = steps_.size(); i-- > 0;) {
      switch (steps_[i].kind) {
        case Kind::transition:
          back_over_transition(i, adjoint);
          break;
        case Kind::update:
          back_over_update(i, adjoint);
          break;
        case Kind::reset:
          adjoint.vector[steps_[i].count] = Scalar(0);
          adjoint.matrix.row(steps_[i].count).setZero();
          adjoint.matrix.col(steps_[i].count).setZero();
          break;
        case Kind::restart:
          adjoint = {};
          break;
        case Kind::mark:
          --mark;
          smoothed(mark, marks_[mark], std::as_const(adjoint));
          break;
      }
    }
  }

 private:
  enum class Kind : std::uint8_t { transition, update, reset, restart, mark };
  struct Step {
    Kind kind;
    int count;                             ///< of rows; index of what is reset
    std::size_t entries = 0, numbers = 0;  ///< written up to its end
  };
  /// Of Φ − I.
  struct Entry {
    std::int16_t row, column;
    Scalar value;
  };

  void close() { steps_.back().entries = entries_.size(), steps_.back().numbers = numbers_.size(); }
  template <class V>
  static void erase(V& v, std::size_t count) {
    v.erase(v.begin(), v.begin() + static_cast<std::ptrdiff_t>(count));
  }

  template <class Matrix>
  void write(const Matrix& m) {
    numbers_.insert(numbers_.end(), m.data(), m.data() + m.size());
  }
  template <int n, int K>
  static Tangent transposed(const SparseRow<Scalar, K>& row) {
    Tangent h = Tangent::Zero();
    for (std::size_t k = 0; k < K; ++k) h[row.index[k]] += row.value[k];
    return h;
  }
  template <int n, class Rows>
  static Eigen::Matrix<Scalar, kDof, n> transposed(const Rows& rows) {
    if constexpr (requires { rows.index; }) {
      Eigen::Matrix<Scalar, kDof, n> h = Eigen::Matrix<Scalar, kDof, n>::Zero();
      for (std::size_t k = 0; k < rows.index.size(); ++k)
        h.row(rows.index[k]) += rows.value.col(static_cast<int>(k)).transpose();
      return h;
    } else {
      return rows.transpose();
    }
  }

  /// λ ← Φᵀ λ, Λ ← Φᵀ Λ Φ.
  void back_over_transition(std::size_t step, SmootherAdjoint<M>& adjoint) const {
    const std::size_t first = step == 0 ? 0 : steps_[step - 1].entries, end = steps_[step].entries;
    const Tangent vector = adjoint.vector;
    Square half = adjoint.matrix;
    for (std::size_t e = first; e < end; ++e) {
      const auto& [i, j, x] = entries_[e];
      adjoint.vector[j] += x * vector[i];
      half.col(j) += x * adjoint.matrix.col(i);
    }
    const Square rows = half.transpose();
    Square whole = rows;
    for (std::size_t e = first; e < end; ++e)
      whole.col(entries_[e].column) += entries_[e].value * rows.col(entries_[e].row);
    adjoint.matrix = Scalar(0.5) * (whole + whole.transpose());
  }

  /// λ ← (I − K H)ᵀ λ − Hᵀ S⁻¹ ν, Λ ← (I − K H)ᵀ Λ (I − K H) + Hᵀ S⁻¹ H.
  void back_over_update(std::size_t step, SmootherAdjoint<M>& adjoint) const {
    if (steps_[step].count == 1)
      back_over_update<1>(1, step, adjoint);
    else
      back_over_update<Eigen::Dynamic>(steps_[step].count, step, adjoint);
  }
  template <int N>
  void back_over_update(int n, std::size_t step, SmootherAdjoint<M>& adjoint) const {
    using Tall = Eigen::Map<const Eigen::Matrix<Scalar, kDof, N>>;
    const Scalar* at = numbers_.data() + (step == 0 ? 0 : steps_[step - 1].numbers);
    const Tall h(at, kDof, n), k(at + kDof * n, kDof, n);
    const Eigen::Map<const Eigen::Matrix<Scalar, N, N>> inverse(at + 2 * kDof * n, n, n);
    const Eigen::Map<const Eigen::Matrix<Scalar, N, 1>> weighted(at + (2 * kDof + n) * n, n);
    adjoint.vector -= h * (k.transpose() * adjoint.vector + weighted);
    const Eigen::Matrix<Scalar, kDof, N> q = adjoint.matrix * k;
    const Eigen::Matrix<Scalar, N, N> inner = k.transpose() * q + inverse;
    const Eigen::Matrix<Scalar, kDof, N> r = Scalar(0.5) * (h * inner) - q;
    adjoint.matrix += r * h.transpose() + h * r.transpose();
  }

  std::vector<Step> steps_;
  std::vector<Entry> entries_;
  std::vector<Scalar> numbers_;
  std::vector<Mark> marks_;
};

/// The estimate at a mark by all measurements: x ⊞ (−P λ), with covariance P − P Λ P.
template <Manifold M>
[[nodiscard]] typename SmootherTape<M>::Mark smoothed(const typename SmootherTape<M>::Mark& mark,
                                                      const SmootherAdjoint<M>& adjoint) {
  using Scalar = typename ManifoldTraits<M>::Scalar;
  const SquareOf<M>& p = mark.covariance;
  const SquareOf<M> after = p - p * adjoint.matrix * p;
  return {ManifoldTraits<M>::plus(mark.state, TangentOf<M>(-(p * adjoint.vector))),
          Scalar(0.5) * (after + after.transpose())};
}

/// The Recorder of an Ekf that writes to a tape while it has one. add_variance and scale_sigma
/// count as noise of the process.
template <Manifold M>
struct TapeRecorder {
  SmootherTape<M>* tape = nullptr;  ///< must outlive the recording

  /// As Ekf calls it.
  template <class Step>
  void predicted(const Step& step) {
    if (tape == nullptr) return;
    if constexpr (requires { step.phi(); })
      tape->predicted(step.phi());
    else
      tape->predicted(step.phi);
  }
  /// As Ekf calls it.
  template <class... Of>
  void updated(const Of&... of) {
    if (tape != nullptr) tape->updated(of...);
  }
  /// As Ekf calls it.
  void reset(int i) {
    if (tape != nullptr) tape->reset(i);
  }
};

}  // namespace wayfare
