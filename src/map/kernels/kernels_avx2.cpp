#define WAYFARE_ISA avx2
#include "map/kernels/kernels.inl"
