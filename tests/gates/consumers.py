"""A consumer's project against installations with every subset of the optional packages."""

import itertools
import re
import shutil

import builds
from running import Item
from tree import ROOT, digest_of, digest_of_files, version_of

# Compressions are used inside a component; each other one decides whether components exist.
INSIDE = ("LZ4", "ZSTD", "BZip2")
FAMILY = re.compile(r"^wayfare_family\((\w+)([^)]*)\)", re.MULTILINE)


def families():
    """{component: (components it uses, packages it needs)}, by src/CMakeLists.txt."""
    result = {}
    for name, rest in FAMILY.findall((ROOT / "src/CMakeLists.txt").read_text(encoding="utf-8")):
        lists = {"USES": [], "PACKAGES": [], "FOLDER": []}
        into = []
        for word in rest.split():
            into = lists[word] if word in lists else into
            if word not in lists:
                into.append(word)
        result[name] = (lists["USES"], lists["PACKAGES"])
    return result


def expected(without):
    """Components that can be built without these packages."""
    built = []
    for name, (uses, packages) in families().items():
        if not set(packages) & set(without) and set(uses) <= set(built):
            built.append(name)
    return built


def check(run):
    optional = sorted({p for _, packages in families().values() for p in packages} - {"Threads"} | set(INSIDE))
    key = digest_of(digest_of_files("CMakeLists.txt", "cmake", "src", "include", "tests/consumer"),
                    version_of("clang++"), version_of("cmake"))
    subsets = [s for n in range(len(optional) + 1) for s in itertools.combinations(optional, n)]
    for without in subsets:
        _configure(run, optional, without, key)
    # Compiled, installed and used: every subset of the compressions, each other package alone away, all away.
    compiled = [s for s in subsets if set(s) <= set(INSIDE) or len(s) == 1 or len(s) == len(optional)]
    for without in compiled:
        _use(run, optional, without, key)
    run.figure("subsets configured", len(subsets))
    run.figure("compiled", len(compiled))


def _options(optional, without):
    return [f"-DCMAKE_DISABLE_FIND_PACKAGE_{p}={'ON' if p in without else 'OFF'}" for p in optional]


def _label(without):
    return "without " + " ".join(without) if without else "with all"


def _configure(run, optional, without, key):
    """The components found are those whose packages are there."""
    name = f"configure {_label(without)}"
    if run.keep_passed(name, key):
        return
    if run.seconds_left() < 1:
        run.keep(Item(name, "not run", note="no time was left"))
        return
    code, output = run.command(["cmake", "-S", ROOT, "-B", run.folder / "configure", "-G", "Ninja",
                                "-DCMAKE_CXX_COMPILER=clang++", "-DWAYFARE_BUILD_TESTS=OFF", "-DWAYFARE_BUILD_EXAMPLES=OFF",
                                "-DWAYFARE_BUILD_BENCHMARKS=OFF", *_options(optional, without)])
    left_out = set(re.findall(r"wayfare: no component '(\w+)'", output))
    wanted = set(families()) - set(expected(without))
    good = code == 0 and left_out == wanted
    run.keep(Item(name, "passed" if good else "failed", digest=key,
                  note="" if good else f"left out {sorted(left_out)}, expected {sorted(wanted)}\n{output[-800:]}"))


def _use(run, optional, without, key):
    """Build, install, and the project of tests/consumer against it."""
    name = f"use {_label(without)}"
    if run.keep_passed(name, key):
        return
    build, prefix, project = (run.folder / f for f in ("build", "prefix", "project"))
    for folder in (prefix, project):
        shutil.rmtree(folder, ignore_errors=True)
    # The project includes the header of each family; these have none, or need more than the project has.
    components = [c for c in expected(without) if c not in ("testing", "ros_live", "ros2", "cholmod")]
    launcher = ["-DCMAKE_CXX_COMPILER_LAUNCHER=ccache"] if shutil.which("ccache") else []
    commands = (
        ["cmake", "-S", ROOT, "-B", build, "-G", "Ninja", "-DCMAKE_CXX_COMPILER=clang++", "-DCMAKE_BUILD_TYPE=Release",
         "-DCMAKE_CXX_FLAGS_RELEASE=-O0", "-DWAYFARE_BUILD_TESTS=OFF", "-DWAYFARE_BUILD_EXAMPLES=OFF",
         "-DWAYFARE_BUILD_BENCHMARKS=OFF", "-DWAYFARE_FAST_BUILD=ON", *launcher, *_options(optional, without)],
        ["cmake", "--build", build, "--parallel", run.jobs],
        ["cmake", "--install", build, "--prefix", prefix],
        ["cmake", "-S", ROOT / "tests/consumer/project", "-B", project, "-G", "Ninja", "-DCMAKE_CXX_COMPILER=clang++",
         "-DWAYFARE_FROM=installed", f"-DCMAKE_PREFIX_PATH={prefix}", "-DOWN_SYSTEMS=OFF", "-DALL_HEADERS=OFF",
         "-DCMAKE_CXX_FLAGS=-Wall -Wextra -Wconversion -Wshadow -Werror", f"-DCOMPONENTS={';'.join(components)}",
         *launcher, *_options(optional, without)],
        ["cmake", "--build", project, "--parallel", run.jobs],
        [project / "stranger"])
    for command in commands:
        code, output = run.command(command)
        if code != 0:
            late = code is None
            run.keep(Item(name, "not run" if late else "failed", note="no time was left" if late else
                          f"{' '.join(map(str, command[:3]))}\n{output[-1500:]}"))
            return
    run.keep(Item(name, "passed", digest=key))
