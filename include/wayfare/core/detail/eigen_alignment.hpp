#pragma once

// Compiled for AVX, Eigen aligns small matrices to more bytes and allocates large ones in another
// way: structures have another layout, and a matrix must be freed by the code that allocated it. So
// that a program compiled otherwise than the libraries it links to does not run but fails to link,
// headers of compiled families refer to a symbol that libraries define for their own alignment.

#include <Eigen/Core>

namespace wayfare::detail {

/// Bytes of alignment of small matrices and of large ones; whether large ones are from malloc.
template <int small, int large, bool by_malloc>
struct LibrariesWithEigenAlignment {
  static const char linked;
};
using EigenAlignment =
    LibrariesWithEigenAlignment<EIGEN_MAX_STATIC_ALIGN_BYTES, EIGEN_MAX_ALIGN_BYTES,
                                EIGEN_MALLOC_ALREADY_ALIGNED != 0>;

#ifdef WAYFARE_LIBRARY
template <>
[[gnu::used]] inline const char EigenAlignment::linked = 0;
#else
[[gnu::used, gnu::retain]] constexpr const char* kEigenAlignment = &EigenAlignment::linked;
#endif

}  // namespace wayfare::detail
