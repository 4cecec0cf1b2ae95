# Every component's pkg-config file is complete, and a program is compiled and linked by them alone,
# in a folder other than the one it was installed for. LIBDIR has the installed libraries.
find_program(pkg_config NAMES pkgconf pkg-config)
if(NOT pkg_config)
  message("skipped: needs pkg-config")
  return()
endif()
file(GLOB files "${LIBDIR}/pkgconfig/wayfare-*.pc")
if(NOT files)
  message(FATAL_ERROR "no pkg-config files in ${LIBDIR}/pkgconfig")
endif()
set(ENV{PKG_CONFIG_PATH} "${LIBDIR}/pkgconfig")
foreach(file IN LISTS files)
  get_filename_component(module "${file}" NAME_WLE)
  execute_process(COMMAND "${pkg_config}" --print-errors --cflags --libs ${module}
                  OUTPUT_VARIABLE flags COMMAND_ERROR_IS_FATAL ANY)
  if(NOT flags MATCHES "-I.*/include" OR flags MATCHES "@|NOTFOUND")
    message(FATAL_ERROR "${module}: ${flags}")
  endif()
endforeach()

function(flags_of out)
  execute_process(COMMAND "${pkg_config}" ${ARGN} OUTPUT_VARIABLE flags
                  OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
  separate_arguments(flags UNIX_COMMAND "${flags}")
  set(${out} "${flags}" PARENT_SCOPE)
endfunction()
flags_of(cflags --cflags wayfare-io)
flags_of(libs --libs wayfare-io)
separate_arguments(FLAGS UNIX_COMMAND "${FLAGS}")
file(REMOVE_RECURSE "${WORK}")
file(MAKE_DIRECTORY "${WORK}")
execute_process(COMMAND "${CXX}" -std=c++20 ${FLAGS} ${cflags} "${CMAKE_CURRENT_LIST_DIR}/pkg_config/main.cpp"
                        -o "${WORK}/reads_a_graph" ${libs} COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND "${WORK}/reads_a_graph" OUTPUT_VARIABLE text COMMAND_ERROR_IS_FATAL ANY)
# Two measurements of one distance, 1.0 m and 0.9 m: 2 (0.05 m)^2 at the optimum.
if(NOT text STREQUAL "poses 2, cost 0.0050\n")
  message(FATAL_ERROR "expected 'poses 2, cost 0.0050', got '${text}'")
endif()
