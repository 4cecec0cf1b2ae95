#define WAYFARE_ISA avx512
#include "kernels.inl"
