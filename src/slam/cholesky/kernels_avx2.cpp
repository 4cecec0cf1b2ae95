#define WAYFARE_ISA avx2
#include "cholesky/kernels.inl"
