"""Runs cases, several at a time, and takes the digests of what they wrote."""

import concurrent.futures
import json
import os
import re
import resource
import shlex
import shutil
import subprocess
from dataclasses import dataclass, field
from pathlib import Path

import digest

TEXTS = ("stdout", "stderr", ".txt", ".json", ".md")


@dataclass(frozen=True)
class Settings:
    programs: Path
    data: Path
    inputs: Path
    work: Path
    timeout_s: float


@dataclass
class CaseResult:
    name: str
    failures: list = field(default_factory=list)
    outputs: dict = field(default_factory=dict)
    cpu_s: float = 0.0


def environment():
    """No colours, no other languages, one thread where a library would take all cores."""
    keep = {k: v for k, v in os.environ.items() if k in ("PATH", "HOME", "TMPDIR", "LD_LIBRARY_PATH")}
    return keep | {"LC_ALL": "C.UTF-8", "TZ": "UTC", "OMP_NUM_THREADS": "1",
                   "OPENBLAS_NUM_THREADS": "1"}


def resolved(word, case, settings):
    places = {"data": settings.data, "inputs": settings.inputs, "out": settings.work / case.name}

    def place(match):
        name, other = match.groups()
        return str(settings.work / other if other else places[name])

    return re.sub(r"\{(data|inputs|out)(?::([\w-]+))?\}", place, word)


def _cpu_s():
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def run_case(case, settings):
    """Runs the case's commands in order; their streams become files beside their outputs."""
    result = CaseResult(case.name)
    folder = settings.work / case.name
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    began = _cpu_s()
    streams = {"stdout": b"", "stderr": b""}
    for i, command in enumerate(case.commands):
        words = [resolved(w, case, settings) for w in shlex.split(command)]
        last = i + 1 == len(case.commands)
        try:
            program = (settings.inputs.parent if "/" in words[0] else settings.programs) / words[0]
            done = subprocess.run([program, *words[1:]], cwd=folder,
                                  env=environment(), stdin=subprocess.DEVNULL, capture_output=True,
                                  timeout=settings.timeout_s, check=False)
        except FileNotFoundError:
            result.failures.append(f"there is no program {words[0]}")
            break
        except subprocess.TimeoutExpired:
            result.failures.append(f"{words[0]} took more than {settings.timeout_s:g} s")
            break
        streams["stdout"] += done.stdout
        streams["stderr"] += done.stderr
        if done.returncode != (case.exit if last else 0):
            error = done.stderr.decode(errors="replace").strip().splitlines()
            result.failures.append(f"{words[0]} ended with {done.returncode}: {' '.join(error[-1:])}")
            break
    result.cpu_s = _cpu_s() - began
    for name, content in streams.items():
        (folder / name).write_bytes(content)
    places = {"inputs": str(settings.inputs), "data": str(settings.data), "out": str(settings.work),
              "bin": str(settings.programs)}
    for path in sorted(p for p in folder.rglob("*") if p.is_file()):
        name = str(path.relative_to(folder))
        if name in streams:
            text = streams[name].decode(errors="replace")
            found = digest.of_text(text, places, case.varies)
            if found.size == 0:
                continue
        else:
            found = digest.of_file(path, places, case.varies)
        result.outputs[name] = found
    return result


def in_parallel(selected, settings, jobs, costs):
    """Yields the results as cases end; a case begins once those it needs have ended."""
    waiting = sorted(selected, key=lambda c: -costs.get(c.name, 2.0))
    finished, running = set(), {}
    # A process each, as taking digests is work too; CPU time is then that of the case's children.
    with concurrent.futures.ProcessPoolExecutor(jobs) as pool:
        try:
            while waiting or running:
                ready = [c for c in waiting if set(c.needs) <= finished]
                for case in ready[:jobs - len(running)]:
                    waiting.remove(case)
                    running[pool.submit(run_case, case, settings)] = case
                done, _ = concurrent.futures.wait(
                    running, return_when=concurrent.futures.FIRST_COMPLETED)
                for future in done:
                    finished.add(running.pop(future).name)
                    yield future.result()
        finally:
            pool.shutdown(wait=False, cancel_futures=True)


def _times_file(programs):
    return programs.resolve().parent / "golden_times.json"


def load_times(programs):
    """CPU seconds of the cases when they last ran with these programs; none where they did not."""
    try:
        return json.loads(_times_file(programs).read_text())
    except (OSError, ValueError):
        return {}


def save_times(programs, times):
    try:
        _times_file(programs).write_text(
            json.dumps(load_times(programs) | times, indent=1, sort_keys=True) + "\n")
    except OSError:
        pass  # the folder is not ours: times are only for the time remaining


def minutes(seconds):
    return f"{int(seconds) // 60}:{int(seconds) % 60:02}"


def first_different(expected, found):
    for i, (a, b) in enumerate(zip(expected, found)):
        if a != b:
            return f"number {i + 1} of {len(expected)} was {a}, is {b}"
    return f"had {len(expected)} numbers, has {len(found)}"


def first_difference_of_files(expected, found):
    old, new = expected.read_bytes(), found.read_bytes()
    if b"\0" in old[:4096]:
        at = next((i for i, (a, b) in enumerate(zip(old, new)) if a != b), min(len(old), len(new)))
        return f"byte {at} of {len(old)} first"
    old, new = (t.decode(errors="replace").splitlines() for t in (old, new))
    for i, (a, b) in enumerate(zip(old, new)):
        if a != b:
            where = first_different(digest.NUMBER.findall(a), digest.NUMBER.findall(b))
            return f"line {i + 1} of {len(old)} first: {where}"
    return f"had {len(old)} lines, has {len(new)}"
