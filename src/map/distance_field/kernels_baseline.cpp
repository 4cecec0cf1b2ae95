#define WAYFARE_ISA baseline
#include "map/distance_field/kernels.inl"
