"""The cases of the golden check, and the programs it cannot run."""

import cases_devices
import cases_motion
import cases_slam

CASES = cases_slam.CASES + cases_motion.CASES + cases_devices.CASES

_LIVE = "live: runs until it is stopped"
NOT_COVERED = {
    "monitor": "a server: it runs until it is stopped",
    "slam_node": _LIVE,
    "localise_node": _LIVE,
    "hector_node": _LIVE,
    "pedestrian_slam_node": _LIVE,
    "pedestrian_node": _LIVE,
    "lidar_driver_node": _LIVE,
    "radar_driver_node": _LIVE,
    "xsens_driver_node": _LIVE,
    "play_recording": "live topics",
    "record_topics": _LIVE,
    "ros2_latency": "measures times",
    "tune_against_pagmo": "compares times with pagmo's; built only where pagmo is",
}

assert len({c.name for c in CASES}) == len(CASES), "two cases of one name"
