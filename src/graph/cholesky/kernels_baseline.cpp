#define WAYFARE_ISA baseline
#include "graph/cholesky/kernels.inl"
