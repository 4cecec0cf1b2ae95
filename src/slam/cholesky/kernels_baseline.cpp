#define WAYFARE_ISA baseline
#include "cholesky/kernels.inl"
