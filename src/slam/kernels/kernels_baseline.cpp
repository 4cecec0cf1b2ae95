#define WAYFARE_ISA baseline
#include "kernels.inl"
