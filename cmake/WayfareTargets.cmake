# Helpers for our own tree; nothing here reaches a consumer.

# wayfare_precompile(TARGET KIND HEADER...): with WAYFARE_FAST_BUILD the headers named are compiled once
# for all targets of a kind (those with the same flags). Parsing Eigen, the standard library and gtest
# takes a third to a half of a unit's time. The kind's own options are set in every build.
function(wayfare_precompile target kind)
  set(options "")
  if(kind STREQUAL "programs")
    set(options ${WAYFARE_PROGRAM_OPTIONS})
  elseif(kind MATCHES "^tests(-O[01])$")
    set(options $<$<CONFIG:Release>:${CMAKE_MATCH_1}>)
  endif()
  target_compile_options(${target} PRIVATE ${options})
  if(NOT WAYFARE_FAST_BUILD OR NOT PROJECT_IS_TOP_LEVEL)
    return()
  endif()
  # The headers of all programs include those of libraries that some do not link.
  set(definitions "")
  if(kind MATCHES "^(library|programs)$")
    set(definitions WAYFARE_LIBRARY)
  endif()
  target_compile_definitions(${target} PRIVATE ${definitions})
  if(NOT TARGET wayfare_precompiled_${kind})
    file(CONFIGURE OUTPUT "${PROJECT_BINARY_DIR}/precompiled_${kind}.cpp" CONTENT "")
    add_library(wayfare_precompiled_${kind} OBJECT "${PROJECT_BINARY_DIR}/precompiled_${kind}.cpp")
    target_compile_features(wayfare_precompiled_${kind} PRIVATE cxx_std_20)
    target_link_libraries(wayfare_precompiled_${kind} PRIVATE Eigen3::Eigen)
    target_include_directories(wayfare_precompiled_${kind} PRIVATE "${PROJECT_SOURCE_DIR}/include")
    if(kind STREQUAL "library")
      set_target_properties(wayfare_precompiled_${kind} PROPERTIES POSITION_INDEPENDENT_CODE ON)
    elseif(kind MATCHES "^tests")
      target_link_libraries(wayfare_precompiled_${kind} PRIVATE GTest::gmock)
    elseif(kind STREQUAL "programs")
      list(APPEND ARGN <wayfare/motion.hpp> <wayfare/eval.hpp> <wayfare/io.hpp>)
    endif()
    wayfare_warnings(wayfare_precompiled_${kind})
    target_compile_definitions(wayfare_precompiled_${kind} PRIVATE ${definitions})
    target_compile_options(wayfare_precompiled_${kind} PRIVATE ${options})
    wayfare_precompiled_options(wayfare_precompiled_${kind})
    if(NOT kind STREQUAL "library")  # which others link without these headers
      wayfare_precompiled_code(wayfare_precompiled_${kind} ${options})
    endif()
    target_precompile_headers(wayfare_precompiled_${kind} PRIVATE
      <algorithm> <array> <chrono> <cmath> <cstdint> <cstdio> <filesystem> <fstream> <functional>
      <iomanip> <iostream> <limits> <map> <memory> <mutex> <numeric> <optional> <set> <span> <sstream>
      <string> <string_view> <thread> <utility> <variant> <vector>
      <Eigen/Cholesky> <Eigen/Core> <Eigen/Eigenvalues> <Eigen/Geometry> <Eigen/LU>
      ${ARGN} <wayfare/core.hpp> <wayfare/sensors.hpp>)
  endif()
  target_precompile_headers(${target} REUSE_FROM wayfare_precompiled_${kind})
  wayfare_precompiled_options(${target})
endfunction()

# wayfare_precompiled_code(TARGET OPTION...): Clang compiles the inline functions of TARGET's precompiled
# headers once, into libTARGET.a, and the units that use them do not.
function(wayfare_precompiled_code target)
  if(NOT CMAKE_CXX_COMPILER_ID STREQUAL "Clang")
    return()
  endif()
  set(headers "${CMAKE_CURRENT_BINARY_DIR}/CMakeFiles/${target}.dir/cmake_pch.hxx.pch")
  set(object "${PROJECT_BINARY_DIR}/${target}.o")
  set(archive "${PROJECT_BINARY_DIR}/lib${target}.a")
  string(TOUPPER "${CMAKE_BUILD_TYPE}" build_type)
  separate_arguments(flags UNIX_COMMAND "${CMAKE_CXX_FLAGS} ${CMAKE_CXX_FLAGS_${build_type}}")
  target_compile_options(${target} PRIVATE -fpch-codegen -Wno-unused-command-line-argument)
  add_custom_command(OUTPUT "${archive}" BYPRODUCTS "${object}"
    COMMAND "${CMAKE_CXX_COMPILER}" ${flags} ${ARGN} -ffp-contract=off -c "${headers}" -o "${object}"
    COMMAND "${CMAKE_COMMAND}" -E rm -f "${archive}"
    COMMAND "${CMAKE_AR}" qc "${archive}" "${object}"
    COMMAND "${CMAKE_RANLIB}" "${archive}"
    DEPENDS ${target} "${headers}" COMMENT "Compiling inline functions of ${target}" VERBATIM)
  add_custom_target(${target}_code DEPENDS "${archive}")
  set_target_properties(${target} PROPERTIES WAYFARE_CODE "${archive}")
endfunction()

# wayfare_link_precompiled_code(TARGET SCOPE KIND): what units of this kind need of it.
function(wayfare_link_precompiled_code target scope kind)
  if(TARGET wayfare_precompiled_${kind}_code)
    get_target_property(archive wayfare_precompiled_${kind} WAYFARE_CODE)
    target_link_libraries(${target} ${scope} "${archive}")
    # Some of what is not used cannot be linked: gtest has no char8_t.
    target_link_options(${target} ${scope} LINKER:--gc-sections)
    add_dependencies(${target} wayfare_precompiled_${kind}_code)
  endif()
endfunction()

# wayfare_unite(TARGET): with WAYFARE_FAST_BUILD the sources of a target are compiled eight at a time, which
# instantiates what they share once. Names in their unnamed namespaces therefore differ.
# GCC warns of types in unnamed namespaces that other types contain where the source is not the main file.
function(wayfare_unite target)
  if(WAYFARE_FAST_BUILD AND PROJECT_IS_TOP_LEVEL)
    set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 8)
    target_compile_options(${target} PRIVATE $<$<CXX_COMPILER_ID:GNU>:-Wno-subobject-linkage>)
  endif()
endfunction()

# wayfare_link_first(LIBRARY): of an inline function with several copies the linker keeps the first. With
# WAYFARE_FAST_BUILD programs and tests are compiled with little or no optimisation; so that the library
# does not run by their copies, all its objects stand before theirs.
function(wayfare_link_first library)
  if(WAYFARE_FAST_BUILD AND PROJECT_IS_TOP_LEVEL)
    target_link_options(${library} INTERFACE
      "$<BUILD_INTERFACE:LINKER:--whole-archive,$<TARGET_FILE:${library}>,--no-whole-archive>")
  endif()
endfunction()

# GCC 12 warns falsely inside std::string once that is precompiled; these checks are made where a unit is
# compiled by itself, as in every build without WAYFARE_FAST_BUILD.
# Each garbage collection of GCC reads all that was precompiled: below 4 GB of its own there is none,
# which takes a fifth less time and a sixth more memory (0.8 to 3 GB a unit).
function(wayfare_precompiled_options target)
  target_compile_options(${target} PRIVATE
    $<$<CXX_COMPILER_ID:GNU>:-Wno-stringop-overflow;--param=ggc-min-heapsize=4000000>)
endfunction()

# wayfare_component(NAME [INTERFACE] [SOURCES ...] [PUBLIC ...] [PRIVATE ...]): target wayfare_NAME,
# alias wayfare::NAME, linked to WAYFARE_USES, the components src/CMakeLists.txt says it uses. PUBLIC
# and PRIVATE are foreign libraries; a header-only component is INTERFACE. Of WAYFARE_LIBRARY see
# core/detail/eigen_alignment.hpp.
function(wayfare_component name)
  cmake_parse_arguments(ARG "INTERFACE" "" "SOURCES;PUBLIC;PRIVATE" ${ARGN})
  set(target wayfare_${name})
  if(ARG_INTERFACE)
    add_library(${target} INTERFACE)
    set(scope INTERFACE)
  else()
    add_library(${target} STATIC ${ARG_SOURCES})
    set(scope PUBLIC)
    wayfare_warnings(${target})
    set_target_properties(${target} PROPERTIES POSITION_INDEPENDENT_CODE ON)
    target_compile_definitions(${target} PRIVATE WAYFARE_LIBRARY)
    target_include_directories(${target} PRIVATE "${PROJECT_SOURCE_DIR}/src")
    target_link_libraries(${target} PRIVATE ${ARG_PRIVATE})
    wayfare_unite(${target})
    wayfare_precompile(${target} library)
    wayfare_link_first(${target})
  endif()
  target_link_libraries(${target} ${scope} ${WAYFARE_USES} ${ARG_PUBLIC})
  add_library(wayfare::${name} ALIAS ${target})
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${name})
  target_compile_features(${target} ${scope} cxx_std_20)
  target_include_directories(${target} ${scope}
    "$<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include>"
    "$<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>")
  set_property(GLOBAL APPEND PROPERTY WAYFARE_BUILT_COMPONENTS ${name})
endfunction()

# wayfare_kernels(NAME FOLDER OPTION...): one portable source of inner loops, FOLDER/kernels.cpp, compiled
# once for each instruction set ISA with WAYFARE_ISA=ISA. All symbols of these objects but `table` become
# local, and their section groups are dissolved: of an inline function with several copies the linker
# keeps any one for all callers, and a processor without wide registers must not get this one. For the
# same reason no code here is optimised at link time, and no symbol is unique.
function(wayfare_kernels name folder)
  if(NOT CMAKE_OBJCOPY)
    message(FATAL_ERROR "wayfare's component '${name}' needs objcopy (Debian: binutils)")
  endif()
  set(isas baseline)
  if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
    list(APPEND isas avx2 avx512)
  endif()
  set(options_baseline "")
  set(options_avx2 -mavx2 -mfma)
  set(options_avx512 -mfma -mavx512f -mavx512bw -mavx512vl -mavx512dq)
  target_sources(wayfare_${name} PRIVATE ${folder}/dispatch.cpp)
  foreach(isa IN LISTS isas)
    set(target wayfare_${name}_${folder}_${isa})
    add_library(${target} OBJECT ${folder}/kernels.cpp)
    wayfare_warnings(${target})
    set_target_properties(${target} PROPERTIES POSITION_INDEPENDENT_CODE ON)
    target_compile_features(${target} PRIVATE cxx_std_20)
    target_compile_definitions(${target} PRIVATE WAYFARE_LIBRARY WAYFARE_ISA=${isa})
    target_compile_options(${target} PRIVATE -O3 -fno-lto -ffp-contract=off ${ARGN} ${options_${isa}}
                                             $<$<CXX_COMPILER_ID:GNU>:-fno-gnu-unique>)
    target_include_directories(${target} PRIVATE "${PROJECT_SOURCE_DIR}/include" "${PROJECT_SOURCE_DIR}/src")
    target_link_libraries(${target} PRIVATE Eigen3::Eigen)
    set(object "${CMAKE_CURRENT_BINARY_DIR}/${folder}_${isa}.$<CONFIG>.o")
    add_custom_command(
      OUTPUT "${object}"
      COMMAND "${CMAKE_OBJCOPY}" --wildcard --remove-section=.group
              "--keep-global-symbol=_ZN7wayfare*5tableE*" $<TARGET_OBJECTS:${target}> "${object}"
      DEPENDS ${target} $<TARGET_OBJECTS:${target}>
      COMMENT "Making symbols of ${folder} for ${isa} local" VERBATIM)
    target_sources(wayfare_${name} PRIVATE "${object}")
  endforeach()
endfunction()

# Warnings are errors in our own build only. GCC 12 warns falsely inside std::string (GCC bug 105651), inside
# Eigen's umeyama and its products of small vectors, for 32-bit ARM inside its triangular solve, and tells of
# arguments that GCC 6 passed otherwise.
function(wayfare_warnings target)
  if(PROJECT_IS_TOP_LEVEL)
    target_compile_options(${target} PRIVATE -Wall -Wextra -Wpedantic -Wconversion -Wshadow -Werror
                                             $<$<CXX_COMPILER_ID:GNU>:-Wno-stringop-overread;-Wno-restrict;-Wno-array-bounds>)
    if(CMAKE_SYSTEM_PROCESSOR MATCHES "^arm" AND NOT CMAKE_SIZEOF_VOID_P EQUAL 8)
      target_compile_options(${target} PRIVATE $<$<CXX_COMPILER_ID:GNU>:-Wno-psabi;-Wno-maybe-uninitialized>)
    endif()
  endif()
endfunction()

# wayfare_library(NAME SOURCES ... PUBLIC ... PRIVATE ...): code shared by programs, not installed.
function(wayfare_library name)
  cmake_parse_arguments(ARG "" "" "SOURCES;PUBLIC;PRIVATE" ${ARGN})
  add_library(${name} STATIC ${ARG_SOURCES})
  target_compile_features(${name} PUBLIC cxx_std_20)
  target_include_directories(${name} PUBLIC "${PROJECT_SOURCE_DIR}/examples/programs")
  target_link_libraries(${name} PUBLIC ${ARG_PUBLIC} PRIVATE ${ARG_PRIVATE})
  wayfare_warnings(${name})
  wayfare_unite(${name})
  wayfare_precompile(${name} programs)
  wayfare_link_precompiled_code(${name} PUBLIC programs)
endfunction()

# wayfare_program(NAME SOURCES... LIBS ...): a program; the property WAYFARE_PROGRAMS lists all.
function(wayfare_program name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LIBS" ${ARGN})
  add_executable(${name} ${ARG_SOURCES})
  target_compile_features(${name} PRIVATE cxx_std_20)
  target_link_libraries(${name} PRIVATE ${ARG_LIBS})
  wayfare_warnings(${name})
  wayfare_unite(${name})
  wayfare_precompile(${name} programs)
  wayfare_link_precompiled_code(${name} PRIVATE programs)
  set_property(GLOBAL APPEND PROPERTY WAYFARE_PROGRAMS ${name})
endfunction()

# wayfare_test(NAME SOURCES ... BRIEF ... ALONE ... LIBS ...): one gtest executable, every case its own
# ctest entry. BRIEF are sources whose tests compute little: compiling them takes longer than running them
# without optimisation. ALONE are those of either with so many templates that they compile faster by
# themselves.
function(wayfare_test name)
  cmake_parse_arguments(ARG "" "" "SOURCES;BRIEF;ALONE;LIBS" ${ARGN})
  set_source_files_properties(${ARG_ALONE} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
  if(ARG_BRIEF)
    add_executable(test_${name} ${ARG_BRIEF})
    wayfare_test_sources(test_${name} -O0 ${ARG_LIBS})
    if(ARG_SOURCES)  # linked first: inline functions are these sources'
      add_library(test_${name}_long OBJECT ${ARG_SOURCES})
      wayfare_test_sources(test_${name}_long -O1 ${ARG_LIBS})
      target_sources(test_${name} PRIVATE $<TARGET_OBJECTS:test_${name}_long>)
    endif()
  else()
    add_executable(test_${name} ${ARG_SOURCES})
    wayfare_test_sources(test_${name} -O1 ${ARG_LIBS})
  endif()
  # Both levels have the same functions; those of -O1 serve both.
  if(ARG_SOURCES)
    wayfare_link_precompiled_code(test_${name} PRIVATE tests-O1)
  else()
    wayfare_link_precompiled_code(test_${name} PRIVATE tests-O0)
  endif()
  target_link_libraries(test_${name} PRIVATE GTest::gtest_main)
  gtest_discover_tests(test_${name} DISCOVERY_TIMEOUT 60 NO_PRETTY_VALUES)
endfunction()

# wayfare_test_sources(TARGET LEVEL LIB...): how sources of tests are compiled. Tests spend their time in
# the compiler, most of it on templates of Eigen and gtest.
function(wayfare_test_sources target level)
  target_compile_features(${target} PRIVATE cxx_std_20)
  target_link_libraries(${target} PRIVATE ${ARGN} GTest::gmock)
  # What has no public header is tested too.
  target_include_directories(${target} PRIVATE "${PROJECT_SOURCE_DIR}/tests" "${PROJECT_SOURCE_DIR}/src")
  target_compile_definitions(${target} PRIVATE WAYFARE_DATA_DIR="${WAYFARE_DATA_DIR}")
  wayfare_warnings(${target})
  wayfare_unite(${target})
  wayfare_precompile(${target} tests${level} <gtest/gtest.h> <gmock/gmock.h>)
endfunction()

# wayfare_benchmark(NAME SOURCES ... LIBS ...): bench_NAME, with Google Benchmark's main.
function(wayfare_benchmark name)
  wayfare_program(bench_${name} ${ARGN})
  set_target_properties(bench_${name} PROPERTIES UNITY_BUILD OFF)  # their sources share names
  target_link_libraries(bench_${name} PRIVATE benchmark::benchmark_main)
  target_include_directories(bench_${name} PRIVATE "${PROJECT_SOURCE_DIR}/tests"
                                                   "${PROJECT_SOURCE_DIR}/src")
  target_compile_definitions(bench_${name} PRIVATE WAYFARE_DATA_DIR="${WAYFARE_DATA_DIR}")
endfunction()
