#define WAYFARE_ISA baseline
#include "field/kernels.inl"
