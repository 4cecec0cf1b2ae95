# Scans drawn along a path, scores, sensor models, and the particle filter's options and paths.
set(_draw "$<TARGET_FILE:draw_scans>;${_out}/world.log;${_out}/truth_graph_slam/trajectory.tum")
set(_drawn "${_out}/drawn")
set(_run world_log truth_graph_slam)

# contains_test(NAME FILE REGEX [NEEDS ...]): the text of a file.
function(contains_test name file text)
  cmake_parse_arguments(ARG "" "" "NEEDS" ${ARGN})
  add_test(NAME programs.${name}
           COMMAND "${CMAKE_COMMAND}" "-DCOMMAND=${CMAKE_COMMAND};-E;cat;${file}" -DEXIT=zero
                   "-DOUTPUT=${text}" "-DFILES=" -P "${CMAKE_CURRENT_FUNCTION_LIST_DIR}/expect.cmake")
  set_tests_properties(programs.${name} PROPERTIES FIXTURES_REQUIRED "${ARG_NEEDS}")
endfunction()

program_test(draw_scans zero "LiDAR +[1-9][0-9]+ scans, [1-9][0-9]+ points\nradar +[1-9][0-9]+ frames, [1-9]"
  COMMAND "${_draw};--map;${_out}/truth_graph_slam/map.yaml;--plan;room;--sensor-model;--out;${_drawn};--force"
  FILES "${_drawn}/scans.svg;${_drawn}/report.html;${_drawn}/inverse_model.svg;${_drawn}/likelihood.svg"
  NEEDS ${_run} GIVES drawn)
contains_test(draw_scans_has_its_layers "${_drawn}/scans.svg"
  ">floor plan<.*>radar<.*>LiDAR<.*>path<.*>truth<.*<image [^\n]*data:image/png.*s0 line.*s1 dots.*s2 dots.*s3 line.*s4 dashed"
  NEEDS drawn ${_run})
contains_test(draw_scans_has_sensor_models "${_drawn}/likelihood.svg"
  "distance from a wall.*LiDAR, particle filter.*radar, particle filter.*LiDAR, localisation"
  NEEDS drawn ${_run})
program_test(draw_scans_keeps_what_is_there nonzero "scans.svg: already exists"
  COMMAND "${_draw};--out;${_drawn}" NEEDS drawn ${_run})
program_test(draw_scans_of_a_moment zero "LiDAR +1 scans.*radar +40 frames"
  COMMAND "${_draw};--at;20;--frames;40;--around;3;--out;${_out}/drawn_at;--force"
  FILES "${_out}/drawn_at/scans.svg" NEEDS ${_run})
program_test(draw_scans_of_a_span zero "LiDAR +([5-9]|1[0-9]) scans.*radar +[3-6][0-9] frames"
  COMMAND "${_draw};--from;10;--to;12;--out;${_out}/drawn_span;--force" NEEDS ${_run})
program_test(draw_scans_scores zero
  "Scores, LiDAR.*peaks +[1-9].*tau +0[.][0-9]+ m along.*Scores, radar.*peaks +[1-9].*tau +0[.]"
  COMMAND "${_draw};--score;30;--frames;40;--out;${_out}/drawn_scores;--force"
  FILES "${_out}/drawn_scores/score_lidar.svg;${_out}/drawn_scores/tau_lidar.svg;${_out}/drawn_scores/along_lidar.svg;${_out}/drawn_scores/across_lidar.svg;${_out}/drawn_scores/score_radar.svg;${_out}/drawn_scores/tau_radar.svg"
  NEEDS ${_run} GIVES drawn_scores)
contains_test(draw_scans_scores_have_axes "${_out}/drawn_scores/score_radar.svg"
  "best score.*pose on the path.*<image .*x .m..*y .m." NEEDS drawn_scores ${_run})
program_test(draw_scans_map_over_a_plan zero "LiDAR +0 scans"
  COMMAND "${_draw};--sensors;none;--map;${_out}/truth_graph_slam/map.yaml;--plan;room;--out;${_out}/drawn_map;--force"
  FILES "${_out}/drawn_map/scans.svg" NEEDS ${_run})
program_test(draw_scans_frames_of_no_time nonzero "--frames needs --at, --from, --to or --score"
  COMMAND "${_draw};--frames;3;--out;${_out}/x" NEEDS ${_run})
program_test(draw_scans_outside_the_log nonzero "--at 9999.0 is outside the log, whose scans take [0-9.]+ s"
  COMMAND "${_draw};--at;9999;--out;${_out}/x" NEEDS ${_run})
program_test(draw_scans_score_outside_the_log nonzero "--score 9999.0 is outside the log"
  COMMAND "${_draw};--score;9999;--out;${_out}/x" NEEDS ${_run})
program_test(draw_scans_score_without_a_map nonzero "there is no LiDAR map before"
  COMMAND "${_draw};--score;0;--out;${_out}/x" NEEDS ${_run})
program_test(draw_scans_no_overlap nonzero "later.tum: does not overlap with the log: its poses are from 5000.000 to 5002.000 s, the scans from "
  COMMAND "$<TARGET_FILE:draw_scans>;${_out}/world.log;${_out}/bad_truth/later.tum;--out;${_out}/x"
  NEEDS world_log)
program_test(draw_scans_no_map nonzero "nowhere.yaml"
  COMMAND "${_draw};--map;nowhere.yaml;--out;${_out}/x" NEEDS ${_run})
program_test(draw_scans_no_plan nonzero "nowhere.plan"
  COMMAND "${_draw};--plan;nowhere.plan;--out;${_out}/x" NEEDS ${_run})
program_test(draw_scans_sensor_that_is_missing nonzero "room.log: contains no scans of the chosen sensors"
  COMMAND "$<TARGET_FILE:draw_scans>;${_out}/room.log;${_out}/room/trajectory.tum;--sensors;radar;--out;${_out}/x"
  NEEDS room_log room_run)

set(_example "${PROJECT_SOURCE_DIR}/examples/programs/radar_slam/gated.json")
program_test(radar_slam_config zero "particles +10\n.*rejected by the gate"
  COMMAND "${_particles};${_out}/world.log;--sensors;radar;--config;${_example};--out;${_out}/gated;--force"
  NEEDS world_log)
file(WRITE "${_out}/tight.json" "{\"particles\": 4, \"lidar_gate_lateral_m\": 0.001, \"resample_below\": 1e-9}")
# Most matches are rejected: the result is in doubt.
program_test(radar_slam_gate_fires 3 "particles +4\n.*, [1-9][0-9]* rejected by the gate\nresampled +0 times"
  COMMAND "${_particles};${_out}/world.log;--sensors;lidar;--config;${_out}/tight.json;--paths;--scans;--out;${_out}/tight;--force"
  FILES "${_out}/tight/scans.svg;${_out}/tight/particles.csv;${_out}/tight/particles.svg" NEEDS world_log GIVES tight)
contains_test(radar_slam_gate_is_in_the_report "${_out}/tight/report.html" "rejected by the gate.*Paths of all particles.*Scans along the path"
  NEEDS tight world_log)
contains_test(radar_slam_paths "${_out}/tight/particles.csv" "particle,time_s,x_m,y_m,heading_deg\n1,.*\n4,"
  NEEDS tight world_log)
program_test(radar_slam_unknown_option nonzero "unknown option 'cell_mm'"
  COMMAND "${_particles};${_out}/world.log;--config;${_in}/unknown_option.json;--out;${_out}/x" NEEDS world_log)
file(WRITE "${_out}/half.json" "{\"particles\": 0.5}")
program_test(radar_slam_half_a_particle nonzero "option 'particles' must be at least 1"
  COMMAND "${_particles};${_out}/world.log;--config;${_out}/half.json;--out;${_out}/x" NEEDS world_log)
program_test(radar_slam_print_config zero "\"radar_frames\": 20,.*\"samples\": 500,.*\"lidar_gate_lateral_m\": 1000.0"
  COMMAND "${_particles};--print-config")

program_test(corridor_ins_wall_noise zero "noise of range +0[.]000.* m left.*noise of angle +0[.]0.*angle by search +0[.]"
  COMMAND "$<TARGET_FILE:corridor_ins>;--simulated;2;--wall-noise;--out;${_out}/wall_noise;--force"
  FILES "${_out}/wall_noise/walls.csv" GIVES wall_noise)
contains_test(corridor_ins_wall_noise_is_drawn "${_out}/wall_noise/report.html"
  "Error of the change of distance.*Angle of the walls by both methods" NEEDS wall_noise)
program_test(pedestrian_slam_study_eight zero ""
  COMMAND "$<TARGET_FILE:pedestrian_slam_study>;--write;${_out}/eight;--walk;eight;--write-plan;${_out}/eight/plan.txt"
  FILES "${_out}/eight/walk.log;${_out}/eight/unit.csv;${_out}/eight/plan.txt" GIVES eight)
program_test(pedestrian_slam_study_plan_is_one nonzero "a route is needed"
  COMMAND "$<TARGET_FILE:simulate>;${_out}/eight/plan.txt;--out;${_out}/x.log" NEEDS eight)
program_test(pedestrian_slam_study_unknown_walk nonzero "--walk"
  COMMAND "$<TARGET_FILE:pedestrian_slam_study>;--write;${_out}/x;--walk;moon")
