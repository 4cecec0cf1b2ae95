# Helpers for our own tree; nothing here reaches a consumer.

# wayfare_component(NAME [INTERFACE]): target wayfare_NAME, alias wayfare::NAME.
function(wayfare_component name)
  set(target wayfare_${name})
  if("INTERFACE" IN_LIST ARGN)
    add_library(${target} INTERFACE)
    set(scope INTERFACE)
  else()
    add_library(${target} STATIC)
    set(scope PUBLIC)
    wayfare_warnings(${target})
    set_target_properties(${target} PROPERTIES POSITION_INDEPENDENT_CODE ON)
  endif()
  add_library(wayfare::${name} ALIAS ${target})
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${name})
  target_compile_features(${target} ${scope} cxx_std_20)
  target_include_directories(${target} ${scope}
    "$<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include>"
    "$<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>")
  set_property(GLOBAL APPEND PROPERTY WAYFARE_COMPONENTS ${name})
endfunction()

# Warnings are errors in our own build only.
function(wayfare_warnings target)
  if(PROJECT_IS_TOP_LEVEL)
    target_compile_options(${target} PRIVATE -Wall -Wextra -Wpedantic -Wconversion -Wshadow -Werror)
  endif()
endfunction()

# wayfare_program(NAME SOURCES... LIBS ...): an example program.
function(wayfare_program name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LIBS" ${ARGN})
  add_executable(${name} ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE ${ARG_LIBS})
  wayfare_warnings(${name})
endfunction()

# wayfare_test(NAME SOURCES ... LIBS ...): one gtest executable, every case its own ctest entry.
function(wayfare_test name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LIBS" ${ARGN})
  add_executable(test_${name} ${ARG_SOURCES})
  target_link_libraries(test_${name} PRIVATE ${ARG_LIBS} GTest::gmock GTest::gtest_main)
  target_include_directories(test_${name} PRIVATE "${PROJECT_SOURCE_DIR}/tests")
  target_compile_definitions(test_${name} PRIVATE WAYFARE_DATA_DIR="${WAYFARE_DATA_DIR}")
  wayfare_warnings(test_${name})
  # Tests spend their time in the compiler, most of it on templates of Eigen and gtest.
  target_compile_options(test_${name} PRIVATE $<$<CONFIG:Release>:-O1>)
  if(WAYFARE_UNITY_TESTS)
    set_target_properties(test_${name} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 8)
  endif()
  gtest_discover_tests(test_${name} DISCOVERY_TIMEOUT 60 NO_PRETTY_VALUES)
endfunction()

# wayfare_benchmark(NAME SOURCES ... LIBS ...): bench_NAME, with Google Benchmark's main.
function(wayfare_benchmark name)
  find_package(benchmark REQUIRED)
  wayfare_program(bench_${name} ${ARGN})
  target_link_libraries(bench_${name} PRIVATE benchmark::benchmark_main)
  target_compile_definitions(bench_${name} PRIVATE WAYFARE_DATA_DIR="${WAYFARE_DATA_DIR}")
endfunction()
