# Runs Doxygen by docs/reference/Doxyfile, writing to OUT: CHECK=reference as `./run docs` does,
# CHECK=undocumented on these families alone, where each member needs a comment.
set(_complete core filter)

find_program(doxygen doxygen)
if(NOT doxygen)
  message("doxygen is not installed")
  return()
endif()

file(READ "${ROOT}/docs/reference/Doxyfile" _settings)
string(APPEND _settings "OUTPUT_DIRECTORY = \"${OUT}\"\n")
if(CHECK STREQUAL "undocumented")
  list(TRANSFORM _complete PREPEND include/wayfare/)
  list(JOIN _complete " " _folders)
  string(APPEND _settings "INPUT = ${_folders}\nUSE_MDFILE_AS_MAINPAGE =\nEXTRACT_ALL = NO\n"
                          "GENERATE_HTML = NO\nGENERATE_XML = YES\n")
endif()
file(MAKE_DIRECTORY "${OUT}")
file(WRITE "${OUT}/Doxyfile" "${_settings}")
execute_process(COMMAND "${doxygen}" "${OUT}/Doxyfile" WORKING_DIRECTORY "${ROOT}"
                RESULT_VARIABLE _result ERROR_VARIABLE _warnings)
if(NOT _result EQUAL 0)
  message("${_warnings}")
  message(FATAL_ERROR "Doxygen warns, see above")
endif()
