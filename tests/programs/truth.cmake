# True poses of a log or of --truth: every program that follows a log compares its result with them.
set(_world "${_out}/world.log")
set(_walk "${_out}/head_walk/walk.log;--unit;${_out}/head_walk/unit.csv")
set(_tables "Errors against the truth of .*Rigid alignment to the truth")
# A run compared with its own trajectory has no errors.
set(_none " +-?0[.]000 +-?0[.]000 +-?0[.]00 +0[.]000 +0[.]00 +0[.]000 +0[.]000 +0[.]00\n")

# truth_test(PROGRAM ROW LARGEST ARGUMENTS... [NEEDS ...]): the log's own truth gives errors of
# x and y after rigid alignment that match LARGEST, the result as the truth none.
function(truth_test program row largest)
  cmake_parse_arguments(ARG "" "" "ARGUMENTS;NEEDS" ${ARGN})
  set(_to "${_out}/truth_${program}")
  program_test(${program}_truth_of_the_log zero
    "Errors against the truth of [^\n]*[.](log|bag)\n.*${row}, same start +[0-9].*${row}, aligned +${largest} +${largest} .*Rigid alignment to the truth"
    COMMAND "$<TARGET_FILE:${program}>;${ARG_ARGUMENTS};--out;${_to};--force"
    FILES "${_to}/report.html" NEEDS ${ARG_NEEDS} GIVES truth_${program})
  program_test(${program}_truth_of_a_file zero
    "${row}, same start${_none}.*${row}, aligned${_none}"
    COMMAND "$<TARGET_FILE:${program}>;${ARG_ARGUMENTS};--truth;${_to}/trajectory.tum;--out;${_to}_again;--force"
    NEEDS ${ARG_NEEDS} truth_${program})
  # The same numbers as the true path in the report's picture.
  add_test(NAME programs.${program}_truth_is_drawn
           COMMAND "${CMAKE_COMMAND}" "-DCOMMAND=${CMAKE_COMMAND};-E;cat;${_to}/report.html" -DEXIT=zero
                   "-DOUTPUT=</svg>truth</span>" "-DFILES=" -P "${CMAKE_CURRENT_FUNCTION_LIST_DIR}/expect.cmake")
  set_tests_properties(programs.${program}_truth_is_drawn PROPERTIES
    FIXTURES_REQUIRED "truth_${program};${ARG_NEEDS}")
endfunction()

truth_test(graph_slam SLAM "0[.]0[0-9]+" ARGUMENTS ${_world} NEEDS world_log)
truth_test(submap_slam SLAM "0[.]0[0-9]+" ARGUMENTS ${_world} NEEDS world_log)
truth_test(hector_slam SLAM "0[.]0[0-9]+" ARGUMENTS ${_world} NEEDS world_log)
truth_test(radar_slam SLAM "0[.]0[0-9]+" ARGUMENTS ${_world} --sensors lidar --particles 5 NEEDS world_log)
truth_test(corridor_ins "with walls" "[0-1][.][0-9]+" ARGUMENTS ${_world} NEEDS world_log)
truth_test(pedestrian_slam SLAM "0[.][0-9]+" ARGUMENTS ${_walk} NEEDS head_walk)
truth_test(pedestrian walk "[0-1][.][0-9]+" ARGUMENTS ${_out}/head.bag --forward x NEEDS head_walk head_bag)

# Localised on the map of the run whose trajectory is the truth: it is in the map's frame.
program_test(localise_truth_of_a_file zero
  "Errors on the map.*converged poses, as it is +0[.]0[0-9]+ +0[.]0[0-9]+ .*converged poses, same start.*converged poses, aligned +0[.]0.*Rigid alignment"
  COMMAND "${_localise};${_world};${_out}/truth_graph_slam/map.yaml;--truth;${_out}/truth_graph_slam/trajectory.tum;--out;${_out}/localise_truth;--force"
  FILES "${_out}/localise_truth/report.html" NEEDS world_log truth_graph_slam)
program_test(localise_truth_of_the_log zero "Errors against the truth of [^\n]*world.log\n.*converged poses, aligned +0[.][0-9]"
  COMMAND "${_localise};${_world};${_out}/truth_graph_slam/map.yaml;--out;${_out}/localise_own;--force"
  NEEDS world_log truth_graph_slam)

# Truth that cannot be used: refused before the run, with its file and what is wrong.
set(_bad "${_out}/bad_truth")
file(MAKE_DIRECTORY "${_bad}")
# Lines at the times (seconds) that follow.
function(write_truth name)
  set(text "")
  foreach(time IN LISTS ARGN)
    string(APPEND text "${time} 1 2 0 0 0 0 1\n")
  endforeach()
  file(WRITE "${_bad}/${name}" "${text}")
endfunction()
write_truth(other_clock.tum 1600000000 1600000001 1600000002)
write_truth(later.tum 5000 5001 5002)
write_truth(one.tum 2)
write_truth(touching.tum -3 -2 -1 0.05)
write_truth(unsorted.tum 1 2 4 3 5)
write_truth(duplicated.tum 1 2 2 3)
file(WRITE "${_bad}/nan.tum" "1 1 2 0 0 0 0 1\n2 nan 2 0 0 0 0 1\n3 1 2 0 0 0 0 1\n")
file(WRITE "${_bad}/seven.tum" "1 1 2 0 0 0 0 1\n2 1 2 0 0 0 1\n")
file(WRITE "${_bad}/columns.csv" "t_s,x_m,y_m,heading_deg\n1,1,2,0\n2,1,2\n")
file(WRITE "${_bad}/no_y.csv" "t_s,x_m,heading_deg\n1,1,0\n2,1,0\n")
function(bad_truth name output)
  string(REPLACE "." "_" test ${name})
  program_test(graph_slam_truth_${test} nonzero "${name}[^\n]*${output}"
    COMMAND "${_slam};${_world};--truth;${_bad}/${name};--out;${_bad}/x" NEEDS world_log)
endfunction()
bad_truth(other_clock.tum "is on another time base: the true poses are from 1600000000[.]000 to ")
bad_truth(later.tum "does not overlap with the log: the true poses are from 5000[.]000 to 5002[.]000 s, the log from ")
bad_truth(one.tum "has fewer than two poses")
bad_truth(touching.tum "has fewer than two poses in common with the log")
bad_truth(unsorted.tum "pose 4, at 3[.]000 s, is earlier than the pose before it")
bad_truth(duplicated.tum "pose 3, at 2[.]000 s, has the time of the pose before it")
bad_truth(nan.tum ":2: not a finite number: 'nan'")
bad_truth(seven.tum ":2: fewer than 8 numbers")
bad_truth(columns.csv ":3: expected 4 fields, found 3")
bad_truth(no_y.csv "has no column for y")
# In the log, it is left out with the reason.
file(STRINGS "${_in}/damaged.log" _lines)
file(WRITE "${_bad}/log_of_another_clock.log" "")
foreach(_line IN LISTS _lines)
  file(APPEND "${_bad}/log_of_another_clock.log" "${_line}\n")
endforeach()
file(APPEND "${_bad}/log_of_another_clock.log"
     "TRUEPOS 0 0 0 0 0 0 1600000000 host 0\nTRUEPOS 1 0 0 1 0 0 1600000001 host 1\n")
program_test(graph_slam_log_with_bad_truth zero
  "the true poses in the log are not used: [^\n]*another time base"
  COMMAND "${_slam};${_bad}/log_of_another_clock.log;--out;${_out}/bad_truth_run;--force")

# Several methods on one log: the same results as of the systems' own programs, for any number of
# threads, and a reason for each that is left out.
set(_compare "$<TARGET_FILE:compare_methods>")
program_test(compare_methods zero
  "graph SLAM, same start.*graph SLAM, aligned +0[.]0[0-9]+ +0[.]0.*Rigid alignment.*Left out.*pdr +the log has no inertial unit.*pedestrian +the log has no inertial unit"
  COMMAND "${_compare};${_world};--out;${_out}/compared;--force"
  FILES "${_out}/compared/odometry.tum;${_out}/compared/hector.tum;${_out}/compared/submap.tum;${_out}/compared/graph.tum;${_out}/compared/lidar.tum;${_out}/compared/radar.tum;${_out}/compared/radar_lidar.tum;${_out}/compared/paths.svg;${_out}/compared/report.html"
  NEEDS world_log GIVES compared)
program_test(compare_methods_threads zero "graph SLAM, same start.*submap SLAM, same start|submap SLAM, same start.*graph SLAM, same start"
  COMMAND "${_compare};${_world};--methods;graph,submap,radar;--threads;2;--out;${_out}/compared_again;--force"
  NEEDS world_log GIVES compared_again)
foreach(_pair IN ITEMS compared_again/graph:compared/graph compared_again/submap:compared/submap
                       compared_again/radar:compared/radar truth_graph_slam/trajectory:compared/graph
                       truth_hector_slam/trajectory:compared/hector
                       truth_submap_slam/trajectory:compared/submap)
  string(REPLACE ":" ";" _files_of_pair "${_pair}")
  list(TRANSFORM _files_of_pair REPLACE "(.+)" "${_out}/\\1.tum")
  string(REGEX REPLACE "[/:]" "_" _name "${_pair}")
  add_test(NAME programs.compare_methods_same_${_name}
           COMMAND "${CMAKE_COMMAND}" -E compare_files ${_files_of_pair})
  set_tests_properties(programs.compare_methods_same_${_name} PROPERTIES FIXTURES_REQUIRED
    "world_log;compared;compared_again;truth_graph_slam;truth_hector_slam;truth_submap_slam")
endforeach()
# The corridor filter, as in its own program: against the log's truth, that of a file and none.
program_test(compare_methods_corridor zero "corridor filter, same start.*corridor filter, aligned +0[.]0[0-9]+ +0[.]0"
  COMMAND "${_compare};${_world};--methods;corridor;--out;${_out}/compared_corridor;--force"
  NEEDS world_log GIVES compared_corridor)
add_test(NAME programs.compare_methods_same_corridor
         COMMAND "${CMAKE_COMMAND}" -E compare_files
                 "${_out}/compared_corridor/corridor.tum" "${_out}/truth_corridor_ins/trajectory.tum")
set_tests_properties(programs.compare_methods_same_corridor PROPERTIES FIXTURES_REQUIRED
  "world_log;compared_corridor;truth_corridor_ins")
program_test(compare_methods_corridor_truth_of_a_file zero "corridor filter, same start${_none}"
  COMMAND "${_compare};${_world};--methods;corridor;--truth;${_out}/compared_corridor/corridor.tum;--out;${_out}/compared_again_corridor;--force"
  NEEDS world_log compared_corridor)
foreach(_bad_truth IN ITEMS other_clock:another later:overlap)
  string(REPLACE ":" ";" _bad_truth "${_bad_truth}")
  list(GET _bad_truth 0 _file)
  list(GET _bad_truth 1 _word)
  foreach(_program IN ITEMS compare_methods corridor_ins)
    program_test(${_program}_truth_${_file} nonzero "${_file}.tum[^\n]*${_word}"
      COMMAND "$<TARGET_FILE:${_program}>;${_world};--truth;${_bad}/${_file}.tum;--out;${_bad}/x"
      NEEDS world_log)
  endforeach()
endforeach()
program_test(compare_methods_of_a_walk zero
  "dead reckoning by steps, same start.*Hector SLAM, same start.*pedestrian SLAM, aligned.*Left out.*odometry +the log has no odometry.*radar +the log has no radar"
  COMMAND "${_compare};${_walk};--methods;odometry,pdr,hector,pedestrian,radar;--out;${_out}/compared_walk;--force"
  FILES "${_out}/compared_walk/pdr.tum;${_out}/compared_walk/pedestrian.tum" NEEDS head_walk)
program_test(compare_methods_without_truth zero "Paths.*Hector SLAM +[0-9]+"
  COMMAND "${_compare};${_out}/room.log;--methods;odometry,hector;--out;${_out}/compared_room;--force"
  FILES "${_out}/compared_room/paths.svg" NEEDS room_log)
program_test(compare_methods_keeps_what_is_there nonzero "already exists"
  COMMAND "${_compare};${_world};--methods;odometry;--out;${_out}/compared" NEEDS world_log compared)
program_test(compare_methods_none_left nonzero "no method can follow it; radar: the log has no radar frames"
  COMMAND "${_compare};${_out}/room.log;--methods;radar;--out;${_bad}/x" NEEDS room_log)
program_test(compare_methods_unknown nonzero "--methods"
  COMMAND "${_compare};${_world};--methods;odometry,guessing;--out;${_bad}/x" NEEDS world_log)
