#pragma once

// The instruction sets that kernels are compiled for, and which of them this machine supports. A
// folder of kernels contains one portable source, compiled as baseline, avx2 and avx512 into
// namespaces of these names (wayfare_kernels of cmake/WayfareTargets.cmake); its dispatch.cpp
// selects with WAYFARE_VARIANT.

namespace wayfare {

/// `avx2` includes fused multiply-add; `avx512` is F, BW, VL and DQ with it.
enum class Isa { baseline, avx2, avx512 };

/// Whether kernels for it exist and this machine supports them.
[[nodiscard]] inline bool runs_here(Isa isa) {
  if (isa == Isa::baseline) return true;
#ifdef __x86_64__
  if (!__builtin_cpu_supports("fma")) return false;
  if (isa == Isa::avx2) return __builtin_cpu_supports("avx2");
  return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
         __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512dq");
#else
  return false;
#endif
}

/// The widest one supported.
[[nodiscard]] inline Isa best_isa() {
  static const Isa best = runs_here(Isa::avx512) ? Isa::avx512
                          : runs_here(Isa::avx2) ? Isa::avx2
                                                 : Isa::baseline;
  return best;
}

}  // namespace wayfare

// Declares something in every variant's namespace; evaluates it in that of `isa`.
#ifdef __x86_64__
#define WAYFARE_DECLARE_VARIANTS(...) \
  namespace baseline {                \
  __VA_ARGS__;                        \
  }                                   \
  namespace avx2 {                    \
  __VA_ARGS__;                        \
  }                                   \
  namespace avx512 {                  \
  __VA_ARGS__;                        \
  }
#define WAYFARE_VARIANT(isa, ...)             \
  ((isa) == Isa::avx512 ? avx512::__VA_ARGS__ \
   : (isa) == Isa::avx2 ? avx2::__VA_ARGS__   \
                        : baseline::__VA_ARGS__)
#else
#define WAYFARE_DECLARE_VARIANTS(...) \
  namespace baseline {                \
  __VA_ARGS__;                        \
  }
#define WAYFARE_VARIANT(isa, ...) (static_cast<void>(isa), baseline::__VA_ARGS__)
#endif
