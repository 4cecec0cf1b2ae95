# Sources of map/ and match/, and the kernels compiled for several instruction sets. The flags stay
# on these files alone; contraction is off so that every variant rounds alike.
target_sources(wayfare_slam PRIVATE
  blur.cpp
  correlative.cpp
  branch_and_bound.cpp
  climb.cpp
  detection_field.cpp
  detection_grid.cpp
  gauss_newton.cpp
  icp.cpp
  likelihood_field.cpp
  lines/beams.cpp
  lines/candidates.cpp
  lines/lines.cpp
  lines/segments.cpp
  lines/wall_fit.cpp
  match_grid.cpp
  ndt.cpp
  ndt_map.cpp
  occupancy_field.cpp
  max_pyramid.cpp
  pose_proposal.cpp
  probability_grid.cpp
  refine.cpp
  scene_constraint.cpp
  surface_map.cpp
  voxel_filter.cpp
  kernels/dispatch.cpp
  kernels/kernels_baseline.cpp)
set_source_files_properties(kernels/kernels_baseline.cpp PROPERTIES
  COMPILE_OPTIONS "-O3;-ffp-contract=off")
if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
  target_sources(wayfare_slam PRIVATE kernels/kernels_avx2.cpp kernels/kernels_avx512.cpp)
  set_source_files_properties(kernels/kernels_avx2.cpp PROPERTIES
    COMPILE_OPTIONS "-O3;-ffp-contract=off;-mavx2")
  set_source_files_properties(kernels/kernels_avx512.cpp PROPERTIES
    COMPILE_OPTIONS "-O3;-ffp-contract=off;-mavx512f;-mavx512bw;-mavx512vl;-mavx512dq")
  set_source_files_properties(kernels/dispatch.cpp PROPERTIES
    COMPILE_DEFINITIONS WAYFARE_X86_KERNELS)
endif()
