# Finds SuiteSparse's sparse Cholesky, for which Debian ships no CMake package.
#
# Defines the imported target CHOLMOD::CHOLMOD and CHOLMOD_VERSION. The library's supernodal module
# is under the GPL: whoever distributes a program linked to it follows that licence.
include(FindPackageHandleStandardArgs)

find_path(CHOLMOD_INCLUDE_DIR cholmod.h PATH_SUFFIXES suitesparse)
find_library(CHOLMOD_LIBRARY cholmod)
mark_as_advanced(CHOLMOD_INCLUDE_DIR CHOLMOD_LIBRARY)

if(CHOLMOD_INCLUDE_DIR)
  # The version moved to cholmod_core.h and back between releases.
  foreach(_header IN ITEMS cholmod.h cholmod_core.h)
    if(NOT CHOLMOD_VERSION AND EXISTS "${CHOLMOD_INCLUDE_DIR}/${_header}")
      file(STRINGS "${CHOLMOD_INCLUDE_DIR}/${_header}" _lines
           REGEX "^#define CHOLMOD_(MAIN|SUB|SUBSUB)_VERSION +[0-9]+")
      string(REGEX REPLACE "[^0-9;]+" "" _numbers "${_lines}")
      string(REPLACE ";" "." CHOLMOD_VERSION "${_numbers}")
    endif()
  endforeach()
endif()

find_package_handle_standard_args(CHOLMOD REQUIRED_VARS CHOLMOD_LIBRARY CHOLMOD_INCLUDE_DIR
                                  VERSION_VAR CHOLMOD_VERSION)

if(CHOLMOD_FOUND AND NOT TARGET CHOLMOD::CHOLMOD)
  add_library(CHOLMOD::CHOLMOD UNKNOWN IMPORTED)
  set_target_properties(CHOLMOD::CHOLMOD PROPERTIES
    IMPORTED_LOCATION "${CHOLMOD_LIBRARY}" INTERFACE_INCLUDE_DIRECTORIES "${CHOLMOD_INCLUDE_DIR}")
  # A static archive does not carry its own dependencies.
  if(CHOLMOD_LIBRARY MATCHES "\\.a$")
    foreach(_name IN ITEMS camd ccolamd amd colamd suitesparseconfig lapack blas)
      find_library(CHOLMOD_${_name}_LIBRARY ${_name})
      mark_as_advanced(CHOLMOD_${_name}_LIBRARY)
      if(CHOLMOD_${_name}_LIBRARY)
        set_property(TARGET CHOLMOD::CHOLMOD APPEND PROPERTY
                     INTERFACE_LINK_LIBRARIES "${CHOLMOD_${_name}_LIBRARY}")
      endif()
    endforeach()
  endif()
endif()
