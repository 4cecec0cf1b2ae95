#define WAYFARE_ISA avx512
#include "cholesky/kernels.inl"
