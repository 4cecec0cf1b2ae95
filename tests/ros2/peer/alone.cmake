# Two processes of the peer at a time: a writer and its reader.
cmake_minimum_required(VERSION 3.22)
string(RANDOM LENGTH 2 ALPHABET 123456789 domain)  # ports below 32768
string(RANDOM LENGTH 8 name)
set(file "${FOLDER}/${name}.records")

# both(WHAT EXPECTED WRITER... READ READER...): both succeed, and the reader says what is expected.
function(both what expected)
  list(FIND ARGN READ at)
  list(SUBLIST ARGN 0 ${at} writer)
  math(EXPR at "${at} + 1")
  list(SUBLIST ARGN ${at} -1 reader)
  execute_process(
    COMMAND "${PEER}" ${writer} --domain ${domain}
    COMMAND sh -c "sleep ${delay_s} && exec \"$@\"" sh "${PEER}" ${reader} --domain ${domain}
    RESULTS_VARIABLE results OUTPUT_VARIABLE text ERROR_VARIABLE errors)
  if(NOT results STREQUAL "0;0" OR NOT text MATCHES "${expected}")
    file(REMOVE "${file}")
    message(FATAL_ERROR "${what}: ${results} ${text} ${errors}")
  endif()
endfunction()

set(delay_s 0)
set(scan rt/scan sensor_msgs/msg/LaserScan)
both("samples by their formula" "received 10 of 10, lost 0, last 9"
     publish ${scan} --wait-for 1 --size 1080 READ subscribe ${scan} 10 --size 1080)
both("samples recorded" "received 10 of 10"
     publish ${scan} --wait-for 1 --size 1080 READ record ${scan} 10 "${file}")
both("samples played" "received 10 of 10, lost 0, last 9"
     play "${file}" --wait-for 1 READ subscribe ${scan} 10 --size 1080)
both("bytes played" "received 10 of 10, lost 0, last 9"
     play "${file}" --wait-for 1 --raw READ subscribe ${scan} 10 --size 1080)
file(REMOVE "${file}")

# The map is sent before its reader exists.
set(delay_s 1)
set(map rt/map nav_msgs/msg/OccupancyGrid)
set(kept --size 100000 --transient-local --depth 1)
both("a late reader of a map" "received 1 of 1, lost 0, last 0"
     publish ${map} --count 1 --late-readers 1 ${kept} READ subscribe ${map} 1 ${kept})
