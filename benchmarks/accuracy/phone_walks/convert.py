#!/usr/bin/env python3
"""Walks of Microsoft's indoor location data of 2020 as tables that test_pedestrian reads.

    git clone https://github.com/location-competition/indoor-location-competition-20 REPOSITORY
    convert.py REPOSITORY OUT [--known FOLDER]

Of each floor the 18 longest recordings are taken, without those in the folder of known ones
(pdr/loc20): of the first eight, in the order of their names, every other one goes to OUT/chosen and
OUT/aside, the other ten go to OUT/more. Columns as in pdr/loc20: t, acceleration, turn rate, field,
rotation vector, uncalibrated turn rate and field; the waypoints beside.
"""

import argparse
import array
import gzip
import pathlib
import struct
import subprocess

KINDS = ["ACCELEROMETER", "GYROSCOPE", "MAGNETIC_FIELD", "ROTATION_VECTOR",
         "GYROSCOPE_UNCALIBRATED", "MAGNETIC_FIELD_UNCALIBRATED"]


def git(repository, *arguments):
    return subprocess.run(["git", "-C", repository, *arguments], check=True,
                          capture_output=True).stdout


def recordings(repository, known):
    """(blob, name) by floor, the longest first."""
    floors = {}
    for line in git(repository, "ls-tree", "-r", "-l", "HEAD").decode().splitlines():
        meta, path = line.split("\t")
        parts, (_, _, blob, size) = path.split("/"), meta.split()
        if "path_data_files" not in parts or not path.endswith(".txt") or not size.isdigit():
            continue
        name = parts[-1][:-4]
        if name not in known:
            floors.setdefault(f"{parts[1]}_{parts[2]}", []).append((int(size), name, blob))
    return {floor: sorted(files, reverse=True) for floor, files in sorted(floors.items())}


def read(text):
    """Readings by kind, and waypoints: (ms, x, y, ...)."""
    data, waypoints = {kind: [] for kind in KINDS}, []
    for line in text.splitlines():
        fields = line.split("\t")
        if line.startswith("#") or len(fields) < 4:
            continue
        kind = fields[1].removeprefix("TYPE_")
        if kind in data and len(fields) >= 5:
            data[kind].append((int(fields[0]), *map(float, fields[2:5])))
        elif kind == "WAYPOINT":
            waypoints.append((int(fields[0]), *map(float, fields[2:4])))
    return data, waypoints


def convert(text, out):
    """Each row is an acceleration with the latest reading of every other kind."""
    data, waypoints = read(text)
    if len(waypoints) < 2 or any(len(data[kind]) < 500 for kind in KINDS[:3]):
        return
    start = data["ACCELEROMETER"][0][0]
    rows, at = array.array("f"), dict.fromkeys(KINDS, 0)
    for time, *_ in data["ACCELEROMETER"]:
        rows.append((time - start) / 1000.0)
        for kind in KINDS:
            series, i = data[kind], at[kind]
            while i + 1 < len(series) and series[i + 1][0] <= time:
                i += 1
            at[kind] = i
            near = series and abs(series[i][0] - time) < 200
            rows.extend(series[i][1:] if near else [float("nan")] * 3)
    header = struct.pack("<4siq", b"F32 ", 19, len(data["ACCELEROMETER"]))
    with gzip.GzipFile(f"{out}.f32.gz", "wb", mtime=0) as file:
        file.write(header + rows.tobytes())
    lines = [f"{(t - start) / 1000.0:.3f},{x:.5f},{y:.5f}" for t, x, y in waypoints]
    pathlib.Path(f"{out}.waypoints.csv").write_text("\n".join(["# t_s,x_m,y_m", *lines]) + "\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("repository")
    parser.add_argument("out", type=pathlib.Path)
    parser.add_argument("--known", type=pathlib.Path, required=True, help="the folder pdr/loc20")
    arguments = parser.parse_args()
    known = {f.name.split("_")[-1].split(".")[0] for f in arguments.known.glob("*.waypoints.csv")}
    for floor, files in recordings(arguments.repository, known).items():
        first = sorted(files[:8], key=lambda f: f[1])
        sets = {"chosen": first[0::2], "aside": first[1::2], "more": files[8:18]}
        for name, walks in sets.items():
            (arguments.out / name).mkdir(parents=True, exist_ok=True)
            for _, walk, blob in walks:
                text = git(arguments.repository, "cat-file", "blob", blob).decode(errors="replace")
                convert(text, arguments.out / name / f"{floor}_{walk}")


if __name__ == "__main__":
    main()
