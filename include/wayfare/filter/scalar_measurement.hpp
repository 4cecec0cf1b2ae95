#pragma once

// The output of a measurement model.

#include <array>

namespace wayfare {

/// A row of H of which only K entries are not zero.
template <class T, int K>
struct SparseRow {
  std::array<int, K> index;
  std::array<T, K> value;
};

/// A scalar measurement, linearised at the predicted state: innovation z − h(x), row of ∂h/∂x in
/// the state's tangent (a 1×n matrix or a SparseRow), variance of the noise.
template <class T, class Row>
struct ScalarMeasurement {
  T innovation;
  Row row;
  T variance;
};

}  // namespace wayfare
