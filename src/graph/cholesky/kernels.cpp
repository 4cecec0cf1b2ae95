// Compiled once for each instruction set, with WAYFARE_ISA naming its namespace.

#include "graph/cholesky/kernels.hpp"

// Wide vectors are passed only between functions of this file, so the ABI does not matter.
#pragma GCC diagnostic ignored "-Wpsabi"

#include "graph/cholesky/tiles.inl"
// In this order.
#include "graph/cholesky/assembly.inl"
#include "graph/cholesky/dense.inl"
#include "graph/cholesky/inverse.inl"
#include "graph/cholesky/substitution.inl"

namespace wayfare::cholesky::WAYFARE_ISA {
namespace {

template <int N>
constexpr FrontKernels kTable = {scatter<N>, add_to_panel<N>,  add_to_update<N>, factorise<N>,
                                 update<N>,  gather<N>,        forward<N>,       backward<N>,
                                 invert<N>,  gather_inverse<N>};

}  // namespace

const FrontKernels& table(int block) {
  return block == 2 ? kTable<2> : block == 3 ? kTable<3> : kTable<6>;
}

}  // namespace wayfare::cholesky::WAYFARE_ISA
