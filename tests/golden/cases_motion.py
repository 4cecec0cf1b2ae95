"""Cases of attitude, of walkers, and of inertial and satellite navigation."""

from case import Case

# Columns of the tables that do not name them; see the recordings' own description.
BROAD = ("--enu --period 0.007 --columns gx_radps,gy_radps,gz_radps,ax_mps2,ay_mps2,az_mps2,"
         "mx_uT,my_uT,mz_uT,qw,qx,qy,qz,moving")
PHONE = ("--columns t_s,ax_mps2,ay_mps2,az_mps2,gx_radps,gy_radps,gz_radps,mx_uT,my_uT,mz_uT,"
         "-,-,-,-,-,-,-,-,-")
PHONE_RAW = ("--columns t_s,ax_mps2,ay_mps2,az_mps2,-,-,-,-,-,-,-,-,-,gx_radps,gy_radps,gz_radps,"
             "mx_uT,my_uT,mz_uT")
HEAD = ("--columns t_s,gx_radps,gy_radps,gz_radps,ax_mps2,ay_mps2,az_mps2,mx_uT,my_uT,mz_uT,"
        "-,-,-,-,-,-")
FOOT = "--columns ax_mps2,ay_mps2,az_mps2,gx_radps,gy_radps,gz_radps,-,-,-"
THREE_UNITS = ("--columns -,-,-,-,-,-,-,-,-,ax_mps2,ay_mps2,az_mps2,gx_radps,gy_radps,gz_radps,"
               "-,-,-,-,-,-,-,-,-,-,-,-")

SLOW = "{data}/ahrs/broad10_half/02_undisturbed_slow_rotation_B.f32.gz"
FAST = "{data}/ahrs/broad10_half/18_undisturbed_fast_translation_with_breaks_B.f32.gz"
MAGNET = "{data}/ahrs/broad10_half/28_disturbed_stationary_magnet_A.f32.gz"
TRIALS = " ".join(f"{{data}}/ahrs/broad10_half/{n}.f32.gz" for n in (
    "02_undisturbed_slow_rotation_B", "05_undisturbed_slow_rotation_with_breaks_B",
    "09_undisturbed_fast_rotation_with_breaks_B", "11_undisturbed_slow_translation_B",
    "16_undisturbed_fast_translation_B", "18_undisturbed_fast_translation_with_breaks_B",
    "21_undisturbed_fast_combined", "24_disturbed_tapping_A", "28_disturbed_stationary_magnet_A",
    "33_disturbed_attached_magnet_2cm"))
RIO = "{data}/radar/rio_demo/ti_mmwave_rospkg_demo.bag.gz"

CASES = [
    Case("ahrs_broad", (f"ahrs {SLOW} {BROAD} --declination 2 --out {{out}}",)),
    Case("ahrs_magnet", (f"ahrs {MAGNET} {BROAD} --magnetometer-delay 0.01 --out {{out}}",)),
    Case("ahrs_no_magnetometer", (f"ahrs {FAST} {BROAD} --no-magnetometer --out {{out}}",)),
    Case("ahrs_bag", (f"ahrs {RIO} --out {{out}}",)),
    Case("ahrs_calibrated", (
        "calibrate_magnetometer {inputs}/turned_about.csv --out {out}/iron.json",
        "ahrs {inputs}/turned_about.csv --calibration {out}/iron.json --out {out}",)),
    Case("calibrate_magnetometer", (
        f"calibrate_magnetometer {SLOW} {BROAD.replace('--enu ', '')} --field 49 --out {{out}}/iron.json",)),
    Case("attitude_table", (f"attitude_table {TRIALS} {BROAD} --quiet",)),
    Case("attitude_table_gyro", (f"attitude_table {SLOW} {BROAD} --no-magnetometer --quiet",)),

    Case("pedestrian_phone", (f"pedestrian {{data}}/pdr/loc20/site1_F2_5dda5a8b9191710006b573da.f32.gz "
                              f"{PHONE} --forward y --out {{out}}",)),
    Case("pedestrian_phone_uncalibrated", (
        f"pedestrian {{data}}/pdr/loc20/site2_F8_5dd4e2a8d48f840006f1456d.f32.gz {PHONE_RAW} "
        "--uncalibrated --forward y --straight 0.2 --out {out}",)),
    Case("pedestrian_phone_any_way", (
        f"pedestrian {{data}}/pdr/loc20/site2_B1_5dd511e9d48f840006f148f2.f32.gz {PHONE} "
        "--any-way-round --length weinberg --no-magnetometer --out {out}",)),
    Case("pedestrian_head", (f"pedestrian {{data}}/pdr/rocip_head/w36.f32.gz {HEAD} --out {{out}}",)),
    Case("pedestrian_runner", (f"pedestrian {{data}}/pdr/rocip_head/r15.f32.gz {HEAD} --length frequency "
                               "--height 1.8 --straight 0.2 --out {out}",)),
    Case("pedestrian_columns", ("pedestrian {inputs}/walk.csv --length constant --factor 0.7 --out {out}",)),
    Case("pedestrian_truth", ("pedestrian {inputs}/walk.csv "
                              "--truth {out:pedestrian_columns}/trajectory.tum --out {out}",)),
    Case("pedestrian_logged", ("./device_recording imu {inputs}/walk.csv {out}/walk.mcap",
                               "pedestrian {out}/walk.mcap --out {out}",)),
    Case("pedestrian_foot_vicon", (
        f"pedestrian {{data}}/pdr/pyshoe_vicon/2017-11-22-11-35-59.f32.gz {FOOT} --period 0.005 --foot "
        "--out {out}",)),
    Case("pedestrian_foot_loop", (
        f"pedestrian {{data}}/pdr/openshoe2010/Measurement_100521_44.f32.gz {FOOT} --period 0.004 --foot "
        "--ared --out {out}",)),
    Case("pedestrian_foot_gait", (
        f"pedestrian {{data}}/pdr/ipol_gait/1-3.f32.gz {THREE_UNITS} --period 0.01 --foot "
        "--gyro-range 1200 --out {out}",)),
    Case("pedestrian_foot_walk", (
        "pedestrian {data}/pdr/xio_gait/short_walk.f32.gz --foot "
        "--columns t_s,gx_degps,gy_degps,gz_degps,ax_g,ay_g,az_g --out {out}",)),

    Case("head_walk", (
        "pedestrian_slam_study --write {out}",
        "convert_log {out}/walk.log --unit {out}/unit.csv --out {out}/walk.bag",)),
    Case("pedestrian_slam_options", ("pedestrian_slam --print-config",)),
    Case("pedestrian_slam", ("pedestrian_slam {out:head_walk}/walk.log --unit {out:head_walk}/unit.csv "
                             "--out {out}",)),
    Case("pedestrian_slam_bag", ("pedestrian_slam {out:head_walk}/walk.bag --step 0.7 --no-feedback "
                                 "--no-magnetometer --out {out}",)),
    Case("pedestrian_slam_no_steps", (
        "pedestrian_slam {out:head_walk}/walk.log --unit {out:head_walk}/unit.csv --no-steps --no-heading "
        "--out {out}",)),
    Case("pedestrian_slam_study", ("pedestrian_slam_study --seeds 2 --each --quiet",)),
    Case("pedestrian_slam_study_sweeps", ("pedestrian_slam_study --sweep 181.3 --seed 22 --seeds 1 --each --quiet",)),
    Case("pedestrian_slam_study_hector", ("pedestrian_slam_study --hector --seeds 1 --each --quiet",)),
    Case("pedestrian_slam_study_heading", ("pedestrian_slam_study --heading --seeds 1 --gyro-bias 0.5 "
                                           "--each --quiet",)),
]

S = "{data}/gnss/instinct_spirent_dyn"
U = "{data}/gnss/urbannav_tst"
W = "{data}/gnss/walk_0827"
C = "{data}/gnss/stuttgart_city"
D = "{data}/gnss/drive_0708"
DRIVE = (f"--imu {D}/imu_1934.csv.gz --imu-tags {D}/imu_1934.csv.tag.gz "
         f"--truth {D}/gnss_1934_sf.pos.gz --config {{inputs}}/drive_0708.json")
# The drive's folder as gnss_ins and tune read it.
SIMULATED = ("--imu {out:simulate_drive}/imu.txt --ranges {out:simulate_drive}/ranges.txt "
             "--truth {out:simulate_drive}/truth.txt")

CASES += [
    Case("spp_spirent_no_atmosphere", (
        f"spp --obs {S}/iono-none_tropo-none/Rover-dynamic_MO_Spirent.obs.gz "
        f"--nav {S}/RINEX_GN_Spirent.23N {S}/RINEX_EN_Spirent.23L "
        "--no-ionosphere --no-troposphere --out {out}",)),
    Case("spp_spirent", (
        f"spp --obs {S}/iono-Klob_tropo-Saast/Rover-dynamic_MO_Spirent.obs.gz "
        f"--nav {S}/RINEX_GN_Spirent.23N {S}/RINEX_EN_Spirent.23L --out {{out}}",)),
    Case("spp_hong_kong", (
        f"spp --obs {U}/COM3_190428_124409.obs.gz --nav {U}/hksc1180.19n {U}/hksc1180.19b "
        f"--truth {U}/groundTruth_TST.csv --truth-columns week,tow_s,lat_deg,lon_deg,h_m --out {{out}}",)),
    Case("spp_hong_kong_gps", (
        f"spp --obs {U}/COM3_190428_124409.obs.gz --nav {U}/hksc1180.19n --system G --no-offsets "
        "--out {out}",)),
    Case("spp_walk", (f"spp --obs {W}/walk.obs.gz --nav {W}/walk.nav --truth {W}/gnss_1730_sf.pos "
                      "--out {out}",)),
    Case("spp_stuttgart", (
        f"spp --obs {C}/stuttgart_city.obs.gz --nav {C}/stuttgart_city.nav "
        f"--truth {C}/20201121_152755_GNSS.csv --truth-skip 1 "
        "--truth-columns -,utc_ms,lat_deg,lon_deg,h_m,-,-,-,-,-,- --out {out}",)),

    Case("gnss_ins_options", ("gnss_ins --print-config",)),
    Case("gnss_ins_stuttgart", (
        f"gnss_ins --imu {C}/20201121_152755_Acc.csv.gz {C}/20201121_152755_Gyro.csv.gz "
        f"--imu-clock {C}/20201121_152755_GNSS.csv --obs {C}/stuttgart_city.obs.gz "
        f"--nav {C}/stuttgart_city.nav --truth {C}/20201121_152755_GNSS.csv "
        "--config {inputs}/stuttgart_city.json --rate 5 --out {out}",)),
    Case("gnss_ins_walk", (
        f"gnss_ins --imu {W}/imu_1730.csv.gz --imu-tags {W}/imu_1730.csv.tag --obs {W}/walk.obs.gz "
        f"--nav {W}/walk.nav --truth {W}/gnss_1730_sf.pos --config {{inputs}}/walk_0827.json "
        "--out {out}",)),
    Case("gnss_ins_drive_fixes", (
        f"gnss_ins {DRIVE} --fixes {D}/gnss_1934_sf.pos.gz --outage 100:10,200:30 --out {{out}}",)),
    Case("gnss_ins_simulated", (f"gnss_ins {SIMULATED} --outage 100:30,200:30:2 --out {{out}}",)),
    Case("gnss_ins_no_constraints", (f"gnss_ins {SIMULATED} --outage 60:20 --no-constraints --rate 10 "
                                     "--out {out}",)),
    Case("outage_test_simulated", ("outage_test --simulated --places 2 --seed 2 --threads 2 --quiet "
                                   "--out {out}",)),
    Case("outage_test_drive", (f"outage_test {DRIVE} --places 2 --period 1 --out {{out}}",)),
    Case("simulate_drive", ("simulate_drive --satellites 8 --out {out}",)),
    Case("simulate_drive_town", ("simulate_drive --route town --seed 3 --imu-rate 20 "
                                 "--config {inputs}/road.json --outage 60:30:2 --lever-arm 0.5 0 -1 "
                                 "--out {out}",)),
    Case("simulate_drive_ring", ("simulate_drive --route ring --perfect-imu --imu-rate 20 --range-rate 2 "
                                 "--out {out}",)),
    Case("simulate_drive_track", (f"simulate_drive --track {D}/gnss_1934_sf.pos.gz --imu-rate 20 "
                                  "--velocity-late 0.1 --out {out}",)),
    Case("allan_static", ("allan {data}/gnss/imu_static/adis16405_1.f32.gz --raw --rate 100 --out {out}",)),
    Case("allan_simulated", ("allan {out:simulate_drive}/imu.txt --config {inputs}/road.json --out {out}",)),
    Case("allan_bag", ("allan {out:head_walk}/walk.bag",)),
    Case("cut_drive", (f"cut_drive {DRIVE} --from 60 --to 130 --out {{out}}",)),
    Case("ins_consistency", ("ins_consistency --runs 3 --imu-rate 20 --quiet --out {out}",)),
    Case("ins_consistency_rounds", ("ins_consistency --runs 2 --rounds 1 --imu-rate 10 --constraints "
                                    "--threads 2 --seed 2 --quiet --out {out}",)),
]

TUNED_IN = ((r"^time of the search\b.*$", "run time; threads and kernel are the machine's"),)
CASES += [
    Case("tune", ("tune --training {out:simulate_drive_town} --test {out:simulate_drive_ring} "
                  "--nominal {inputs}/rest.json --population 16 --generations 3 --runs 2 --threads 2 "
                  "--out {out}",), varies=TUNED_IN),
    Case("tune_cut", ("tune --training {out:cut_drive} --population 12 --generations 2 --no-outages "
                      "--kernel baseline --seed 4 --out {out}",), varies=TUNED_IN),
    Case("tune_resume", (
        "tune --training {out:simulate_drive_town} --population 12 --generations 1 --out {out}",
        "tune --training {out:simulate_drive_town} --population 12 --generations 1 --resume --out {out}",),
         varies=TUNED_IN),
]
