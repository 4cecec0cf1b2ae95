"""Cases of captures of devices and of what the logger recorded."""

from case import Case

TI = "{data}/devices/ti_mmwave"
MTI = "{data}/devices/xsens/mti_mtdata2"
AWINDA = "{data}/devices/xsens/awinda_mtb"


def decoded(name, *captures, options=""):
    """A capture each: device, file."""
    return Case(f"decode_{name}", tuple(
        f"decode {device} {file} --csv {options} --out {{out}}/{i}.csv"
        for i, (device, file) in enumerate(captures)))


CASES = [
    decoded("ti", *(("ti", f"{TI}/awr1843_sdk3.6/{n}.dat.gz")
                    for n in ("dynmer1", "dynmer2_3", "mer1", "mer2", "mer4", "mer6", "mer7", "mer9",
                              "mer10"))),
    decoded("ti_sdk1", ("ti", f"{TI}/xwr1642_sdk1.2/oob_output_data.bin.gz")),
    decoded("ti_config", ("ti", f"{TI}/awr1843_sdk3.6/mer1.dat.gz"),
            options=f"--config {TI}/awr1843_sdk3.6/mer1.cfg"),
    decoded("rplidar", *(("rplidar", f"{{data}}/devices/rplidar/legacy_scan_bin/{n}.bin")
                         for n in ("living_room_116_steps/frame_0005", "living_room_116_steps/frame_0009"))),
    decoded("rplidar_express", ("rplidar", "{data}/devices/rplidar/pyrplidar_capsule82_legacy.bin"),
            options="--inside express --baud 256000"),
    decoded("rplidar_ultra", ("rplidar", "{data}/devices/rplidar/pyrplidar_capsule84_ultra.bin"),
            options="--inside ultra --sample-us 250"),
    decoded("xsens", ("xsens", f"{MTI}/20260503_204234_xsensmti_with_gnss_recording.bin.gz"),
            *(("xsens", f"{MTI}/einride_testdata/{i}/output.bin") for i in range(1, 6))),
    decoded("xsens_station", ("xsens", f"{AWINDA}/Static/pose2/MT_012012B9_000.mtb.gz"),
            ("xsens", f"{AWINDA}/Dynamic/Lunges/MT_012012B9_000.mtb.gz")),
    Case("decode_to_stdout", ("decode xsens {inputs}/xbus.bin --csv",)),
    Case("decode_another_device", ("decode ti {inputs}/xbus.bin --csv",), exit=1),

    Case("logger_options", ("logger --print-config",)),
    # What the logger recorded, as fast as it goes.
    Case("replay_walk", ("./device_recording imu {inputs}/walk.csv {out}/walk.mcap",
                         "replay {out}/walk.mcap --speed 1000000",)),
    Case("replay_scans", (
        "simulate {inputs}/room.plan --scan-rate 5 --out {out}/robot.log --quiet",
        "./device_recording scan {out}/robot.log {out}/scans.mcap",
        "graph_slam {out}/scans.mcap --out {out}",
        "replay {out}/scans.mcap --system graph_slam --speed 1000000",)),
    Case("replay_bytes", (
        f"./device_recording raw {MTI}/einride_testdata/1/output.bin {{out}}/bytes.mcap",
        "replay {out}/bytes.mcap --ptys {out}/ptys --speed 1000",
        "replay --ptys {out}/ptys --capture unit:100000:{inputs}/xbus.bin --seconds 0.02",)),
]
