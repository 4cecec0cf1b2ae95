# The packages of others that components link: how Debian, pkg-config and the linker call each. The
# CMake package, the pkg-config files and the Debian packages read it.
#
# wayfare_foreign(PACKAGE DEBIAN package REQUIRES pkg-config module LIBS linker flags CFLAGS compiler
# flags): what find_package(PACKAGE) finds. LIBS and CFLAGS where there is no pkg-config file; none of
# them for headers that only our own sources include.
macro(wayfare_foreign package)
  cmake_parse_arguments(_arg "" "DEBIAN;REQUIRES;LIBS;CFLAGS" "" ${ARGN})
  set(WAYFARE_${package}_DEBIAN "${_arg_DEBIAN}")
  set(WAYFARE_${package}_REQUIRES "${_arg_REQUIRES}")
  set(WAYFARE_${package}_LIBS "${_arg_LIBS}")
  set(WAYFARE_${package}_CFLAGS "${_arg_CFLAGS}")
endmacro()

wayfare_foreign(Eigen3 DEBIAN "libeigen3-dev (>= 3.4)" REQUIRES "eigen3 >= 3.4")
wayfare_foreign(Threads LIBS -pthread)
wayfare_foreign(ZLIB DEBIAN zlib1g-dev REQUIRES zlib)
wayfare_foreign(PNG DEBIAN libpng-dev REQUIRES libpng)
wayfare_foreign(LZ4 DEBIAN liblz4-dev REQUIRES liblz4)
wayfare_foreign(ZSTD DEBIAN libzstd-dev REQUIRES libzstd)
wayfare_foreign(BZip2 DEBIAN libbz2-dev LIBS -lbz2)
wayfare_foreign(nlohmann_json DEBIAN nlohmann-json3-dev)
wayfare_foreign(GTest DEBIAN libgtest-dev REQUIRES gtest)
wayfare_foreign(CHOLMOD DEBIAN libsuitesparse-dev LIBS -lcholmod CFLAGS -I@CHOLMOD_INCLUDE_DIR@)
wayfare_foreign(ROSCPP DEBIAN libroscpp-dev REQUIRES roscpp)
wayfare_foreign(CycloneDDS DEBIAN cyclonedds-dev REQUIRES "CycloneDDS >= 0.10")

# wayfare_debian_of(OUT PACKAGE...): the Debian packages, between spaces, without versions.
function(wayfare_debian_of out)
  set(all "")
  foreach(package IN LISTS ARGN)
    string(REGEX REPLACE " .*" "" name "${WAYFARE_${package}_DEBIAN}")
    list(APPEND all ${name})
  endforeach()
  list(JOIN all " " all)
  set(${out} "${all}" PARENT_SCOPE)
endfunction()
