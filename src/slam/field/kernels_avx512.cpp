#define WAYFARE_ISA avx512
#include "field/kernels.inl"
