"""The files of the tree, and digests of what a check depends on."""

import functools
import hashlib
import os
import platform
import re
import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
INCLUDE = re.compile(rb'^\s*#\s*include\s*[<"]([^>"]+)[>"]', re.MULTILINE)


def files(*paths, suffixes=None):
    """Files of the tree below the paths, relative to its root: tracked ones and new ones."""
    listed = subprocess.run(["git", "ls-files", "-co", "--exclude-standard", "-z", "--", *paths], cwd=ROOT,
                            capture_output=True, check=True).stdout.decode().split("\0")
    return sorted(f for f in set(listed) if f and (ROOT / f).is_file()
                  and (not suffixes or f.endswith(tuple(suffixes))))


def digest_of(*parts):
    """Of texts and bytes, in their order."""
    result = hashlib.sha256()
    for part in parts:
        part = part if isinstance(part, bytes) else str(part).encode()
        result.update(len(part).to_bytes(8, "little") + part)
    return result.hexdigest()[:24]


@functools.cache
def _digest_of_file(path, size, changed_ns):
    with open(path, "rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def digest_of_file(path):
    """Read again only where size or time have changed."""
    status = Path(path).stat()
    return _digest_of_file(str(path), status.st_size, status.st_mtime_ns)


def digest_of_files(*paths):
    return digest_of(*(part for f in files(*paths) for part in (f, digest_of_file(ROOT / f))))


@functools.cache
def _included(path):
    """Files of the tree that a file includes, directly."""
    result = []
    for name in INCLUDE.findall(Path(path).read_bytes()):
        name = name.decode()
        for place in (Path(path).parent, ROOT / "include", ROOT / "src", ROOT / "tests", ROOT / "examples/programs"):
            if (place / name).is_file():
                result.append((place / name).resolve())
                break
    return result


def closure(source):
    """The source and all files of the tree it includes."""
    found, left = set(), [Path(source).resolve()]
    while left:
        path = left.pop()
        if path not in found:
            found.add(path)
            left += _included(path)
    return sorted(found)


def digest_of_unit(source, *more):
    """Of a translation unit with what it includes of the tree."""
    return digest_of(*(part for p in closure(source) for part in (p, digest_of_file(p))), *more)


@functools.cache
def version_of(program):
    """What a program says of its version; nothing where it is not installed."""
    try:
        said = subprocess.run([program, "--version"], capture_output=True, text=True, check=False)
    except OSError:
        return ""
    return (said.stdout + said.stderr).strip()


def commit():
    """The commit's short name, with + where the tree differs from it."""
    def git(*words):
        return subprocess.run(["git", *words], cwd=ROOT, capture_output=True, text=True, check=True).stdout.strip()
    return git("rev-parse", "--short", "HEAD") + ("+" if git("status", "--porcelain") else "")


def machine():
    """Processor, cores and compilers."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
        model = next(line.split(":")[1].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        model = platform.machine()
    found = [(name, re.match(r".*?version (\S+)|.*\) (\S+)", version_of(tool)))
             for name, tool in (("Clang", "clang++"), ("GCC", "g++"))]
    return ", ".join([model, f"{os.cpu_count()} cores", *(f"{name} {m[1] or m[2]}" for name, m in found if m)])
