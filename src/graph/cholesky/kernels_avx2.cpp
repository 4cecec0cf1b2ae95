#define WAYFARE_ISA avx2
#include "graph/cholesky/kernels.inl"
