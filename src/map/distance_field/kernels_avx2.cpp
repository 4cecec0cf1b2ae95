#define WAYFARE_ISA avx2
#include "map/distance_field/kernels.inl"
