#!/usr/bin/env python3
"""Lines that the tests ran, by folder, from a build with --preset coverage.

    cmake --preset coverage && cmake --build --preset coverage && ctest --preset coverage
    tests/coverage.py build/coverage [--missing FOLDER]

A line of a header counts as run where any translation unit ran it. --missing lists, for the files
in a folder such as src/io, the lines that nothing ran. Needs only gcov, which comes with GCC.
"""

import argparse
import collections
import json
import pathlib
import subprocess

ROOT = pathlib.Path(__file__).resolve().parent.parent
OURS = ("include/", "src/", "examples/", "benchmarks/accuracy/")


def read_counts(build):
    """{file relative to the tree: {line: times run}}"""
    counts = collections.defaultdict(lambda: collections.defaultdict(int))
    for data in sorted(pathlib.Path(build).resolve().rglob("*.gcda")):
        gcov = ["gcov", "--json-format", "--stdout", "--relative-only", "--source-prefix", ROOT]
        text = subprocess.run([*gcov, data], capture_output=True, check=True, cwd=build).stdout
        for unit in text.splitlines():
            for source in json.loads(unit)["files"] if unit.strip() else []:
                name = source["file"].removeprefix(f"{ROOT}/")
                if name.startswith(OURS):
                    for line in source["lines"]:
                        counts[name][line["line_number"]] += line["count"]
    return counts


def print_table(counts):
    folders = collections.defaultdict(lambda: [0, 0])
    for name, lines in counts.items():
        run = sum(count > 0 for count in lines.values())
        for folder in (str(pathlib.PurePath(name).parent), "all"):
            folders[folder][0] += run
            folders[folder][1] += len(lines)
    print(f"{'folder':32} {'lines':>6} {'run':>6} {'%':>6}")
    for folder, (run, lines) in sorted(folders.items(), key=lambda f: (f[0] == "all", f[0])):
        print(f"{folder:32} {lines:6} {run:6} {100 * run / lines:6.1f}")


def print_missing(counts, folder):
    for name in sorted(counts):
        missing = sorted(n for n, count in counts[name].items() if count == 0)
        if name.startswith(folder) and missing:
            print(f"{name}: {' '.join(map(str, missing))}")


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("build", help="the build folder, build/coverage")
    parser.add_argument("--missing", metavar="FOLDER", help="list the lines not run in it")
    arguments = parser.parse_args()
    counts = read_counts(arguments.build)
    if not counts:
        raise SystemExit(f"{arguments.build}: no coverage data; run the tests there first")
    if arguments.missing:
        print_missing(counts, arguments.missing)
    else:
        print_table(counts)


if __name__ == "__main__":
    main()
