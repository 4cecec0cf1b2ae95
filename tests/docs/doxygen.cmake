# Runs Doxygen by docs/reference/Doxyfile as `./run docs` does, writing to OUT. It may warn of nothing, members
# without a comment included.
find_program(doxygen doxygen)
if(NOT doxygen)
  message("doxygen is not installed")
  return()
endif()

file(MAKE_DIRECTORY "${OUT}")
file(READ "${ROOT}/docs/reference/Doxyfile" _settings)
file(WRITE "${OUT}/Doxyfile" "${_settings}OUTPUT_DIRECTORY = \"${OUT}\"\nGENERATE_XML = YES\n")
execute_process(COMMAND "${doxygen}" "${OUT}/Doxyfile" WORKING_DIRECTORY "${ROOT}"
                RESULT_VARIABLE _result ERROR_VARIABLE _warnings)
if(NOT _result EQUAL 0)
  message("${_warnings}")
  message(FATAL_ERROR "Doxygen warns, see above")
endif()

# Of enumerators it does not warn: they are looked for in what it wrote.
file(GLOB _pages "${OUT}/xml/*.xml")
set(_empty "\n *<briefdescription>\n *</briefdescription>\n *<detaileddescription>\n *</detaileddescription>")
foreach(_page IN LISTS _pages)
  file(READ "${_page}" _text)
  if(_text MATCHES "<enumvalue [^\n]*prot=\"public\"[^\n]*\n *<name>([^<]*)</name>(\n *<initializer>[^\n]*)?${_empty}")
    message(SEND_ERROR "The enumerator ${CMAKE_MATCH_1} has no comment: ${_page}")
  endif()
endforeach()

# Of a namespace's members it does not warn, nor show them, where the namespace has no comment itself.
file(READ "${ROOT}/docs/reference/namespaces.hpp" _commented)
file(GLOB _headers "${ROOT}/include/wayfare/*/*.hpp")
foreach(_header IN LISTS _headers)
  file(STRINGS "${_header}" _opened REGEX "^(inline )?namespace ")
  foreach(_line IN LISTS _opened)
    string(REGEX REPLACE "^(inline )?namespace (wayfare::)?([a-z_0-9]+) .*" "\\3" _name "${_line}")
    if(NOT _name MATCHES "^(detail|landmark_detail|internal|cholesky|Eigen)$|^namespace|/" AND
       NOT _commented MATCHES "namespace ${_name} {")
      message(SEND_ERROR "${_header}: docs/reference/namespaces.hpp has no comment on ${_name}")
    endif()
  endforeach()
endforeach()
