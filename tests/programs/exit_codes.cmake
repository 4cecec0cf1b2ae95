# Exit codes of all programs: 1 for a file that is not there and for one that is junk, 2 for wrong
# arguments (uniform.cmake), 3 for a result in doubt.
set(_x "${_out}/exit_code")
set(_nowhere "${_out}/nowhere")

# bad_file(PROGRAM ARGUMENT...): FILE stands for the file.
function(bad_file program)
  set_property(GLOBAL APPEND PROPERTY WAYFARE_PROGRAMS_WITH_FILES ${program})
  if(NOT TARGET ${program})
    return()
  endif()
  set(missing "${ARGN}")
  list(TRANSFORM missing REPLACE "^FILE$" "${_nowhere}")
  program_test(${program}_without_its_file 1 "nowhere" COMMAND "$<TARGET_FILE:${program}>;${missing}")
  set(junk "${ARGN}")
  list(TRANSFORM junk REPLACE "^FILE$" "${_in}/junk.mcap")
  program_test(${program}_with_a_junk_file 1 "junk.mcap" COMMAND "$<TARGET_FILE:${program}>;${junk}")
endfunction()

foreach(_program IN ITEMS ahrs calibrate_robot compare_methods corridor_ins graph_slam hector_slam match_comparison
                          pedestrian pose_graph radar_slam radar_velocity submap_slam)
  bad_file(${_program} FILE --out "${_x}_${_program}")
endforeach()
foreach(_program IN ITEMS allan attitude_table calibrate_magnetometer false_loops pose_graph_starts submap_loops)
  bad_file(${_program} FILE)
endforeach()
bad_file(compare_tracks FILE FILE)
bad_file(convert_log FILE --out "${_x}.bag")
bad_file(cut_drive --imu FILE --truth FILE --from 0 --to 1 --out "${_x}_cut")
bad_file(decode ti FILE --csv)
bad_file(gnss_ins --imu FILE --ranges FILE --out "${_x}_ins")
bad_file(localise FILE FILE --out "${_x}_localise")
bad_file(logger --config FILE)
bad_file(monitor FILE --port 0)
bad_file(outage_test --imu FILE --ranges FILE --truth FILE --out "${_x}_outages")
bad_file(pedestrian_slam FILE --unit FILE --out "${_x}_pedestrian_slam")
bad_file(phase_velocity --obs FILE --truth FILE)
bad_file(range_slam_study FILE FILE FILE)
bad_file(draw_scans FILE FILE --out "${_x}_draw_scans")
bad_file(replay FILE --ptys "${_x}_lines")
bad_file(simulate "${_nowhere}.plan" --out "${_x}.log" --voxels FILE --way FILE)
bad_file(simulate_drive --config FILE --out "${_x}_drive")
bad_file(slam_matchers FILE FILE)
bad_file(spp --obs FILE --nav FILE)
bad_file(rtklib_points --obs FILE --nav FILE --out "${_x}_rtklib")
foreach(_program IN ITEMS tune tune_against_pagmo)  # a folder
  set_property(GLOBAL APPEND PROPERTY WAYFARE_PROGRAMS_WITH_FILES ${_program})
endforeach()
program_test(tune_without_its_folder 1 "nowhere: does not exist"
  COMMAND "${_tune};--training;${_nowhere};--out;${_x}_tune")
program_test(radar_statistics_without_captures 1 "nowhere"
  COMMAND "$<TARGET_FILE:radar_statistics>;--captures;${_nowhere}")
# They fail before they look for a master.
foreach(_case IN ITEMS "play_recording" "slam_node;--config" "localise_node;--map-file" "hector_node;--config" "pedestrian_slam_node;--config" "pedestrian_node;--calibration" "radar_driver_node;--port;x;--config")
  list(POP_FRONT _case _program)
  if(TARGET ${_program})
    program_test(${_program}_without_its_file 1 "nowhere: does not exist"
      COMMAND "$<TARGET_FILE:${_program}>;${_case};${_nowhere}")
  endif()
endforeach()

# No program is forgotten.
set(_without_files calibration_study corridor_study covariance_study demo endless_runs feet_study hallway_comparison ins_consistency lidar_driver_node
    hector_node localisation_table pedestrian_node pedestrian_slam_node pedestrian_slam_study play_recording
    localise_node radar_driver_node radar_odometry_study radar_slam_study radar_statistics record_topics ros2_latency
    slam_node sweep_study xsens_driver_node)
get_property(_all GLOBAL PROPERTY WAYFARE_PROGRAMS)
get_property(_with_files GLOBAL PROPERTY WAYFARE_PROGRAMS_WITH_FILES)
foreach(_program IN LISTS _all)
  if(NOT _program MATCHES "^(tour|readme|bench)_" AND NOT _program IN_LIST _with_files
     AND NOT _program IN_LIST _without_files)
    message(SEND_ERROR "tests/programs/exit_codes.cmake: which file does ${_program} read?")
  endif()
endforeach()

# Values that only the program can check are wrong arguments too.
program_test(bad_use_of_localise 2 "--initial must be three numbers"
  COMMAND "${_localise};${_out}/room.log;${_out}/room/map.yaml;--initial;nan,0,0;--out;${_x}"
  NEEDS room_log room_run)
program_test(bad_use_of_simulate 2 "--out LOG is needed" COMMAND "$<TARGET_FILE:simulate>")
program_test(bad_use_of_monitor 2 "needs a recording" COMMAND "$<TARGET_FILE:monitor>")

program_test(bad_use_of_a_range 2 "--sigma: must be positive, is -1\n.*--help lists the arguments"
  COMMAND "${_localise};${_in}/empty.txt;${_in}/empty.txt;--sigma;-1;--out;${_x}")
program_test(bad_use_of_a_seed 2 "--seed: must not be negative, is -1\n"
  COMMAND "$<TARGET_FILE:simulate>;--seed;-1;--out;${_x}.log")
program_test(bad_use_of_satellites 2 "--satellites: must be from 1 to 64, is 999\n"
  COMMAND "$<TARGET_FILE:simulate_drive>;--satellites;999;--out;${_x}")
program_test(bad_use_of_outages 2 "begins at 1000.0 s, outside the recording, which takes 310.[0-9] s"
  COMMAND "${_ins};--imu;${_imu};--ranges;${_files}/ranges.txt;--outage;1000:30;--out;${_x}"
  NEEDS drive_files)
program_test(bad_use_of_outages_in_a_simulation 2 "outside the recording, which takes 31"
  COMMAND "$<TARGET_FILE:simulate_drive>;--outage;1000:30;--out;${_x}")
program_test(bad_use_of_convert_log 2 "neither in .mcap nor in .bag: out.txt"
  COMMAND "$<TARGET_FILE:convert_log>;${_in}/empty.txt;--out;out.txt")
program_test(bad_use_of_a_world 2 "corridor_lop: is neither a file nor a world: corridor_loop, .*did you mean corridor_loop[?]"
  COMMAND "$<TARGET_FILE:simulate>;corridor_lop;--out;${_x}.log")
program_test(bad_use_of_a_table_of_worlds 2 "rom: is neither a file nor a world: building, .*did you mean room[?]"
  COMMAND "$<TARGET_FILE:localisation_table>;--world;rom;--quiet")
program_test(bad_use_of_a_study_in_a_world 2 "WORLD: rom not in {.*room"
  COMMAND "$<TARGET_FILE:radar_slam_study>;rom")

# Configurations that are no JSON, with the line.
file(WRITE "${_out}/comma.json" "{\"node_distance_m\": 0.4,\n \"max_range_m\": 30,,\n}\n")
set(_comma "comma.json:2, byte [0-9]+: not JSON: .*unexpected ','")
foreach(_case IN ITEMS "graph_slam;${_in}/empty.txt;--config" "radar_slam;${_in}/empty.txt;--config"
                       "gnss_ins;--imu;${_in}/empty.txt;--config" "logger;--config"
                       "ahrs;${_in}/turned_about.csv;--calibration" "pedestrian;${_in}/walk.csv;--calibration")
  list(POP_FRONT _case _program)
  set(_to --out "${_x}")
  if(_program STREQUAL "logger")
    set(_to)
  endif()
  program_test(${_program}_with_a_comma_too_many 1 "${_comma}"
    COMMAND "$<TARGET_FILE:${_program}>;${_case};${_out}/comma.json;${_to}")
endforeach()

# Files of another kind say what was expected.
program_test(map_and_log_exchanged 1 "no_beams.log:[0-9]+: not 'key: value'; expected the .yaml file of a map"
  COMMAND "${_localise};${_in}/empty.txt;${_in}/no_beams.log;--out;${_x}_exchanged;--force")
program_test(picture_of_a_map 1 "map.pgm: is a picture; expected the .yaml file of a map"
  COMMAND "${_localise};${_out}/room.log;${_out}/room/map.pgm;--out;${_x}_picture;--force" NEEDS room_log room_run)
program_test(empty_log 1 "empty.txt: is empty"
  COMMAND "$<TARGET_FILE:radar_velocity>;${_in}/empty.txt;--out;${_x}")
program_test(no_log 1 "no line of a robot's log"
  COMMAND "$<TARGET_FILE:calibrate_robot>;${_in}/walk.csv;--out;${_x}_no_log;--force")
program_test(cut_off_graph zero "" COMMAND "sh;-c;gzip -c '${_out}/room/graph.g2o' | head -c 1000 >'${_out}/cut.g2o.gz'"
  NEEDS room_run GIVES cut_off_graph)
program_test(pose_graph_of_a_cut_off_graph 1 "cut.g2o.gz, byte 1000: the compressed data is cut off\n"
  COMMAND "${_graph};${_out}/cut.g2o.gz;--out;${_out}/cut.g2o;--force" NEEDS cut_off_graph)

# Where nothing can be written, that is said before anything is read.
program_test(graph_slam_into_no_folder 1 "empty.txt/x: cannot be created"
  COMMAND "${_slam};${_in}/junk.mcap;--out;${_in}/empty.txt/x")
program_test(pose_graph_into_no_folder 1 "nowhere/a.g2o: cannot be written: No such file"
  COMMAND "${_graph};${_in}/junk.mcap;--out;${_nowhere}/a.g2o")

# In doubt: an optimisation of one iteration, a search that did not end.
file(WRITE "${_out}/zigzag.g2o" "VERTEX_SE2 0 0 0 0\n")
foreach(_i RANGE 1 12)
  math(EXPR _from "${_i} - 1")
  file(APPEND "${_out}/zigzag.g2o"
       "VERTEX_SE2 ${_i} ${_i} 3 2\nEDGE_SE2 ${_from} ${_i} 1 0 0.6 1 0 0 1 0 100\n")
endforeach()
file(APPEND "${_out}/zigzag.g2o" "EDGE_SE2 12 0 1 2 0.5 1 0 0 1 0 100\n")
program_test(doubt_of_pose_graph 3 "in doubt: the optimisation ended after --max-iterations"
  COMMAND "${_graph};${_out}/zigzag.g2o;--max-iterations;1;--out;${_out}/zigzag_1.g2o;--force"
  FILES "${_out}/zigzag_1.g2o")
program_test(no_doubt_of_pose_graph 0 "iterations"
  COMMAND "${_graph};${_out}/zigzag.g2o;--out;${_out}/zigzag_100.g2o;--force")

# A log whose stamps are all zero is numbered, with relations by the scans' numbers; one of which
# most lines are cut off is in doubt.
string(REPEAT " 2.5" 180 _ranges)
set(_line "FLASER 180${_ranges} 0 0 0 0 0 0 0 host 0\n")
string(REPEAT "${_line}FLASER 180 1 1\n" 8 _half)
file(WRITE "${_out}/no_stamps.log" "${_half}")
file(WRITE "${_out}/by_scan.relations" "0 1 0 0 0 0 0 0\n")
program_test(log_without_stamps 0 "1 of 1.*warning.*time stamps cannot be used: all are.*8 of 16 lines.*the line ends"
  COMMAND "${_slam};${_out}/no_stamps.log;--relations;${_out}/by_scan.relations;--relations-by-scan;--out;${_out}/no_stamps;--force")
file(WRITE "${_out}/wrong_scan.relations" "0 8 0 0 0 0 0 0\n")
program_test(relations_beyond_the_scans 1 "not the number of one of the 8 scans"
  COMMAND "${_slam};${_out}/no_stamps.log;--relations;${_out}/wrong_scan.relations;--relations-by-scan;--out;${_x}")
file(WRITE "${_out}/cut_off.log" "${_half}FLASER 180 1 1\n")
program_test(doubt_of_graph_slam 3 "in doubt: 9 of 17 lines of the log were skipped, most: the line ends after"
  COMMAND "${_slam};${_out}/cut_off.log;--out;${_out}/cut_off;--force")
