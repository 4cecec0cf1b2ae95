#define WAYFARE_ISA avx512
#include "graph/cholesky/kernels.inl"
