#pragma once

// Gates of measurements with any number of dimensions; see gate.hpp.

#include <array>
#include <cmath>
#include <cstddef>

#include <wayfare/core/contract.hpp>
#include <wayfare/core/pack.hpp>
#include <wayfare/core/statistics.hpp>
#include <wayfare/filter/gate.hpp>

namespace wayfare {

/// Rejects innovations that are larger than this share, in [0, 1), of those of a consistent filter.
/// For measurements of up to six numbers.
class ChiSquareGate {
 public:
  /// `probability` in [0, 1): the share of a consistent filter's measurements that are accepted.
  explicit ChiSquareGate(double probability) {
    for (std::size_t i = 0; i < limits_.size(); ++i)
      limits_[i] = chi_square_quantile(probability, static_cast<double>(i + 1));
  }
  /// Whether the normalised innovation squared is within the quantile of χ² with Dim degrees of
  /// freedom.
  template <class T, int Dim>
  [[nodiscard]] MaskOf<T> operator()(const Innovation<T, Dim>& i) const {
    static_assert(Dim >= 1 && Dim <= kLargestDim);
    return i.nis <= T(limits_[Dim - 1]);
  }

 private:
  static constexpr int kLargestDim = 6;
  std::array<double, kLargestDim> limits_{};
};

/// Huber's weight: 1 up to `sigmas`, then sigmas/√nis, so that the covariance of the measurement
/// grows and its influence is limited (Ďurović and Kovačević 1999).
struct HuberWeight {
  double sigmas = 1.345;  ///< of the innovation, √nis

  /// The weight of the measurement, in (0, 1].
  template <class T, int Dim>
  [[nodiscard]] T operator()(const Innovation<T, Dim>& i) const {
    using std::sqrt;
    const T limit = T(sigmas);
    return select(i.nis > limit * limit, T(limit / sqrt(i.nis)), T(1));
  }
};

}  // namespace wayfare
