#pragma once

#include <Eigen/Core>

namespace wayfare {

/// A vector of space and a zero, initially zero. It fills whole registers: three numbers are
/// written as two and one, and reading them together then waits for the memory.
template <class T>
struct PaddedVector : Eigen::Matrix<T, 4, 1> {
  using Base = Eigen::Matrix<T, 4, 1>;
  using Vector = Eigen::Matrix<T, 3, 1>;

  PaddedVector() : Base(Base::Zero()) {}
  /// A sum of whole registers, lest the numbers be written one by one.
  PaddedVector(T x, T y, T z)
      : Base(x * Base(1, 0, 0, 0) + y * Base(0, 1, 0, 0) + z * Base(0, 0, 1, 0)) {}
  /// Of three numbers, or of four of which the last is zero.
  template <class Expression>
  PaddedVector(const Eigen::MatrixBase<Expression>& v) : PaddedVector(v.eval()) {}
  PaddedVector(const Vector& v) : PaddedVector(v.x(), v.y(), v.z()) {}
  PaddedVector(const Base& v) : Base(v) {}

  [[nodiscard]] Vector unpadded() const { return this->template head<3>(); }
  /// The cross product: in cyclic permutations, each of which is one instruction.
  [[nodiscard]] PaddedVector cross(const PaddedVector& b) const {
    return PaddedVector(this->cwiseProduct(b.cyclic()) - cyclic().cwiseProduct(b)).cyclic();
  }

 private:
  /// y, z, x.
  [[nodiscard]] PaddedVector cyclic() const {
    const Base& v = *this;
    return Base(v[1], v[2], v[0], v[3]);
  }
};

}  // namespace wayfare
