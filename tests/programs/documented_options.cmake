# cmake -DROOT=. -DPROGRAMS="build/bin/graph_slam;..." -P documented_options.cmake
# Options that the documents name exist: those of a command line in the program's --help, those that
# stand alone in that of any program, in a script of the tree or in the source of a benchmark, which
# may not be built.
cmake_minimum_required(VERSION 3.22)
get_filename_component(ROOT "${ROOT}" ABSOLUTE)
foreach(program IN LISTS PROGRAMS)
  execute_process(COMMAND "${program}" --help OUTPUT_VARIABLE help RESULT_VARIABLE code)
  if(NOT code EQUAL 0)
    message(FATAL_ERROR "${program} --help: ${code}")
  endif()
  get_filename_component(program "${program}" NAME)
  list(APPEND names ${program})
  set(help_of_${program} "${help}")
  string(APPEND anywhere "${help}")
endforeach()
file(GLOB scripts "${ROOT}/tests/*.py" "${ROOT}/tests/golden/check" "${ROOT}/tests/golden/*.py"
     "${ROOT}/benchmarks/speed/compare" "${ROOT}/benchmarks/speed/*/*.[ch]pp")
foreach(script IN LISTS scripts)
  file(READ "${script}" text)
  string(APPEND anywhere "${text}")
endforeach()

set(checked 0)
# Each option in `words` must be in `help`.
function(check_options words help where)
  string(REGEX MATCHALL "[ `]--[a-z][a-z0-9_-]*" options "${words}")
  foreach(option IN LISTS options)
    string(SUBSTRING "${option}" 1 -1 option)
    if(NOT help MATCHES "${option}[^a-z0-9_-]")
      message(SEND_ERROR "no option ${option}: ${where}")
    endif()
    math(EXPR checked "${checked} + 1")
  endforeach()
  set(checked ${checked} PARENT_SCOPE)
endfunction()

file(GLOB documents "${ROOT}/*.md" "${ROOT}/docs/*.md" "${ROOT}/docs/*/*.md"
     "${ROOT}/benchmarks/reports/*.md")
if(NOT slam_node IN_LIST names)  # the nodes are built where ROS's transports are
  list(REMOVE_ITEM documents "${ROOT}/docs/how-to/ros.md" "${ROOT}/docs/how-to/ros2.md")
endif()
foreach(document IN LISTS documents)
  file(READ "${document}" text)
  string(REGEX REPLACE "[][]" " " text "${text}")
  string(REGEX REPLACE "\\\\\n *" " " text "${text}")     # a command that is continued
  string(REGEX REPLACE "(;|&&|[|])" "\n" text "${text}")  # several commands on a line
  # A script that runs the programs has options of its own.
  string(REGEX REPLACE "benchmarks/[a-z_/]+ build/bin[^`\n]*" "" text "${text}")
  foreach(program IN LISTS names)
    string(REGEX MATCHALL "([`\n] *|bin/)${program} [^`\n]*" commands "${text}")
    foreach(command IN LISTS commands)
      check_options("${command}" "${help_of_${program}}" "${program} in ${document}")
    endforeach()
  endforeach()
  string(REGEX MATCHALL "`--[a-z][^`\n]*" alone "${text}")
  list(FILTER alone EXCLUDE REGEX "^`--benchmark_")       # of Google's benchmark library
  foreach(words IN LISTS alone)
    check_options("${words}" "${anywhere}" "${document}")
  endforeach()
endforeach()
if(checked LESS 100)
  message(FATAL_ERROR "only ${checked} options were found: are the documents written another way?")
endif()
