# --json: the numbers of the report in a file or on standard output, and the same as printed.
program_test(json_of_graph_slam zero ""
  COMMAND "${_slam};${_out}/room.log;--json;${_out}/room.json;--out;${_out}/room_json;--force"
  FILES "${_out}/room.json;${_out}/room_json/report.html" NEEDS room_log GIVES room_json)
program_test(json_keeps_what_is_there 1 "room.json: already exists"
  COMMAND "${_slam};${_out}/room.log;--json;${_out}/room.json;--out;${_out}/room_json_again"
  NEEDS room_log room_json)
program_test(json_without_a_folder zero ""
  COMMAND "$<TARGET_FILE:allan>;${_out}/head.bag;--json;${_out}/allan.json;--quiet;--force"
  FILES "${_out}/allan.json" NEEDS head_bag)
program_test(json_of_pose_graph zero ""
  COMMAND "${_graph};${_out}/room/graph.g2o;--json;${_out}/graph.json;--out;${_out}/graph_json.g2o;--force"
  FILES "${_out}/graph.json" NEEDS room_log room_run GIVES graph_json)
add_test(NAME programs.json_of_reports
         COMMAND "${CMAKE_COMMAND}" "-DSLAM=${_slam}" "-DOUT=${_out}"
                 -P "${CMAKE_CURRENT_SOURCE_DIR}/check_json.cmake")
set_tests_properties(programs.json_of_reports PROPERTIES
  FIXTURES_REQUIRED "room_log;room_run;room_json;graph_json")
