#define WAYFARE_ISA avx512
#include "map/kernels/kernels.inl"
