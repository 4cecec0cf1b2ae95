"""Cases of the systems on robots' logs, of their simulations and of pose graphs."""

from case import Case

RELATIONS = {"fr079": "fr079", "intel": "intel", "intel_1hz": "intel"}


def log(name, *options):
    """A real log with its true relations where there are some, and where the results go."""
    ending = "clf" if name in RELATIONS else "log"
    relations = f" --relations {{data}}/slam2d/{RELATIONS[name]}.relations.gz" if name in RELATIONS else ""
    return " ".join((f"{{data}}/slam2d/{name}.{ending}.gz{relations}", *options, "--out {out}"))


# Logs as lesser sensors would have made them: shorter to run, and read as .mcap and .bag.
THIN = "convert_log {data}/slam2d/%s.clf.gz --every %d --beams %d --out {out}/log.%s"

BEAM_TIME = ((r"\s+[\d.]+ ± [\d.]+$", "last column: run time"),)

CASES = [
    Case("convert_fr079_thin", (THIN % ("fr079", 3, 4, "mcap"),)),
    Case("convert_intel_thin", (THIN % ("intel", 2, 2, "bag") + " --max-range 12 --field-of-view 150",)),
    Case("convert_fhw", ("convert_log {data}/slam2d/fhw-corrected.log.gz --every 4 --out {out}/log.bag",)),

    Case("graph_slam_options", ("graph_slam --print-config",)),
    Case("graph_slam_fr079", (f"graph_slam {log('fr079')}",)),
    Case("graph_slam_fr079_no_odometry", (f"graph_slam {log('fr079', '--no-odometry')}",)),
    Case("graph_slam_intel", (f"graph_slam {log('intel')}",)),
    Case("graph_slam_intel_threads", (f"graph_slam {log('intel', '--threads 2')}",)),
    Case("graph_slam_intel_1hz", (f"graph_slam {log('intel_1hz')}",)),
    Case("graph_slam_loop5", (f"graph_slam {log('loop5')}",)),
    Case("graph_slam_seattle", (f"graph_slam {log('seattle-corrected')}",)),
    Case("graph_slam_fhw", (f"graph_slam {log('fhw-corrected')}",)),
    Case("graph_slam_mcap", ("graph_slam {out:convert_fr079_thin}/log.mcap "
                             "--relations {data}/slam2d/fr079.relations.gz --out {out}",)),
    Case("graph_slam_damaged", ("graph_slam {inputs}/damaged.log --out {out}",)),
    Case("graph_slam_mines", ("graph_slam {data}/slam2d/mines_exp1.dat.gz --out {out}",), exit=1),

    Case("hector_slam_options", ("hector_slam --print-config",)),
    Case("hector_slam_fr079", (f"hector_slam {log('fr079')}",)),
    Case("hector_slam_fr079_no_odometry", (f"hector_slam {log('fr079', '--no-odometry')}",)),
    Case("hector_slam_intel", (f"hector_slam {log('intel')}",)),
    Case("hector_slam_intel_1hz", (f"hector_slam {log('intel_1hz')}",), exit=3),  # a scan a second
    Case("hector_slam_unit", ("hector_slam {out:head_walk}/walk.log --unit {out:head_walk}/unit.csv "
                              "--out {out}",)),
    Case("hector_slam_bag", ("hector_slam {out:head_walk}/walk.bag --out {out}",)),

    Case("submap_slam_options", ("submap_slam --print-config",)),
    Case("submap_slam_fr079", (f"submap_slam {log('fr079')}",)),
    Case("submap_slam_fr079_no_odometry", (f"submap_slam {log('fr079', '--no-odometry')}",)),
    Case("submap_slam_intel", (f"submap_slam {log('intel', '--threads 2')}",)),
    Case("submap_slam_intel_1hz", (f"submap_slam {log('intel_1hz')}",)),
    Case("submap_slam_fhw", (f"submap_slam {log('fhw-corrected')}",)),
    Case("submap_slam_loop5", (f"submap_slam {log('loop5')}",)),
    Case("submap_slam_loop5_no_odometry", (f"submap_slam {log('loop5', '--no-odometry')}",)),
    Case("submap_slam_seattle", (f"submap_slam {log('seattle-corrected')}",)),
    Case("submap_slam_save", (
        "submap_slam {out:convert_fr079_thin}/log.mcap --relations {data}/slam2d/fr079.relations.gz "
        "--no-odometry --save {out}/map.bin --out {out}",)),
    Case("submap_slam_continue", (
        "submap_slam {out:convert_intel_thin}/log.bag --save {out}/first.bin --out {out}/first",
        "submap_slam {out:convert_intel_thin}/log.bag --continue {out}/first.bin --out {out}/second",),
        exit=3),  # its scans are before the state's end

    Case("radar_slam_intel", (f"radar_slam {log('intel', '--seed 2')}",)),
    Case("radar_slam_intel_1hz", (f"radar_slam {log('intel_1hz', '--particles 8')}",)),
    Case("radar_slam_fr079", ("radar_slam {out:convert_fr079_thin}/log.mcap --particles 10 --seed 3 "
                              "--threads 2 --relations {data}/slam2d/fr079.relations.gz --out {out}",)),
    Case("radar_slam_radar", ("radar_slam {out:simulate_room}/robot.log --sensors radar --out {out}",)),
    Case("radar_slam_lidar", ("radar_slam {out:simulate_room}/robot.log --sensors lidar --particles 10 "
                              "--out {out}",)),
    Case("radar_slam_both", ("radar_slam {out:simulate_room}/robot.log --particles 10 --out {out}",)),
    Case("radar_slam_study", ("radar_slam_study cluttered_room --runs 1 --particles 3",),
         varies=((r"(?<=\d)\s+[\d.]+ ± [\d.]+$", "last column: run time"),)),

    Case("compare_methods_room", ("compare_methods {out:simulate_room}/robot.log --out {out}",)),
    Case("compare_methods_walk", (
        "compare_methods {out:head_walk}/walk.log --unit {out:head_walk}/unit.csv "
        "--methods pdr,hector,pedestrian,radar --threads 2 --out {out}",)),
    Case("graph_slam_truth", ("graph_slam {out:simulate_options}/robot.log "
                              "--truth {out:simulate_options}/truth.tum --out {out}",)),

    Case("match_comparison", ("match_comparison {out:convert_fr079_thin}/log.mcap --pairs 12 --out {out}",),
         varies=((r"(?:\s+\d+){3}$", "last three columns of the second table: run time"),)),

    Case("localise_fr079", ("localise {data}/slam2d/fr079.clf.gz {out:graph_slam_fr079}/map.yaml "
                            "--truth {out:graph_slam_fr079}/trajectory.tum --out {out}",)),
    Case("localise_beam", ("localise {out:convert_fr079_thin}/log.mcap {out:graph_slam_mcap}/map.yaml "
                           "--beam --initial 0,0,0 --seed 2 --out {out}",)),
    Case("localise_radar", (
        "localise {out:simulate_room}/robot.log {out:radar_slam_both}/map.yaml "
        "--radar-map {out:radar_slam_both}/radar_map.yaml --sensors radar --out {out}",)),
    Case("localise_both", (
        "localise {out:simulate_room}/robot.log {out:radar_slam_both}/map.yaml "
        "--radar-map {out:radar_slam_both}/radar_map.yaml --sensors both --threads 2 --out {out}",)),
    Case("localise_intel", ("localise {data}/slam2d/intel.clf.gz {out:graph_slam_intel}/map.yaml "
                            "--out {out}",)),
    Case("localisation_table", ("localisation_table --world room --world building --seeds 1 --verbose "
                                "--quiet",), varies=BEAM_TIME),
    Case("localisation_table_both", ("localisation_table --world cluttered_room --seeds 1 --sensors both "
                                     "--verbose --quiet",), varies=BEAM_TIME),

    Case("corridor_ins_options", ("corridor_ins --print-config",)),
    Case("corridor_ins_simulated_1", ("corridor_ins --simulated 1 --out {out}",)),
    Case("corridor_ins_simulated_2", ("corridor_ins --simulated 2 --seed 2 --no-walls-across "
                                      "--origin 50 8 30 --out {out}",)),
    Case("corridor_ins_seattle", (
        "corridor_ins {data}/slam2d/seattle-corrected.log.gz --add-bias 0.5 --passes 2 "
        "--reference {out:graph_slam_seattle}/trajectory.tum --out {out}",)),
    Case("corridor_ins_fr079", ("corridor_ins {data}/slam2d/fr079.clf.gz --rest --out {out} "
                                "--reference {out:graph_slam_fr079}/trajectory.tum",)),
    Case("corridor_study_1", ("corridor_study --pattern 1 --runs 3 --quiet",)),
    Case("corridor_study_2", ("corridor_study --pattern 2 --runs 2 --threads 2 --doors 3 --boxes 0.1 "
                              "--people 0.1 --quiet",)),

    Case("simulate_plan", ("simulate --print-plan",)),
    Case("simulate_building", ("simulate --out {out}/robot.log --truth {out}/truth.tum",)),
    Case("simulate_options", ("simulate {inputs}/room.plan --gyro --full-circle --seed 3 --beams 90 "
                              "--out {out}/robot.log --truth {out}/truth.tum",)),
    Case("simulate_map", ("simulate {out:graph_slam_simulated}/map.yaml --waypoint 2.35 2.35 --waypoint 3.7 2.35 "
                          "--out {out}/robot.log --truth {out}/truth.tum",)),
    Case("simulate_room", ("simulate room --out {out}/robot.log --truth {out}/truth.tum",)),
    Case("simulate_corridor_loop", ("simulate corridor_loop --seed 2 --out {out}/robot.log",)),
    Case("simulate_calibration_room", ("simulate calibration_room --seed 3 --out {out}/robot.log",)),
    Case("calibrate_robot", ("calibrate_robot {out:simulate_calibration_room}/robot.log --quiet "
                             "--corrected {out}/calibrated.log --out {out}",), exit=3),
    Case("calibration_study", ("calibration_study --runs 1 --quiet",),
         varies=((r"(?<=took )[\d.]+ s", "run time"),)),
    Case("simulate_voxels", (
        "simulate --voxels {data}/radar/coloradar_rmap/data/maps/arpg_lab_run0_radar.txt.gz "
        "--way {data}/radar/coloradar_rmap/data/poses/arpg_lab_run0.txt --out {out}/robot.log",)),
    Case("graph_slam_simulated", ("graph_slam {out:simulate_options}/robot.log --out {out}",)),
    Case("demo", ("demo --out {out}",), varies=((r"(?<=\d)\s+\d+\.\d$", "last column: run time"),)),
    Case("demo_office", ("demo --world office --seed 2 --out {out}",),
         varies=((r"^SLAM took\b.*$", "run time"),)),
    Case("hallway_comparison", ("hallway_comparison --seeds 1 --frames 8 --out {out}",)),
    Case("radar_statistics", ("radar_statistics --captures {data}/devices/ti_mmwave/awr1843_sdk3.6 "
                              "--views 20 --frames 3 --all-points",)),
    Case("radar_velocity", ("radar_velocity {data}/radar/rio_demo/ti_mmwave_rospkg_demo.bag.gz "
                            "--stamps received --out {out}",)),
    Case("radar_velocity_inertial", (
        "radar_velocity {data}/radar/rio_demo/ti_mmwave_rospkg_demo.bag.gz --stamps received --inertial "
        "--rotation 0.918681231 -0.386946838 -0.071757109 -0.033880048 "
        "--lever 0.03 0.03 -0.06 --radar-delay 0.1 --out {out}",)),
    Case("radar_velocity_plane", (
        "radar_velocity {out:simulate_corridor_loop}/robot.log --plane --seed 2 --out {out}",)),
]


def graph(name, file, options="", **more):
    command = (f"pose_graph {{data}}/posegraph/{file}.g2o.gz {options} --out {{out}}/graph.g2o",)
    return Case(f"pose_graph_{name}", command, **more,
                varies=((r"^(?:time|start) +[\d.]+ ms.*$", "run time"),))


DRAWN = "--svg {out}/graph.svg --marginals {out}/marginals.csv"
GNC = "--rejected {out}/rejected.csv " + DRAWN

CASES += [
    graph("intel", "intel", DRAWN),
    graph("intel_lm", "intel", "--method lm --init odometry"),
    graph("intel_incremental", "intel", "--incremental"),
    graph("M3500", "M3500", DRAWN),
    graph("M3500_incremental", "M3500", "--incremental"),
    graph("M3500_tree", "M3500_odo", "--init tree --solver cholmod"),
    graph("city10000", "city10000", "--init chordal --threads 2"),
    graph("sphere2500", "sphere2500", DRAWN),
    graph("sphere2500_threads", "sphere2500", "--threads 2 --init tree"),
    graph("parking", "parking-garage", DRAWN),
    graph("grid_eigen", "smallGrid3D", "--solver eigen"),
    graph("MIT", "MIT"),
    graph("MIT_odometry", "MIT", "--init odometry --max-iterations 50"),
    graph("MIT_chordal", "MIT", "--init chordal"),
    graph("cubicle", "cubicle", exit=1),
    graph("cubicle_projected", "cubicle", "--indefinite project --init chordal"),
    graph("false_loops_gnc", "M3500_out100", "--robust gnc " + GNC),
    graph("false_loops_gnc_gm", "intel_943_odo_out100", "--robust gnc-gm --inliers 0.99 " + GNC),
    graph("false_loops_gnc_all", "intel_943_odo_out100", "--robust gnc --robust-all " + GNC),
]
CASES += [graph(f"false_loops_{kernel}", "intel_943_odo_out100", f"--robust {kernel} --robust-scale 1.5")
          for kernel in ("huber", "cauchy", "gm", "dcs")]
