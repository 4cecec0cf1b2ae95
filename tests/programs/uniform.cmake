# cmake -DPROGRAMS="build/bin/graph_slam;..." -P uniform.cmake
# All programs speak alike: parts of --help, words for one option, exit codes of wrong arguments and
# files, examples that name options the program has, man pages and completions.
cmake_minimum_required(VERSION 3.22)

# Names that mean something else from program to program.
set(different --base-frame --baud --beams --calibration --config --each --farthest --first --first-seed
    --forward --frames --gyro-bias --heading --imu --imu-rate --kernel --max-range --min-range --nav
    --no-magnetometer --no-odometry --obs --only --out --outage --particles --period --port
    --pressure-drift --pressure-noise --print-config --rate --runs --satellites --seconds --seeds
    --sensors --simulated --speed --start --system --truth --way --wheels --world --write)

function(fail text)
  message(SEND_ERROR "${text}")
endfunction()

# Runs a program; sets code, text (both streams).
function(run)
  execute_process(COMMAND ${ARGN} OUTPUT_VARIABLE out ERROR_VARIABLE errors RESULT_VARIABLE result
                  INPUT_FILE /dev/null TIMEOUT 60)
  set(code "${result}" PARENT_SCOPE)
  set(text "${out}${errors}" PARENT_SCOPE)
endfunction()

set(shared 0)
foreach(program IN LISTS PROGRAMS)
  get_filename_component(name "${program}" NAME)
  run("${program}" --help)
  set(help "${text}")
  foreach(part IN ITEMS "Usage: ${name} " "Options:\n  -h, --help " "\nExamples:\n  ${name}"
                        "\nExit codes:\n  0  done\n  1  [^\n]+\n  2  [^\n]+\n  3  [^\n]+\n$")
    if(NOT help MATCHES "${part}")
      fail("${name} --help has no '${part}'")
    endif()
  endforeach()
  run("${program}" --no-such-option)
  if(NOT code EQUAL 2 OR NOT text MATCHES "${name}: unknown option --no-such-option")
    fail("${name} --no-such-option: ${code}, ${text}")
  endif()
  run("${program}" --hlep)
  if(NOT code EQUAL 2 OR NOT text MATCHES "did you mean --help[?]")
    fail("${name} --hlep: ${code}, ${text}")
  endif()
  run("${program}" --man-page)
  if(NOT code EQUAL 0 OR NOT text MATCHES "\n.SH NAME\n${name} [^\n]+ [^\n]+\n.SH SYNOPSIS\n")
    fail("${name} --man-page: ${code}, ${text}")
  endif()
  run("${program}" --bash-completion)
  if(NOT code EQUAL 0 OR NOT text MATCHES "complete [^\n]+ ${name}\n$")
    fail("${name} --bash-completion: ${code}, ${text}")
  endif()

  # The options with their texts, on one line each.
  string(REGEX REPLACE "^.*\nOptions:\n" "" options "${help}")
  string(REGEX REPLACE "\n\n.*$" "\n" options "${options}")
  string(REGEX REPLACE "\n   +" "  " options "${options}")
  string(REGEX REPLACE "[][;]" "," options "${options}")
  string(REGEX MATCHALL "  -[^\n]+" lines "${options}")
  foreach(line IN LISTS lines)
    string(REGEX MATCH "^  (-h, )?(--[a-z0-9-]+)" option "${line}")
    set(option "${CMAKE_MATCH_2}")
    # "--name VALUE  text": the text, up to its first , : ( or ;, is what programs share.
    string(REGEX REPLACE "^  (-h, )?--[^ ]+( [A-Z][A-Z.,]*| [^ ]+[|][^ ]+)* +" "" said "${line}")
    string(REGEX REPLACE "[,:(].*$" "" said "${said}")
    string(REGEX REPLACE "  +" " " said "${said}")
    string(STRIP "${said}" said)
    if(option IN_LIST different)
      continue()
    endif()
    if(DEFINED said_of_${option} AND NOT said STREQUAL said_of_${option})
      fail("${option}: '${said}' in ${name}, '${said_of_${option}}' in ${name_of_${option}}")
    elseif(DEFINED said_of_${option})
      math(EXPR shared "${shared} + 1")
    endif()
    set(said_of_${option} "${said}")
    set(name_of_${option} ${name})
  endforeach()

  # Examples use options that exist.
  string(REGEX REPLACE "^.*\nExamples:\n" "" examples "${help}")
  string(REGEX MATCHALL "\n?  ${name} [^\n]*" calls "${examples}")
  foreach(call IN LISTS calls)
    string(REGEX MATCHALL " --[a-z0-9-]+" used "${call}")
    foreach(option IN LISTS used)
      if(NOT options MATCHES "(^|[ ,])${option}[ ,\n]")
        fail("${name}: an example uses${option}, which it does not have")
      endif()
    endforeach()
  endforeach()
endforeach()
if(shared LESS 200)
  message(FATAL_ERROR "only ${shared} texts were compared: does --help look different now?")
endif()
