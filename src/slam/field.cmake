# Distance fields and localisation, with their own kernels for several instruction sets; flags as
# those of match.cmake.
target_sources(wayfare_slam PRIVATE
  field/dispatch.cpp
  field/distance_field.cpp
  field/kernels_baseline.cpp
  localisation/clusters.cpp
  localisation/draws.cpp
  localisation/localisation_map.cpp
  localisation/localiser.cpp
  localisation/motion_guard.cpp
  localisation/pose_filter.cpp
  localisation/run.cpp
  localisation/scan_weigher.cpp)
target_include_directories(wayfare_slam PRIVATE "${CMAKE_CURRENT_SOURCE_DIR}")
set_source_files_properties(field/kernels_baseline.cpp PROPERTIES
  COMPILE_OPTIONS "-O3;-ffp-contract=off")
if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
  target_sources(wayfare_slam PRIVATE field/kernels_avx2.cpp field/kernels_avx512.cpp)
  set_source_files_properties(field/kernels_avx2.cpp PROPERTIES
    COMPILE_OPTIONS "-O3;-ffp-contract=off;-mavx2")
  set_source_files_properties(field/kernels_avx512.cpp PROPERTIES
    COMPILE_OPTIONS "-O3;-ffp-contract=off;-mavx512f;-mavx512bw;-mavx512vl;-mavx512dq")
  set_source_files_properties(field/dispatch.cpp PROPERTIES
    COMPILE_DEFINITIONS WAYFARE_X86_KERNELS)
endif()
