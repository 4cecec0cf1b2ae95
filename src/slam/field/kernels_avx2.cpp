#define WAYFARE_ISA avx2
#include "field/kernels.inl"
