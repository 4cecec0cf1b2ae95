#define WAYFARE_ISA avx2
#include "kernels.inl"
