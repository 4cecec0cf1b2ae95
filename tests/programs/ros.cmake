# Logs converted to ROS recordings give a byte-identical graph. (Their times begin at 1 s if the log has
# none; recording_test.cpp compares the times of real logs.)
set(_convert "$<TARGET_FILE:convert_log>")
foreach(_kind IN ITEMS bag mcap)
  program_test(convert_log_${_kind} zero "scans +[1-9]"
    COMMAND "${_convert};${_out}/room.log;--out;${_out}/room.${_kind};--force"
    FILES "${_out}/room.${_kind}" NEEDS room_log GIVES room_${_kind})
  program_test(graph_slam_of_${_kind} zero "loop closures"
    COMMAND "${_slam};${_out}/room.${_kind};--out;${_out}/room_${_kind};--force"
    NEEDS room_${_kind} GIVES room_${_kind}_run)
  add_test(NAME programs.same_graph_of_${_kind}
           COMMAND "${CMAKE_COMMAND}" -E compare_files
                   "${_out}/room/graph.g2o" "${_out}/room_${_kind}/graph.g2o")
  set_tests_properties(programs.same_graph_of_${_kind} PROPERTIES
    FIXTURES_REQUIRED "room_log;room_run;room_${_kind};room_${_kind}_run")
endforeach()
program_test(convert_log_thins_out zero "scans +[1-9]"
  COMMAND "${_convert};${_out}/room.log;--out;${_out}/thinned.mcap;--every;2;--beams;2;--max-range;8;--field-of-view;120;--force"
  FILES "${_out}/thinned.mcap" NEEDS room_log GIVES room_thinned)
program_test(graph_slam_of_a_thinned_log zero "loop closures"
  COMMAND "${_slam};${_out}/thinned.mcap;--out;${_out}/room_thinned;--force" NEEDS room_thinned)
program_test(convert_log_keeps_what_is_there nonzero "room.bag"
  COMMAND "${_convert};${_out}/room.log;--out;${_out}/room.bag" NEEDS room_log room_bag)
program_test(convert_log_to_nothing_it_knows 2 "neither in .mcap nor in .bag"
  COMMAND "${_convert};${_out}/room.log;--out;${_out}/room.csv" NEEDS room_log)
program_test(graph_slam_topic_that_is_not_there nonzero "no topic /rear .*there is /scan"
  COMMAND "${_slam};${_out}/room.bag;--scan-topic;/rear;--out;${_out}/x" NEEDS room_bag)

# The inertial unit of a recording gives the same result as a separate file. (The log's times begin at
# zero, the recording's at 1 s: the maps are compared.)
program_test(convert_log_with_a_unit zero "gyro +0.*unit +[1-9]"
  COMMAND "${_convert};${_out}/head_walk/walk.log;--unit;${_out}/head_walk/unit.csv;--out;${_out}/head.bag;--force"
  FILES "${_out}/head.bag" NEEDS head_walk GIVES head_bag)
program_test(hector_slam_of_a_bag zero "fused +[1-9]"
  COMMAND "$<TARGET_FILE:hector_slam>;${_out}/head.bag;--out;${_out}/head_bag_hector;--force"
  NEEDS head_bag GIVES head_bag_hector)
add_test(NAME programs.same_hector_map_of_bag
         COMMAND "${CMAKE_COMMAND}" -E compare_files
                 "${_out}/head_hector/map.pgm" "${_out}/head_bag_hector/map.pgm")
set_tests_properties(programs.same_hector_map_of_bag PROPERTIES
  FIXTURES_REQUIRED "head_walk;head_bag;head_hector;head_bag_hector")
program_test(pedestrian_slam_of_a_bag zero "steps' scale +[01][.]"
  COMMAND "$<TARGET_FILE:pedestrian_slam>;${_out}/head.bag;--out;${_out}/head_bag_slam;--force"
  NEEDS head_bag)
program_test(pedestrian_slam_without_a_unit nonzero "walk.log: contains no inertial unit"
  COMMAND "$<TARGET_FILE:pedestrian_slam>;${_out}/head_walk/walk.log;--out;${_out}/x" NEEDS head_walk)
program_test(pedestrian_of_a_bag zero "steps +[1-9]"
  COMMAND "$<TARGET_FILE:pedestrian>;${_out}/head.bag;--out;${_out}/head_bag_walk;--force"
  NEEDS head_bag)
program_test(allan_of_a_bag zero "readings, 100[.]"
  COMMAND "$<TARGET_FILE:allan>;${_out}/head.bag" NEEDS head_bag)
program_test(convert_log_gyro_and_truth zero "gyro +[1-9].*truth +[1-9].*wheels +[1-9]"
  COMMAND "${_convert};${_out}/corridors/log.carmen;--out;${_out}/corridors.bag;--force"
  NEEDS corridors GIVES corridors_bag)
program_test(corridor_ins_of_a_bag zero "added bias found"
  COMMAND "$<TARGET_FILE:corridor_ins>;${_out}/corridors.bag;--add-bias;0.5;--out;${_out}/corridors_bag;--force"
  NEEDS corridors_bag)

# A world's log with wheels, gyro and radar: recordings of it give the same errors as the log. The
# distances of the wheels differ in their last bits, as sums of them are written; the last digit of
# the tables is 1 mm and 0.01 deg.
set(_world "${_out}/world.log")
foreach(_kind IN ITEMS bag mcap)
  program_test(convert_world_${_kind} zero "wheels +[1-9]"
    COMMAND "${_convert};${_world};--out;${_out}/world.${_kind};--force"
    NEEDS world_log GIVES world_${_kind})
  foreach(_program IN ITEMS corridor_ins "radar_slam;--sensors;lidar;--particles;5"
                            "radar_slam;--sensors;both;--particles;3")
    list(POP_FRONT _program _name)
    string(REGEX REPLACE "[-;]+" "_" _test "${_name};${_program}")
    add_test(NAME programs.same_errors_of_${_kind}_${_test}
             COMMAND "${CMAKE_COMMAND}" "-DPROGRAM=$<TARGET_FILE:${_name}>" "-DARGUMENTS=${_program}"
                     "-DLOG=${_world}" "-DOTHER=${_out}/world.${_kind}"
                     "-DOUT=${_out}/same_errors_${_kind}_${_test}"
                     -P "${CMAKE_CURRENT_SOURCE_DIR}/same_errors.cmake")
    set_tests_properties(programs.same_errors_of_${_kind}_${_test} PROPERTIES
      FIXTURES_REQUIRED "world_log;world_${_kind}")
  endforeach()
endforeach()
program_test(radar_slam_wheels_that_are_not_there nonzero
  "no wheel 'port'; there is left_wheel_joint, right_wheel_joint"
  COMMAND "${_particles};${_out}/world.bag;--wheels;port,starboard;--out;${_out}/x"
  NEEDS world_log world_bag)
program_test(radar_slam_wheels_without_a_radius nonzero "wheel radius: must be a positive number"
  COMMAND "${_particles};${_out}/world.bag;--wheel-radius;nan;--out;${_out}/x"
  NEEDS world_log world_bag)
program_test(corridor_ins_doubts_its_wheels zero "the wheels contradict the gyro"
  COMMAND "$<TARGET_FILE:corridor_ins>;${_out}/world.bag;--wheel-base;0.1;--out;${_out}/doubted;--force"
  NEEDS world_log world_bag)

add_test(NAME programs.rosbag_info
         COMMAND "${CMAKE_COMMAND}" "-DBAG=${_out}/room.bag"
                 -P "${CMAKE_CURRENT_SOURCE_DIR}/rosbag_info.cmake")
set_tests_properties(programs.rosbag_info PROPERTIES
  FIXTURES_REQUIRED "room_bag" SKIP_REGULAR_EXPRESSION "skipped: needs rosbag")

set(_rio "${WAYFARE_DATA_DIR}/radar/rio_demo/ti_mmwave_rospkg_demo.bag.gz")
if(EXISTS "${_rio}")
  program_test(radar_velocity zero "frames +412.*velocity found +[34]"
    COMMAND "$<TARGET_FILE:radar_velocity>;${_rio};--stamps;received;--out;${_out}/rio;--force"
    FILES "${_out}/rio/velocity.csv;${_out}/rio/report.html")
  program_test(radar_velocity_without_stamps nonzero "stamp is zero"
    COMMAND "$<TARGET_FILE:radar_velocity>;${_rio};--out;${_out}/x")
  program_test(ahrs_of_a_bag zero ""
    COMMAND "$<TARGET_FILE:ahrs>;${_rio};--out;${_out}/rio_ahrs;--force"
    FILES "${_out}/rio_ahrs/attitude.csv")
endif()
