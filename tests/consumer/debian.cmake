# Makes the Debian packages of the build BUILD, unpacks them into a folder, and uses what is there:
# files, dependencies, programs, man pages, completions, find_package and pkg-config.
find_program(cpack cpack HINTS "${CMAKE_COMMAND}/..")
foreach(tool IN ITEMS dpkg-deb dpkg-shlibdeps gzip bash)
  find_program(${tool}_path ${tool})
  if(NOT ${tool}_path)
    message("skipped: needs ${tool}")
    return()
  endif()
endforeach()
file(REMOVE_RECURSE "${WORK}")
execute_process(COMMAND "${cpack}" --config "${BUILD}/CPackConfig.cmake" -B "${WORK}/packages"
                        -D CPACK_DEBIAN_COMPRESSION_TYPE=none
                OUTPUT_VARIABLE text ERROR_VARIABLE text RESULT_VARIABLE code)
if(NOT code EQUAL 0)
  message(FATAL_ERROR "cpack: ${code}\n${text}")
endif()

function(expect what text regex)
  if(NOT text MATCHES "${regex}")
    message(FATAL_ERROR "${what}: expected '${regex}' in:\n${text}")
  endif()
endfunction()
function(field out file name)
  execute_process(COMMAND dpkg-deb -f "${file}" ${name} OUTPUT_VARIABLE value
                  OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
  set(${out} "${value}" PARENT_SCOPE)
endfunction()
set(root "${WORK}/unpacked")
foreach(package IN ITEMS libwayfare-dev wayfare-tools)
  file(GLOB file "${WORK}/packages/${package}_${VERSION}-1_*.deb")
  if(NOT EXISTS "${file}")
    message(FATAL_ERROR "no package ${package} in ${WORK}/packages")
  endif()
  execute_process(COMMAND dpkg-deb -x "${file}" "${root}" COMMAND_ERROR_IS_FATAL ANY)
  field(${package}_depends "${file}" Depends)
  field(maintainer "${file}" Maintainer)
  expect("${package}: Maintainer" "${maintainer}" "<.+@.+>")
  foreach(document IN ITEMS copyright changelog.gz changelog.Debian.gz)
    if(NOT EXISTS "${root}/usr/share/doc/${package}/${document}")
      message(FATAL_ERROR "${package} has no ${document}")
    endif()
  endforeach()
endforeach()
foreach(package IN ITEMS libeigen3-dev zlib1g-dev libpng-dev)
  expect("libwayfare-dev: Depends" "${libwayfare-dev_depends}" "${package}")
endforeach()
foreach(package IN ITEMS libc6 libstdc..6 libpng16-16 zlib1g)  # by dpkg-shlibdeps
  expect("wayfare-tools: Depends" "${wayfare-tools_depends}" "(^|, )${package} ")
endforeach()
foreach(file IN ITEMS include/wayfare/core.hpp "${LIBDIR}/libwayfare_io.a"
                      "${LIBDIR}/cmake/wayfare/wayfareConfig.cmake" "${LIBDIR}/pkgconfig/wayfare-io.pc"
                      share/doc/libwayfare-dev/docs/programs.md)
  if(NOT EXISTS "${root}/usr/${file}")
    message(FATAL_ERROR "libwayfare-dev has no ${file}")
  endif()
endforeach()
file(GLOB_RECURSE sources "${root}/usr/include/*")
list(FILTER sources EXCLUDE REGEX "[.]hpp$")
expect("other files than headers in include" "[${sources}]" "^\\[\\]$")

# Programs: each runs, and has a man page and a completion of its own name.
file(GLOB programs "${root}/usr/bin/wayfare-*")
list(LENGTH programs count)
if(count LESS 25)
  message(FATAL_ERROR "only ${count} programs")
endif()
find_program(groff groff)
foreach(program IN LISTS programs)
  get_filename_component(name "${program}" NAME)
  execute_process(COMMAND "${program}" --version OUTPUT_VARIABLE text COMMAND_ERROR_IS_FATAL ANY)
  expect("${name} --version" "${text}" "^${name} ${VERSION}\n$")
  execute_process(COMMAND gzip -dc "${root}/usr/share/man/man1/${name}.1.gz" OUTPUT_VARIABLE page
                  COMMAND_ERROR_IS_FATAL ANY)
  string(REPLACE "\\-" "-" plain "${page}")
  expect("the page of ${name}" "${plain}" "SH NAME\n${name} ")
  if(groff)
    file(WRITE "${WORK}/page.1" "${page}")
    execute_process(COMMAND "${groff}" -man -ww -z -Tutf8 -K utf8 "${WORK}/page.1"
                    ERROR_VARIABLE warnings)
    expect("the page of ${name}: warnings of groff" "[${warnings}]" "^\\[\\]$")
  endif()
  execute_process(COMMAND bash -n "${root}/usr/share/bash-completion/completions/${name}"
                  COMMAND_ERROR_IS_FATAL ANY)
endforeach()
execute_process(COMMAND "${root}/usr/bin/wayfare-simulate" "${ROOT}/tests/sim/room.plan"
                        --out "${WORK}/room.log" --quiet COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND "${root}/usr/bin/wayfare-graph_slam" "${WORK}/room.log" --json - --out
                        "${WORK}/room" OUTPUT_VARIABLE json ERROR_QUIET COMMAND_ERROR_IS_FATAL ANY)
string(JSON title GET "${json}" title)
expect("--json -" "${title}" "graph SLAM of .*room.log")

# The moved folder is found by CMake and by pkg-config.
execute_process(COMMAND "${CMAKE_COMMAND}" -S "${CMAKE_CURRENT_LIST_DIR}/refusal" -B "${WORK}/asks"
                        "-DCMAKE_CXX_COMPILER=${CXX}" "-DCMAKE_PREFIX_PATH=${root}/usr"
                        "-DCOMPONENTS=slam;io"
                OUTPUT_VARIABLE text ERROR_VARIABLE errors)
expect("find_package" "${text}${errors}" "found: 1")
find_program(pkg_config NAMES pkgconf pkg-config)
if(pkg_config)
  set(ENV{PKG_CONFIG_PATH} "${root}/usr/${LIBDIR}/pkgconfig")
  execute_process(COMMAND "${pkg_config}" --libs --cflags wayfare-slam OUTPUT_VARIABLE text
                  COMMAND_ERROR_IS_FATAL ANY)
  expect("pkg-config" "${text}" "-L[^ ]*${root}/usr/[^ ]* ")
endif()
