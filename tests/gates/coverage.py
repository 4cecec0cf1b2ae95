"""Lines and branches that the tests ran, by Clang's counters in the sources.

A line of a header counts as run where any translation unit ran it; a branch is one outcome of a condition,
which counts as run where any instance of its template ran it. Conditions of constants have none.
"""

import collections
import json
import os
import pathlib
import subprocess

from running import Item
from tree import ROOT, digest_of

OURS = ("include/wayfare/", "src/")
LINES, BRANCHES = 93.0, 80.0  # percent
# Nobody reads counters in Eigen, and they would take most of the time of optimised code.
FLAGS = f"-fprofile-instr-generate -fcoverage-mapping -fprofile-list={pathlib.Path(__file__).resolve().parent}/counted_sources"
# Counters of kernels are in no section group: the linker may not take them for unused.
LINKING = "-Wl,-z,nostart-stop-gc"


def environment(folder):
    """Each program adds to one file of its own, whatever the number of runs."""
    return {"LLVM_PROFILE_FILE": str(folder / "profiles" / "%m.profraw")}


def read_counts(build):
    """{file: (lines {number: runs}, branches {(place, outcome): runs})} of the programs of a build."""
    raw = sorted((build / "profiles").glob("*.profraw"))
    if not raw:
        return {}
    merged = build / "profiles" / "all.profdata"
    _tool("llvm-profdata", "merge", "-sparse", "--failure-mode=all", *raw, "-o", merged)
    programs = sorted(p for p in (build / "bin").iterdir() if p.is_file() and os.access(p, os.X_OK))
    objects = [word for p in programs for word in ("-object", p)]
    exported = json.loads(_tool("llvm-cov", "export", "-instr-profile", merged, "-skip-functions",
                                "-skip-expansions", *objects[1:]))
    counts = {}
    for file in exported["data"][0]["files"]:
        name = os.path.relpath(file["filename"], ROOT)
        if name.startswith(OURS):
            branches = collections.Counter()
            for branch in file["branches"]:
                branches[(*branch[:4], True)] += branch[4]
                branches[(*branch[:4], False)] += branch[5]
            counts[name] = (_lines(file["segments"]), branches)
    return counts


def _lines(segments):
    """Runs of each line: of the most frequent region that begins on it or reaches into it."""
    by_line = collections.defaultdict(list)
    for segment in segments:
        by_line[segment[0]].append(segment)
    counts, before = {}, None
    for number in range(min(by_line, default=0), max(by_line, default=-1) + 1):
        here = by_line.get(number, [])
        begins = [s[2] for s in here if s[3] and s[4] and not s[5]]
        reaches = before is not None and before[3]
        left_out = here and not here[0][3] and here[0][4]
        if (begins or reaches) and not left_out:
            counts[number] = max([*begins, before[2] if reaches else 0])
        before = here[-1] if here else before
    return counts


def check(run):
    """Of the programs and runs of the gate `address`."""
    counts = read_counts(run.folder.parent / "address")
    if not counts:
        run.keep(Item("profiles", "not run", note="the gate address has to run before"))
        return
    (run.folder / "missing.txt").write_text(_missing(counts), encoding="utf-8")
    table = _table(counts)
    (run.folder / "table.txt").write_text(
        "\n".join(f"{f:28} {l:6.1f} {b:6.1f}" for f, l, b in table) + "\n", encoding="utf-8")
    run.log((run.folder / "table.txt").read_text(encoding="utf-8"))
    _, lines, branches = table[-1]
    for name, value, least in (("lines", lines, LINES), ("branches", branches, BRANCHES)):
        run.figure(name, f"{value:.1f} %")
        run.keep(Item(name, "passed" if value >= least else "failed", note=f"{value:.2f} %, least {least} %",
                      digest=digest_of(value)))


def _table(counts):
    """(folder, % of lines, % of branches), the last for all."""
    sums = collections.defaultdict(lambda: [0, 0, 0, 0])
    for name, measures in counts.items():
        for folder in (str(pathlib.PurePath(name).parent), "~all"):
            for k, measure in enumerate(measures):
                sums[folder][2 * k] += sum(runs > 0 for runs in measure.values())
                sums[folder][2 * k + 1] += len(measure)
    return [(folder.strip("~"), 100 * a / max(b, 1), 100 * c / max(d, 1)) for folder, (a, b, c, d) in sorted(sums.items())]


def _missing(counts):
    rows = []
    for name, (lines, branches) in sorted(counts.items()):
        never = [n for n, runs in sorted(lines.items()) if runs == 0]
        half = sorted({place[:2] for place, runs in branches.items() if runs == 0 and place[0] not in never})
        rows.append(f"{name}: {sum(r > 0 for r in lines.values())} of {len(lines)} lines, "
                    f"{sum(r > 0 for r in branches.values())} of {len(branches)} branches")
        if never:
            rows.append("  lines not run: " + " ".join(map(str, never)))
        if half:
            rows.append("  conditions with one outcome: " + " ".join(f"{line}:{column}" for line, column in half))
    return "\n".join(rows) + "\n"


def _tool(name, *words):
    return subprocess.run([name, *map(str, words)], capture_output=True, text=True, check=True).stdout
