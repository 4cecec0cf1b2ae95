# Compiles SOURCE with COMPILER, as it stands if CONTROL (must succeed), and with WAYFARE_MUST_FAIL (must
# fail with each of the messages of its "// EXPECT: regex" lines).
set(command "${COMPILER}" -std=c++20 -fsyntax-only ${OPTIONS})
set(ENV{LC_ALL} C)

if(CONTROL)
  execute_process(COMMAND ${command} "${SOURCE}" RESULT_VARIABLE status ERROR_VARIABLE output)
  if(NOT status EQUAL 0)
    message(FATAL_ERROR "the positive control does not compile:\n${output}")
  endif()
endif()

execute_process(COMMAND ${command} -DWAYFARE_MUST_FAIL "${SOURCE}"
                RESULT_VARIABLE status ERROR_VARIABLE output)
if(status EQUAL 0)
  message(FATAL_ERROR "compiles, and must not")
endif()
file(STRINGS "${SOURCE}" expectations REGEX "^// EXPECT: ")
if(NOT expectations)
  message(FATAL_ERROR "${SOURCE} names no message to expect")
endif()
foreach(expectation IN LISTS expectations)
  string(REPLACE "// EXPECT: " "" regex "${expectation}")
  if(NOT output MATCHES "${regex}")
    message(FATAL_ERROR "fails, but not with '${regex}':\n${output}")
  endif()
endforeach()
