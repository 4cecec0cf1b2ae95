"""Runs the items of a gate, remembering what each depended on and how it ended."""

import concurrent.futures
import dataclasses
import json
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

from tree import ROOT, commit, digest_of, digest_of_files, machine, version_of

STATES = ("passed", "failed", "skipped", "not run")


@dataclasses.dataclass
class Item:
    """One thing that a gate checks: a test, a file, a fuzz target."""

    name: str
    state: str            # one of STATES
    seconds: float = 0.0
    note: str = ""        # the first lines of a finding, or why it was skipped or not run
    digest: str = ""      # of all it depends on


@dataclasses.dataclass(frozen=True)
class Gate:
    name: str
    title: str
    inputs: tuple         # paths of the tree
    check: object         # check(run): adds items and figures to the run
    tools: tuple = ()     # programs it needs
    packages: str = ""    # Debian packages that have them


@dataclasses.dataclass
class Step:
    """A command that is one item."""

    name: str
    command: list
    digest: str
    timeout_s: float = 900
    environment: dict = dataclasses.field(default_factory=dict)
    folder: Path = ROOT
    verdict: object = None  # verdict(code, output): (state, note); by the exit code where there is none


@dataclasses.dataclass
class Result:
    gate: Gate
    items: dict
    figures: dict
    commit: str = ""
    key: str = ""
    seconds: float = 0.0
    ended: str = ""
    machine: str = ""

    def count(self, state):
        return sum(item.state == state for item in self.items.values())

    def passed(self):
        return bool(self.items) and not self.count("failed") and not self.count("not run")

    def verdict(self):
        if self.count("failed"):
            return "FAILED"
        if not self.items:
            return "not run"
        return "incomplete" if self.count("not run") else "passed"

    def line(self):
        counts = ", ".join(f"{self.count(s)} {s}" for s in STATES if self.count(s) or s == "passed")
        figures = "".join(f"; {name} {value}" for name, value in self.figures.items())
        return f"{self.verdict()}: {counts}{figures}"


def remembered(gate, folder):
    """The result that the folder has of a gate, at whatever commit."""
    result = Result(gate, {}, {})
    if (folder / "items.jsonl").is_file():
        for line in (folder / "items.jsonl").read_text(encoding="utf-8").splitlines():
            try:
                item = Item(**json.loads(line))
            except (ValueError, TypeError):
                continue  # the last line of an interrupted check
            result.items[item.name] = item
    if (folder / "result.json").is_file():
        said = json.loads((folder / "result.json").read_text(encoding="utf-8"))
        for name, value in said.items():
            setattr(result, name, value)
    return result


class Stopped(Exception):
    """A gate cannot go on: the item that says why."""

    def __init__(self, name, state, note):
        super().__init__(name)
        self.item = Item(name, state, note=note)


class Run:
    """One run of a gate. What a check needs: folder, jobs, data, log(), steps(), keep(), figure()."""

    def __init__(self, gate, folder, minutes, jobs, again, data):
        self.gate, self.folder, self.jobs, self.again, self.data = gate, folder, jobs, again, data
        self.began = time.monotonic()
        self.before = remembered(gate, folder)
        self.deadline = self.began + 60 * minutes
        self.items, self.figures = {}, {}
        folder.mkdir(parents=True, exist_ok=True)
        self.log_file = folder / "log.txt"
        self.record = None

    def result(self):
        key = digest_of(digest_of_files(*self.gate.inputs), *map(version_of, self.gate.tools), self.data)
        same = key == self.before.key
        if same and self.before.passed() and not self.again:
            print(f"   has passed for these inputs at {self.before.commit}")
            return self.before
        absent = [t for t in self.gate.tools if not version_of(t)]
        self.log_file.write_text("", encoding="utf-8")
        with open(self.folder / "items.jsonl", "a", encoding="utf-8") as self.record:
            if absent:
                self.keep(Item("tools", "not run", note=f"needs {', '.join(absent)} (Debian: {self.gate.packages})"))
            else:
                try:
                    self.gate.check(self)
                except Stopped as stopped:
                    self.keep(stopped.item)
        seconds = time.monotonic() - self.began + (self.before.seconds if same and not self.again else 0)
        # What earlier runs of other inputs passed is not run again, but has taken its time.
        seconds = max(seconds, sum(item.seconds for item in self.items.values()) / self.jobs)
        result = Result(self.gate, self.items, self.figures, commit(), key, seconds,
                        time.strftime("%Y-%m-%d %H:%M"), machine())
        self._write(result)
        return result

    def _write(self, result):
        lines = [json.dumps(dataclasses.asdict(i)) + "\n" for i in result.items.values()]
        (self.folder / "items.new").write_text("".join(lines), encoding="utf-8")
        os.replace(self.folder / "items.new", self.folder / "items.jsonl")
        said = {name: getattr(result, name) for name in ("figures", "commit", "key", "seconds", "ended", "machine")}
        (self.folder / "result.json").write_text(json.dumps(said, indent=1), encoding="utf-8")

    def keep(self, item):
        """Records how an item ended, at once: an interrupted check loses nothing."""
        self.items[item.name] = item
        self.record.write(json.dumps(dataclasses.asdict(item)) + "\n")
        self.record.flush()
        if item.state == "failed":
            print(f"   failed: {item.name}  {item.note.splitlines()[0] if item.note else ''}", flush=True)

    def keep_passed(self, name, digest):
        """Whether the item has passed, or was skipped, with this digest before; then it is kept."""
        item = self.before.items.get(name)
        if self.again or not item or item.digest != digest or item.state not in ("passed", "skipped"):
            return False
        self.items[name] = item
        return True

    def figure(self, name, value):
        self.figures[name] = value

    def log(self, text):
        with open(self.log_file, "a", encoding="utf-8", errors="replace") as file:
            file.write(text.rstrip() + "\n")

    def seconds_left(self):
        return max(0.0, self.deadline - time.monotonic())

    def command(self, words, timeout_s=None, environment=None, folder=ROOT, on_line=None):
        """Runs a command to its end or the timeout, with all it started: (exit code, output); the code
        is None where it took too long."""
        words = [str(w) for w in words]
        timeout_s = min(timeout_s or 1e9, self.seconds_left())
        process = subprocess.Popen(words, cwd=folder, env=os.environ | (environment or {}), text=True,
                                   errors="replace", stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                                   stdin=subprocess.DEVNULL, start_new_session=True)

        def end():
            try:
                os.killpg(process.pid, signal.SIGKILL)
            except ProcessLookupError:
                pass

        late = []
        with concurrent.futures.ThreadPoolExecutor(1) as watch:
            def guard():
                try:
                    process.wait(timeout_s)
                except subprocess.TimeoutExpired:
                    late.append(True)
                    end()
            watch.submit(guard)
            output = []
            try:
                for line in process.stdout:
                    output.append(line)
                    if on_line:
                        on_line(line.rstrip("\n"))
            except BaseException:
                end()
                raise
        process.wait()
        text = "".join(output)
        self.log(f"$ {' '.join(words)}\n{text[-200000:]}")
        return None if late else process.returncode, text

    def steps(self, steps):
        """Runs the steps that have not passed, several at a time, and keeps an item for each."""
        left = [s for s in steps if not self.keep_passed(s.name, s.digest)]
        progress = Progress(len(left))

        def run(step):
            if self.seconds_left() < 1:
                return Item(step.name, "not run", note="no time was left")
            began = time.monotonic()
            allowed = min(step.timeout_s, self.seconds_left())
            code, output = self.command(step.command, allowed, step.environment, step.folder)
            seconds = time.monotonic() - began
            if code is None and allowed < step.timeout_s:
                return Item(step.name, "not run", seconds, "no time was left")
            if code is None:
                return Item(step.name, "failed", seconds, f"not ended after {allowed:.0f} s", step.digest)
            state, note = (step.verdict or by_code)(code, output)
            return Item(step.name, state, seconds, note, step.digest)

        with concurrent.futures.ThreadPoolExecutor(self.jobs) as pool:
            for future in concurrent.futures.as_completed([pool.submit(run, s) for s in left]):
                self.keep(future.result())
                progress.count()
        progress.end()


def by_code(code, output):
    """Failed with what was said from the first error on, or last."""
    if code == 0:
        return "passed", ""
    error = re.search(r"^.*\b(error|Error|FAILED|failed)\b", output, re.MULTILINE)
    return "failed", (output[error.start():][:1500] if error else output[-1500:]) + f"\nexit code {code}"


class Progress:
    """A line with the share done and the time remaining, on a terminal alone."""

    def __init__(self, total):
        self.total, self.done, self.began, self.shown = total, 0, time.monotonic(), 0.0

    def count(self):
        self.done += 1
        now = time.monotonic()
        if sys.stdout.isatty() and now - self.shown > 0.5:
            self.shown = now
            remaining = (now - self.began) / self.done * (self.total - self.done)
            print(f"\r   {self.done} of {self.total}, about {remaining / 60:.0f} min left   ", end="", flush=True)

    def end(self):
        if sys.stdout.isatty() and self.shown:
            print("\r" + " " * 60 + "\r", end="", flush=True)
