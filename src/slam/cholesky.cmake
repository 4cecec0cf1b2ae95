# The multifrontal Cholesky, with its own kernels for several instruction sets. Products and sums may
# be contracted here: results differ in the last bits between instruction sets, not between runs.
target_sources(wayfare_slam PRIVATE
  cholesky/dispatch.cpp
  cholesky/elimination_tree.cpp
  cholesky/factor.cpp
  cholesky/fronts.cpp
  cholesky/kernels_baseline.cpp
  cholesky/minimum_degree.cpp
  cholesky/multifrontal_cholesky.cpp
  cholesky/parallel.cpp
  cholesky/rank.cpp
  cholesky/selected_inverse.cpp
  cholesky/supernodes.cpp)
set_source_files_properties(cholesky/kernels_baseline.cpp PROPERTIES
  COMPILE_OPTIONS "-O3;-ffp-contract=fast")
if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
  target_sources(wayfare_slam PRIVATE cholesky/kernels_avx2.cpp cholesky/kernels_avx512.cpp)
  set_source_files_properties(cholesky/kernels_avx2.cpp PROPERTIES
    COMPILE_OPTIONS "-O3;-ffp-contract=fast;-mavx2;-mfma")
  set_source_files_properties(cholesky/kernels_avx512.cpp PROPERTIES
    COMPILE_OPTIONS "-O3;-ffp-contract=fast;-mfma;-mavx512f;-mavx512bw;-mavx512vl;-mavx512dq")
  set_source_files_properties(cholesky/dispatch.cpp PROPERTIES
    COMPILE_DEFINITIONS WAYFARE_X86_KERNELS)
endif()
