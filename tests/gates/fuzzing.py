"""Fuzz targets, each for five minutes from the corpus that earlier runs left in the gate's folder."""

import re
import time

import builds
from running import Step, Stopped
from tree import ROOT, digest_of_file

SECONDS = 300
SANITIZER = re.compile(r"ERROR: \w+Sanitizer[^\n]*|ERROR: libFuzzer[^\n]*|runtime error:[^\n]*")
CAPTURES = ("ti", "ti_config", "rplidar", "xsens")  # whose seeds are cut from recordings


def check(run):
    build = run.folder / "build"
    builds.configure(run, "-DCMAKE_CXX_COMPILER=clang++", "-DCMAKE_BUILD_TYPE=Release", "-DWAYFARE_BUILD_FUZZERS=ON",
                     "-DWAYFARE_BUILD_EXAMPLES=OFF", "-DWAYFARE_BUILD_BENCHMARKS=OFF",
                     f"-DWAYFARE_DATA_DIR={run.data or ''}", folder=build)
    listed = run.command(["ninja", "-C", build, "-t", "targets", "all"])[1]
    targets = sorted(set(re.findall(r"^fuzz_(?!io\b|decode\b)(\w+): phony", listed, re.MULTILINE)))
    if not targets:
        raise Stopped("targets", "failed", "there are none")
    builds.build(run, *(f"fuzz_{t}" for t in targets), folder=build)
    steps = []
    for target in targets:
        program, corpus = build / "bin" / f"fuzz_{target}", run.folder / "corpus" / target
        corpus.mkdir(parents=True, exist_ok=True)
        found = run.folder / f"finding_{target}_"
        options = [f"-max_total_time={SECONDS}", "-print_final_stats=1", f"-artifact_prefix={found}"]
        command = [program, f"-seed={int(time.time())}", "-timeout=10", "-rss_limit_mb=1024", *options, corpus]
        if target in CAPTURES and run.data:
            command = [ROOT / "tests/fuzz/run_on_captures", program, target, run.data, corpus, *options]
        steps.append(Step(target, command, digest_of_file(program), timeout_s=SECONDS + 120, verdict=_verdict))
    run.steps(steps)
    inputs = sum(int(item.note.split()[0]) for item in run.items.values() if item.state == "passed")
    run.figure("inputs", f"{inputs / 1e6:.1f} million")


def _verdict(code, output):
    executed = re.search(r"stat::number_of_executed_units:\s*(\d+)", output)
    finding = SANITIZER.search(output)
    if code != 0 or finding or not executed:
        return "failed", f"{finding[0] if finding else ''}\n{output[-1500:]}".strip()
    covered = re.findall(r"cov: (\d+)", output)
    return "passed", f"{executed[1]} inputs, {covered[-1] if covered else '?'} edges"
