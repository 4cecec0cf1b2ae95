#define WAYFARE_ISA baseline
#include "map/kernels/kernels.inl"
