# Installs the component core alone, which needs no compilation, and asks for what is not in it.
file(REMOVE_RECURSE "${WORK}")
execute_process(COMMAND "${CMAKE_COMMAND}" -S "${ROOT}" -B "${WORK}/build" "-DCMAKE_CXX_COMPILER=${CXX}"
                        -DWAYFARE_COMPONENTS=core -DWAYFARE_BUILD_TESTS=OFF
                        -DWAYFARE_BUILD_EXAMPLES=OFF -DWAYFARE_BUILD_BENCHMARKS=OFF
                OUTPUT_QUIET COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND "${CMAKE_COMMAND}" --install "${WORK}/build" --prefix "${WORK}/prefix"
                OUTPUT_QUIET COMMAND_ERROR_IS_FATAL ANY)

function(ask component expected)
  execute_process(COMMAND "${CMAKE_COMMAND}" -S "${CMAKE_CURRENT_LIST_DIR}/refusal"
                          -B "${WORK}/ask_${component}" "-DCMAKE_CXX_COMPILER=${CXX}"
                          "-DCMAKE_PREFIX_PATH=${WORK}/prefix" "-DCOMPONENTS=${component}"
                  OUTPUT_VARIABLE text ERROR_VARIABLE errors)
  string(APPEND text "${errors}")
  string(REGEX REPLACE "[ \n]+" " " text "${text}")
  if(NOT text MATCHES "${expected}")
    message(FATAL_ERROR "COMPONENTS ${component}: expected '${expected}':\n${text}")
  endif()
endfunction()
ask(core "found: 1 core: TRUE")
ask(slam "component 'slam' is not in this installation: when that was built, WAYFARE_COMPONENTS did not name it. Build wayfare again with it")
ask(teapot "component 'teapot' is not in this installation, which has: core")
