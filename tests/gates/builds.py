"""Builds of the whole tree and their tests, by CMake and CTest."""

import dataclasses
import json
import os
import re
import subprocess
from pathlib import Path

from running import Item, Progress, Stopped
from tree import ROOT, digest_of, digest_of_file, digest_of_files

# "  12/3800 Test  #7: name ....   Passed    0.05 sec", "***Failed", "***Timeout", "***Exception: SegFault"; the
# names of typed tests have spaces, and a reason may have several lines, the last with the time.
TEST = re.compile(r"^\s*\d+/\d+ Test\s+#(\d+): .*?(Passed|\*\*\*.*?)(?:\s+([\d.]+) sec)?$")
SKIPPED = re.compile(r"^(\d+): (?:.*: Skipped\n\1: |skipped: )(.+)$", re.MULTILINE)
FINDING = re.compile(r"runtime error:|ERROR: \w+Sanitizer|WARNING: ThreadSanitizer|: Failure$|Assertion|"
                     r"Error: attempt to|terminate called|definitely lost")
# What scripts among the tests may read.
SCRIPT_INPUTS = ("CMakeLists.txt", "cmake", "docs", "examples", "include", "README.md", "src", "tests")


def configure(run, *options, folder=None, source=ROOT):
    """Configures a folder of the gate; the gate stops where that fails."""
    launcher = ["-DCMAKE_CXX_COMPILER_LAUNCHER=ccache"] if _has("ccache") else []
    code, output = run.command(["cmake", "-S", source, "-B", folder or run.folder, "-G", "Ninja", *launcher, *options])
    if code != 0:
        raise Stopped("configure", "not run" if code is None else "failed", output[-1500:])


def tree_options(run, flags, *options, scans=1000, examples=True):
    """Options of a build of everything but the benchmarks. Libraries have the flags, programs and most tests
    are not optimised, as in ./run test."""
    return ["-DCMAKE_BUILD_TYPE=Release", f"-DCMAKE_CXX_FLAGS_RELEASE={flags}", "-DWAYFARE_BUILD_TESTS=ON",
            f"-DWAYFARE_BUILD_EXAMPLES={'ON' if examples else 'OFF'}", "-DWAYFARE_BUILD_BENCHMARKS=OFF",
            "-DWAYFARE_FAST_BUILD=ON", "-DWAYFARE_PROGRAM_OPTIONS=-O0", f"-DWAYFARE_TEST_SCANS={scans}",
            f"-DWAYFARE_DATA_DIR={run.data or ''}", *options]


def build(run, *targets, folder=None):
    """Builds as much as compiles; the gate stops where something does not, with an item for each such file."""
    words = ["cmake", "--build", folder or run.folder, "--parallel", run.jobs]
    code, output = run.command([*words, *(["--target", *targets] if targets else []), "--", "-k", "0"])
    if code is None:
        raise Stopped("build", "not run", "no time was left")
    if code != 0:
        first = next((line for line in output.splitlines() if " error: " in line), output[-800:])
        for name in re.findall(r"^FAILED: (\S+)", output, re.MULTILINE)[:20]:
            run.keep(Item(name, "failed", note=first))
        raise Stopped("build", "failed", first)


def test(run, folder=None, environment=None, select=".", exclude=None, timeout_s=900, jobs=None, places=None):
    """Runs the tests of a build that have not passed with the same program, by CTest: of the folders `places`
    and those below, or of all. Tests whose names match exclude, {pattern: reason}, are listed as skipped."""
    folder = folder or run.folder
    listed = subprocess.run(["ctest", "--test-dir", folder, "--show-only=json-v1"], capture_output=True,
                            text=True, check=True).stdout
    scripts = digest_of_files(*SCRIPT_INPUTS)
    digests, numbers, programs = {}, {}, {}
    for number, entry in enumerate(json.loads(listed)["tests"], start=1):
        name = entry["name"]
        if not re.search(select, name) or places and not _is_below(_place_of(entry, folder), places):
            continue
        if name.endswith("_NOT_BUILT"):
            run.keep(Item(name, "failed", note="was not built"))
            continue
        reason = next((why for pattern, why in (exclude or {}).items() if re.search(pattern, name)), None)
        if reason:
            run.keep(Item(name, "skipped", note=reason))
            continue
        digests[name] = _digest_of_test(entry, scripts)
        if not run.keep_passed(name, digests[name]):
            numbers[name] = number
            programs[name] = not Path(entry.get("command", [""])[0]).name.startswith("test_")
    progress = Progress(len(numbers))
    failed, notes, last = {}, {}, None
    names = {number: name for name, number in numbers.items()}

    def on_line(line):
        nonlocal last
        found = TEST.match(line)
        if not found and last and FINDING.search(line):
            notes.setdefault(last, line.strip())  # what a failed test said follows its line
        if not found or int(found[1]) not in names:  # or a fixture that has passed before
            return
        last, said = names[int(found[1])], found[2]
        progress.count()
        item = Item(last, "passed", float(found[3] or 0), said.strip("* "), digests[last])
        if said.endswith("Passed"):
            run.keep(dataclasses.replace(item, note=""))
        elif "Skipped" in said or "Disabled" in said:
            run.keep(dataclasses.replace(item, state="skipped"))
        else:
            failed[last] = dataclasses.replace(item, state="failed")

    # CTest begins with what took longest: unit tests before programs, so that little is left where time is short.
    for is_program in (False, True):
        chosen = [str(number) for name, number in numbers.items() if programs[name] == is_program]
        if not chosen or run.seconds_left() < 1:
            continue
        (folder / "tests_left.txt").write_text("0,0,0," + ",".join(chosen) + "\n", encoding="utf-8")
        run.command(["ctest", "--test-dir", folder, "-j", jobs or run.jobs, "--timeout", timeout_s,
                     "--output-on-failure", "-I", folder / "tests_left.txt"], environment=environment, on_line=on_line)
    progress.end()
    for item in failed.values():
        run.keep(dataclasses.replace(item, note=f"{notes.get(item.name, '')}\n{item.note}".strip()))
    skipped = {numbers[n]: n for n in numbers if n in run.items and run.items[n].note == "Skipped"}
    for number, reason in _reasons(run, folder, skipped, environment).items():
        run.keep(dataclasses.replace(run.items[skipped[number]], note=reason))
    for name in numbers:
        if name not in run.items:
            run.keep(Item(name, "not run", note="no time was left"))


def _reasons(run, folder, numbers, environment):
    """{number: why} of tests that skip themselves, which CTest does not show unless asked."""
    if not numbers:
        return {}
    (folder / "tests_left.txt").write_text("0,0,0," + ",".join(map(str, numbers)) + "\n", encoding="utf-8")
    output = run.command(["ctest", "--test-dir", folder, "-V", "-I", folder / "tests_left.txt"], environment=environment)[1]
    return {int(found[1]): found[2] for found in SKIPPED.finditer(output)}


def _place_of(entry, folder):
    """The folder of a test, relative to that of the build."""
    place = next((p["value"] for p in entry.get("properties", ()) if p["name"] == "WORKING_DIRECTORY"), folder)
    return os.path.relpath(place, folder)


def _is_below(place, places):
    return any(place == p or place.startswith(p + "/") for p in places)


def _digest_of_test(entry, scripts):
    """Of the programs a test starts and its words; a script may read anything of the tree."""
    words = entry.get("command", [])
    parts = list(words)
    for number, word in enumerate(words):
        if os.path.isabs(word) and os.path.isfile(word) and (number == 0 or os.access(word, os.X_OK)):
            parts.append(digest_of_file(word))
    if not words or Path(words[0]).name.startswith(("cmake", "ctest", "sh")) or ".sh" in words[0]:
        parts.append(scripts)
    return digest_of(*parts)


def _has(program):
    return any((Path(p) / program).is_file() for p in os.environ.get("PATH", "").split(os.pathsep))
