"""clang-tidy on every translation unit, the sources of a target eight at a time."""

import json
import re

import builds
from running import Item, Step
from tree import ROOT, digest_of, digest_of_unit, version_of

SOURCE = re.compile(r'#include "([^"]+\.cpp)"')


def check(run):
    builds.configure(run, "-DCMAKE_CXX_COMPILER=clang++", "-DCMAKE_BUILD_TYPE=Debug", "-DCMAKE_UNITY_BUILD=ON",
                     "-DCMAKE_UNITY_BUILD_BATCH_SIZE=8", "-DCMAKE_EXPORT_COMPILE_COMMANDS=ON", "-DWAYFARE_DATA_DIR=")
    rules = ((ROOT / ".clang-tidy").read_text(encoding="utf-8"), version_of("clang-tidy"))
    steps, covered = [], set()
    for unit in json.loads((run.folder / "compile_commands.json").read_text(encoding="utf-8")):
        name = unit["file"]
        if name.startswith(str(run.folder)) and "/Unity/" not in name:
            continue  # generated code
        with open(name, encoding="utf-8") as file:
            sources = SOURCE.findall(file.read()) if "/Unity/" in name else [name]
        if re.search(r"_avx(2|512)\.dir/", unit["output"] if "output" in unit else unit["command"]):
            continue  # the same source as its baseline
        covered.update(sources)
        words = [re.sub(r"^.*/(tests|src|examples|benchmarks)/", r"\1/", s) for s in sources]
        label = words[0] + (f" and {len(words) - 1} more" if len(words) > 1 else "")
        steps.append(Step(label, ["clang-tidy", "--quiet", "--checks=-bugprone-suspicious-include", "-p", run.folder, name],
                          digest_of(*(digest_of_unit(s) for s in sources), *rules), timeout_s=600, verdict=_verdict))
    run.figure("sources", len(covered))
    run.steps(steps)
    if not steps:
        run.keep(Item("units", "failed", note="no translation unit was found"))


def _verdict(code, output):
    found = sorted({line for line in output.splitlines() if re.search(r" (error|warning): ", line)})
    return ("passed", "") if code == 0 and not found else ("failed", "\n".join(found) or f"exit code {code}\n{output[-500:]}")
