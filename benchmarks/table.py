#!/usr/bin/env python3
"""Prints the JSON files of Google Benchmark as one table with ratios.

A benchmark is called task/who or task/who/arguments. Rows of the same task and arguments are
grouped; the ratio is a row's time over that of the first row whose `who` begins with `wayfare`, so
50 means that wayfare is fifty times faster, and below one that it is slower. Repetitions are
represented by their median.
"""

import json
import sys

NANOSECONDS = {"ns": 1.0, "us": 1e3, "ms": 1e6, "s": 1e9}


def read_rows(path):
    """Yields (task and arguments, who, nanoseconds, other counters) of one file."""
    with open(path, encoding="utf-8") as file:
        content = json.load(file)
    medians = {b["run_name"] for b in content["benchmarks"] if b.get("aggregate_name") == "median"}
    seen = set()
    for row in content["benchmarks"]:
        name = row.get("run_name", row["name"])
        if "error_occurred" in row and row["error_occurred"]:
            print(f"{name}: {row.get('error_message', 'failed')}", file=sys.stderr)
            continue
        if name in medians and row.get("aggregate_name") != "median" or name in seen:
            continue
        seen.add(name)
        task, _, rest = name.partition("/")
        who, _, arguments = rest.partition("/")
        time_ns = row["real_time"] * NANOSECONDS[row["time_unit"]]
        yield (f"{task} {arguments}".strip(), who, time_ns, row.get("label", ""))


def human(time_ns):
    """A time with three digits and its unit."""
    for unit in ("s", "ms", "us"):
        if time_ns >= NANOSECONDS[unit]:
            return f"{time_ns / NANOSECONDS[unit]:.3g} {unit}"
    return f"{time_ns:.3g} ns"


def main(paths):
    """Prints the table of all files together; returns the exit status."""
    if not paths:
        print("usage: table.py FILE.json...", file=sys.stderr)
        return 2
    groups = {}
    for path in paths:
        for task, who, time_ns, label in read_rows(path):
            groups.setdefault(task, []).append((who, time_ns, label))
    lines = [("task", "who", "time", "ratio", "")]
    for task, rows in groups.items():
        base = next((time_ns for who, time_ns, _ in rows if who.startswith("wayfare")), None)
        for who, time_ns, label in rows:
            ratio = "" if base is None else f"{time_ns / base:.2f}"
            lines.append((task, who, human(time_ns), ratio, label))
            task = ""
    widths = [max(len(line[i]) for line in lines) for i in range(4)]
    for task, who, time, ratio, label in lines:
        row = f"{task:<{widths[0]}}  {who:<{widths[1]}}  {time:>{widths[2]}}  {ratio:>{widths[3]}}"
        print(f"{row}  {label}".rstrip())
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
