#define WAYFARE_ISA avx512
#include "map/distance_field/kernels.inl"
