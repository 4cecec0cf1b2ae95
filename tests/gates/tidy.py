"""clang-tidy on every translation unit: sources of libraries one by one, so that the static analyzer follows
their paths, the others eight of a target at a time."""

import json
import re
import shlex

import builds
from headers import HERE
from running import Item, Step, Stopped
from tree import ROOT, digest_of, digest_of_file, digest_of_unit, version_of

INCLUDED = re.compile(r'#include "([^"]+\.cpp)"')
OPTIONS = ("-DCMAKE_CXX_COMPILER=clang++", "-DCMAKE_BUILD_TYPE=Debug", "-DCMAKE_EXPORT_COMPILE_COMMANDS=ON",
           "-DWAYFARE_DATA_DIR=")
UNITED = ("-DCMAKE_UNITY_BUILD=ON", "-DCMAKE_UNITY_BUILD_BATCH_SIZE=8")
GENERATED = "tests/ros2/peer/"  # includes what Fast DDS' generator writes
# Outside the libraries: programs end and start threads in one place, small programs and tests are read rather
# than profiled, and the frameworks' idioms are reported (`for (auto _ : state)`, functors of solvers).
OUTSIDE = ("-performance-*", "-concurrency-mt-unsafe", "-modernize-use-nodiscard", "-modernize-use-emplace",
           "-bugprone-exception-escape", "-clang-analyzer-deadcode.DeadStores", "-clang-analyzer-cplusplus.NewDeleteLeaks",
           "-readability-non-const-parameter", "-bugprone-suspicious-missing-comma")
OTHER_KERNELS = re.compile(r"_avx(2|512)\.dir/")  # the same source as its baseline


def check(run):
    plugin = _plugin(run)
    alone = ("src/", "benchmarks/speed/")  # no target of benchmarks/speed is compiled several sources at a time
    units = _units(run, "united", *UNITED, of=lambda place: not place.startswith((*alone, GENERATED)))
    units += _units(run, "single", of=lambda place: place.startswith(alone))
    run.keep(Item(GENERATED, "skipped", note="includes generated code"))
    if not units:
        raise Stopped("units", "failed", "no translation unit was found")
    (run.folder / "compile_commands.json").write_text(json.dumps([unit for unit, _ in units]), encoding="utf-8")
    rules = ((ROOT / ".clang-tidy").read_text(encoding="utf-8"), version_of("clang-tidy"), digest_of_file(plugin))
    steps = []
    for unit, sources in units:
        label = _place(sources[0]) + (f" and {len(sources) - 1} more" if len(sources) > 1 else "")
        checks = ["wayfare-own-code", "-bugprone-suspicious-include", *(() if label.startswith("src/") else OUTSIDE)]
        command = ["clang-tidy", f"--load={plugin}", "--quiet", f"--checks={','.join(checks)}", "-p", run.folder, unit["file"]]
        steps.append(Step(label, command, digest_of(*(digest_of_unit(s) for s in sources), unit["command"], *checks, *rules),
                          timeout_s=600, verdict=_verdict))
    run.figure("sources", len({source for _, sources in units for source in sources}))
    run.steps(steps)


def _plugin(run):
    result = run.folder / "own_code.so"
    headers = run.command(["llvm-config", "--includedir"])[1].strip()
    code, output = run.command(["clang++", "-std=c++17", "-O1", "-fPIC", "-shared", "-fno-rtti", "-isystem", headers,
                                HERE / "own_code.cpp", "-o", result])
    if code != 0:
        raise Stopped("own_code.cpp", "failed", output[-800:])
    return result


def _units(run, name, *options, of):
    """[(entry of the compilation database, its sources)] of a configured folder, of the places wanted."""
    folder = run.folder / name
    builds.configure(run, *OPTIONS, *options, folder=folder)
    result, seen = [], set()
    for unit in json.loads((folder / "compile_commands.json").read_text(encoding="utf-8")):
        file = unit["file"]
        sources = [file]
        if "/Unity/" in file:
            with open(file, encoding="utf-8") as text:
                sources = INCLUDED.findall(text.read())
            if len(sources) == 1:  # as the main file, whose paths the static analyzer follows
                unit = unit | {"file": sources[0], "command": unit["command"].replace(file, shlex.quote(sources[0]))}
        generated = any(s.startswith(str(folder)) for s in sources)
        if not generated and of(_place(sources[0])) and not OTHER_KERNELS.search(unit["command"]) and unit["file"] not in seen:
            seen.add(unit["file"])
            result.append((unit, sources))
    return result


def _place(source):
    return source.removeprefix(f"{ROOT}/")


def _verdict(code, output):
    found = sorted({line for line in output.splitlines() if re.search(r" (error|warning): ", line)})
    return ("passed", "") if code == 0 and not found else ("failed", "\n".join(found) or f"exit code {code}\n{output[-500:]}")
