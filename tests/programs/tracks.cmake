# Tracks in the formats of other programs, written and read back, compared; columns by heading or number.
set(_compare "$<TARGET_FILE:compare_tracks>")
set(_tracks "${_out}/tracks")
program_test(tracks_of_simulate_drive zero "range epochs"
  COMMAND "${_drive};--imu-rate;10;--start;1435000000;--track-formats;kml,gpx,nmea,pos,ecef;--out;${_tracks};--force"
  FILES "${_tracks}/track.kml;${_tracks}/track.gpx;${_tracks}/track.nmea;${_tracks}/track.pos;${_tracks}/track_ecef.pos"
  GIVES tracks)
file(WRITE "${_out}/tracks_kept/track.gpx" "kept\n")
program_test(tracks_keep_what_is_there 1 "track.gpx: already exists"
  COMMAND "${_drive};--track-formats;gpx;--out;${_out}/tracks_kept")
program_test(tracks_of_unknown_format 2 "--track-formats"
  COMMAND "${_drive};--track-formats;shp;--out;${_out}/x")
# Rounded to 0.1 mm by .pos, to 1 mm by GPX, to 2 mm by NMEA.
foreach(_file IN ITEMS track.gpx track.nmea track.pos track_ecef.pos)
  program_test(compare_tracks_${_file} 0 "points in 310[.][0-9] s.*\nin space +0[.]00[0-2] +0[.]00[0-2] +0[.]00[0-2]"
    COMMAND "${_compare};${_tracks}/${_file};${_tracks}/truth.txt" NEEDS tracks)
endforeach()
program_test(compare_tracks_outputs 0 "time offset +-1[.]2[0-9]+ s.*along"
  COMMAND "${_compare};${_tracks}/track.gpx;${_tracks}/truth.txt;--offset;-1.2;--search-offset;0;--out;${_out}/compared_tracks;--json;${_out}/compared_tracks.json;--force"
  FILES "${_out}/compared_tracks/errors.csv;${_out}/compared_tracks/errors.svg;${_out}/compared_tracks/plan.svg;${_out}/compared_tracks/report.html;${_out}/compared_tracks.json"
  NEEDS tracks GIVES compared_tracks)
program_test(compare_tracks_keeps_what_is_there 1 "errors.csv: already exists"
  COMMAND "${_compare};${_tracks}/track.gpx;${_tracks}/truth.txt;--out;${_out}/compared_tracks" NEEDS tracks compared_tracks)

# A kilometre in TUM text, its clock 0.75 s late, turned by 30 degrees and, as the digits are few, 2e-5
# shorter: 1 ms of the offset.
set(_straight "")
set(_turned "")
set(_rest "")
foreach(_i RANGE 0 100)
  math(EXPR _x "${_i} * ${_i}")
  math(EXPR _c "${_x} * 866")
  math(EXPR _s "${_x} * 500")
  string(APPEND _straight "${_i}.75 ${_x}e-1 0 0 0 0 0 1\n")
  string(APPEND _turned "${_i} ${_c}e-4 ${_s}e-4 5 0 0 0 1\n")
  string(APPEND _rest "${_i} 1 2 3 0 0 0 1\n")
endforeach()
file(WRITE "${_out}/straight.tum" "${_straight}")
file(WRITE "${_out}/turned.tum" "${_turned}")
file(WRITE "${_out}/rest.tum" "${_rest}")
file(WRITE "${_out}/back.tum" "1 0 0 0 0 0 0 1\n2 1 0 0 0 0 0 1\n1.5 2 0 0 0 0 0 1\n")
file(WRITE "${_out}/nan.tum" "1 0 0 0 0 0 0 1\n2 nan 0 0 0 0 0 1\n")
file(WRITE "${_out}/foreign.csv" "Stamp;North;East\n0;0;0\n50;0;250\n100;0;1000\n")
program_test(compare_tracks_offset_and_turn 0 "time offset +-0[.]7(4[89]|50).*turned by +30[.]0.*in space +0[.]0"
  COMMAND "${_compare};${_out}/straight.tum;${_out}/turned.tum;--align;rigid;--search-offset;3")
program_test(compare_tracks_columns_by_name_and_number 0 "compared +3 points"
  COMMAND "${_compare};${_out}/foreign.csv;${_out}/turned.tum;--align;rigid;--column;A:t_s=Stamp;--column;A:x_m=3;--column;A:y_m=North")
program_test(compare_tracks_offset_at_the_limit 3 "end of the search"
  COMMAND "${_compare};${_out}/straight.tum;${_out}/turned.tum;--align;rigid;--search-offset;0.3")
program_test(compare_tracks_at_rest 3 "do not determine the time offset"
  COMMAND "${_compare};${_out}/rest.tum;${_out}/rest.tum;--search-offset;3")
program_test(compare_tracks_without_overlap 1 "do not overlap in time"
  COMMAND "${_compare};${_out}/straight.tum;${_out}/turned.tum;--offset;500")
program_test(compare_tracks_decreasing 1 "back.tum: point 3, at 1.500 s, is earlier"
  COMMAND "${_compare};${_out}/back.tum;${_out}/turned.tum")
program_test(compare_tracks_nan 1 "nan.tum:2: not a finite number"
  COMMAND "${_compare};${_out}/turned.tum;${_out}/nan.tum")
program_test(compare_tracks_local_and_geographic 2 "--align rigid is needed"
  COMMAND "${_compare};${_out}/turned.tum;${_tracks}/track.gpx" NEEDS tracks)
program_test(compare_tracks_kml_without_times 1 "track.kml: is a KML line without times"
  COMMAND "${_compare};${_tracks}/track.kml;${_tracks}/track.gpx" NEEDS tracks)
program_test(compare_tracks_column_of_no_file 2 "--column must be A:NAME=COLUMN"
  COMMAND "${_compare};${_out}/foreign.csv;${_out}/turned.tum;--column;x_m=3")

# gnss_ins: fixes of other formats, tracks out, columns, dry run.
program_test(gnss_ins_of_nmea_to_tracks zero "fixes +[0-9]+"
  COMMAND "${_ins};--imu;${_tracks}/imu.txt;--fixes;${_tracks}/track.nmea;--rate;1;--track-formats;pos,ecef,gpx,nmea,kml;--out;${_out}/tracks_ins;--force"
  FILES "${_out}/tracks_ins/track.kml;${_out}/tracks_ins/track_ecef.pos" NEEDS tracks GIVES tracks_ins)
program_test(gnss_ins_of_its_own_pos zero "fixes +[0-9]+"
  COMMAND "${_ins};--imu;${_tracks}/imu.txt;--fixes;${_out}/tracks_ins/track_ecef.pos;--truth;${_out}/tracks_ins/track.pos;--out;${_out}/tracks_again;--force"
  NEEDS tracks tracks_ins)
program_test(compare_tracks_of_gnss_ins 0 "in space"
  COMMAND "${_compare};${_out}/tracks_ins/track.nmea;${_out}/tracks_ins/track.pos" NEEDS tracks_ins tracks)
file(WRITE "${_out}/foreign_imu.csv"
     "Time;Acc X;Acc Y;Acc Z;rx;ry;rz;note\n1000;0.01;0.02;-1;1;2;3;a\n1010;0.01;0.02;-1;4;5;6;b\n")
set(_foreign "${_ins};--imu;${_out}/foreign_imu.csv;--column;imu:t_ms=Time;--column;imu:ax_g=Acc X;--column;imu:ay_g=3;--column;imu:az_g=Acc Z;--column;imu:gx_degps=rx;--column;imu:gy_degps=ry")
program_test(gnss_ins_dry_run 0 "2 rows\n.*column 5 'rx': gx_degps\n.*row +time .s. +as GPS time +gx .deg/s.*\n1 +1[.]000 +1980-01-06 00:00:01[.]000 +1[.]000 +2[.]000 +3[.]000 .*9[.]80"
  COMMAND "${_foreign};--column;imu:gz_degps=7;--dry-run")
program_test(gnss_ins_dry_run_names_a_missing_column 1 "has no column 'rw' for gz_degps; it has 8 columns, the first is 'Time'"
  COMMAND "${_foreign};--column;imu:gz_degps=rw;--dry-run")
file(WRITE "${_out}/foreign_imu.json"
     "{\"imu\": {\"columns\": {\"t_ms\": \"Time\", \"ax_g\": 2, \"ay_g\": 3, \"az_g\": 4, \"gx_degps\": \"rx\", \"gy_degps\": \"ry\", \"gz_degps\": \"rz\"}}}\n")
program_test(gnss_ins_dry_run_by_config 0 "column 2 'Acc X': ax_g"
  COMMAND "${_ins};--imu;${_out}/foreign_imu.csv;--config;${_out}/foreign_imu.json;--dry-run")
program_test(gnss_ins_column_of_no_file 2 "--column must be FILE:NAME=COLUMN"
  COMMAND "${_ins};--imu;${_out}/foreign_imu.csv;--column;wheel:t_ms=1;--dry-run")
program_test(gnss_ins_needs_a_folder 2 "--out is required"
  COMMAND "${_ins};--imu;${_tracks}/imu.txt;--fixes;${_tracks}/track.nmea" NEEDS tracks)
program_test(spp_tracks zero "answered +5"
  COMMAND "${_spp};--obs;${_in}/sky.obs;--nav;${_in}/sky.nav;--track-formats;gpx,ecef;--out;${_out}/spp_tracks;--force"
  FILES "${_out}/spp_tracks/track.gpx;${_out}/spp_tracks/track_ecef.pos")

# Streams of receivers.
program_test(decode_nmea zero "1,GPGGA,,12:35:19[.]000,1,8,0[.]9,48[.]117.*2,GPRMC,1994-11-19,22:54:46.*2 sentences: 1 GPGGA, 1 GPRMC"
  COMMAND "$<TARGET_FILE:decode>;nmea;${_in}/two_sentences.nmea;--csv")
set(_ubx "${WAYFARE_DATA_DIR}/gnss/walk_0827/gnss_1730.ubx.gz")
if(EXISTS "${_ubx}")
  program_test(decode_ubx zero "3400 messages: 536 NAV-PVT, 536 RXM-RAWX, 2328 RXM-SFRBX"
    COMMAND "$<TARGET_FILE:decode>;ubx;${_ubx};--csv;--out;${_out}/walk_ubx.csv;--force" FILES "${_out}/walk_ubx.csv")
  program_test(spp_of_ubx zero "epochs +536\nanswered +5[0-9][0-9]"
    COMMAND "${_spp};--obs;${_ubx};--truth;${_ubx};--track-formats;gpx;--out;${_out}/spp_ubx;--force"
    FILES "${_out}/spp_ubx/track.gpx")
endif()
