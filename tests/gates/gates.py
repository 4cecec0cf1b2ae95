"""The gates, in the order they run: the quick ones first."""

import builds
import coverage
import consumers
import fuzzing
import headers
import mutation
import same_digits
import tidy
import vectors
from running import Gate, Step, Stopped
from tree import ROOT, digest_of_file, digest_of_files

CODE = ("CMakeLists.txt", "cmake", "include", "src")
TREE = (*CODE, "benchmarks/accuracy", "docs", "examples", "tests", "README.md", "run")
SANITIZED = "-O1 -g1 -fno-omit-frame-pointer -fno-sanitize-recover=all"
CLANG_PACKAGES = "clang lld llvm libclang-rt-14-dev"


def clang(linking=""):
    return "-DCMAKE_CXX_COMPILER=clang++", f"-DCMAKE_EXE_LINKER_FLAGS=-fuse-ld=lld {linking}".rstrip()


def documents(run):
    """Doxygen's warnings, the documents' links and options, the programs they show."""
    run_tests(run, select=r"^(docs|readme|tutorial|tour|headers\.families|programs\.documented_options)")


def tests(run):
    """The tests of ./run test, in its folder."""
    run_tests(run)


def demo(run):
    """What a visitor does first, with Debian's default compiler."""
    inputs = digest_of_files(*CODE, "examples", "run")
    run.steps([Step("programs and demo", ["sh", "-c", "./run programs && ./run demo"], inputs, timeout_s=3300, verdict=last_line)])


def gcc(run):
    """Debian's default compiler by CMake's defaults: what it warns of depends on what it inlines into what."""
    builds.configure(run, "-DCMAKE_CXX_COMPILER=g++", "-DWAYFARE_BUILD_TESTS=OFF", "-DWAYFARE_BUILD_BENCHMARKS=OFF")
    builds.build(run)
    run.steps([Step(program.name, [program, "--help"], digest_of_file(program), timeout_s=60)
               for program in sorted((run.folder / "bin").iterdir()) if program.suffix == "" and program.is_file()])


def run_tests(run, select="."):
    builds.test(run, built_tests(run), select=select, jobs=run.jobs + 1)


def built_tests(run):
    """The folder of ./run test, built."""
    code, output = run.command([ROOT / "run", "test", "-N"])
    if code != 0:
        raise Stopped("build", "not run" if code is None else "failed", output[-1500:])
    return ROOT / "build" / "test"


def below_tests(names):
    return [f"tests/{name}" for name in names.split()]


# Folders of tests: what is made of one part, of several, and programs. Each gate takes what fits its minutes.
PARTS = below_tests("core decode eval filter gnss graph inertial io map match motion sensors sim sync")
SYSTEMS = below_tests("abuse logger nav pedestrian ros ros2 slam tune")
PROGRAMS = [*below_tests("fuzz headers programs"), "examples/programs", "examples/tour", "benchmarks/accuracy"]
ELSE = below_tests("compile_fail consumer docs soak tutorials")  # gates tests, consumers, documents, soaks
READERS = below_tests("core decode gnss io sensors")
THREADED = below_tests("core filter graph logger nav ros sim slam tune")


def all_of(places):
    """The targets of folders; the gate stops where a folder of tests is in no list."""
    listed = {*PARTS, *SYSTEMS, *PROGRAMS, *ELSE}
    forgotten = {f"tests/{f.parent.name}" for f in (ROOT / "tests").glob("*/CMakeLists.txt")} - listed
    if forgotten:
        raise Stopped("folders", "failed", f"no gate runs the tests of {', '.join(sorted(forgotten))}")
    return [f"{place}/all" for place in places]


def address(run):
    addresses(run, PARTS)


def address_systems(run):
    addresses(run, SYSTEMS)


def address_programs(run):
    addresses(run, PROGRAMS)


DRIVES = (r"^(GnssInsConsistency\.|GnssInsCorrelated\.|RealDrive\.OutagesWithC|Odometer\.ErrorsOfDrives|"
          r"PhaseChange\.ErrorsMatch|InsFilter\.CovarianceStaysValidForADay)")


def addresses(run, places):
    """NDEBUG is not defined: assertions of Eigen and the library are on. The three gates share a folder."""
    folder = run.folder.parent / "address"
    flags = f"{SANITIZED} -fsanitize=address,undefined,float-cast-overflow {coverage.FLAGS}"
    builds.configure(run, *clang(coverage.LINKING), *builds.tree_options(run, flags), folder=folder)
    builds.build(run, *all_of(places), folder=folder)
    builds.test(run, folder=folder, environment=coverage.environment(folder) | {
        "ASAN_OPTIONS": "detect_leaks=1:strict_string_checks=1:detect_stack_use_after_return=1",
        "UBSAN_OPTIONS": "print_stacktrace=1"},
        exclude=ELSEWHERE | {r"^Ros2FastDds": "Fast DDS deletes objects as another type: gate tests",
                             r"^programs\.rtklib_points": "RTKLIB leaks: gate tests",
                             r"TakeNoMemory$": "the sanitizer keeps what was freed: gate tests",
                             DRIVES: "statistics over hours of drives: gate tests"}, places=places)


def thread(run):
    flags = f"{SANITIZED} -fsanitize=thread"
    builds.configure(run, *clang(), *builds.tree_options(run, flags, examples=False))
    builds.build(run, *all_of(THREADED))
    builds.test(run, environment={"TSAN_OPTIONS": "halt_on_error=1:ignore_noninstrumented_modules=1"},
                exclude=ELSEWHERE, places=THREADED)


# Foreign libraries that exchange containers with ours.
WITH_CONTAINERS = ("-DCMAKE_DISABLE_FIND_PACKAGE_ROSCPP=ON", "-DWAYFARE_ROSBAG_INCLUDE_DIR=",
                   "-DCMAKE_DISABLE_FIND_PACKAGE_fastrtps=ON")


def gcc_debug(run):
    """Containers that check their use are other types: all that exchanges them is compiled with them."""
    flags = "-O0 -g1 -D_GLIBCXX_DEBUG -D_GLIBCXX_ASSERTIONS -DEIGEN_INITIALIZE_MATRICES_BY_NAN"
    googletest = run.folder / "googletest"
    builds.configure(run, "-DCMAKE_CXX_COMPILER=g++", f"-DCMAKE_CXX_FLAGS={flags}",
                     f"-DCMAKE_INSTALL_PREFIX={googletest / 'installed'}", folder=googletest, source="/usr/src/googletest")
    builds.build(run, "install", folder=googletest)
    builds.configure(run, "-DCMAKE_CXX_COMPILER=g++", f"-DGTest_DIR={googletest / 'installed/lib/cmake/GTest'}", *WITH_CONTAINERS,
                     *builds.tree_options(run, flags, scans=200, examples=False))
    builds.build(run, *all_of(PARTS + SYSTEMS))
    builds.test(run, exclude=ELSEWHERE, places=PARTS + SYSTEMS)


def leaks(run):
    """The tests of logger and monitor by Valgrind, as ./run test built them."""
    programs = built_tests(run) / "bin"
    steps = []
    for program in ("test_logger", "test_abuse_logger", "test_monitor"):
        path = programs / program
        listed = run.command([path, "--gtest_list_tests"])[1]
        for suite in [line.split(".")[0] for line in listed.splitlines() if line and not line.startswith(" ")
                      and line.split("#")[0].strip().endswith(".")]:
            if suite != "MonitorInABrowser":
                steps.append(Step(f"{program}.{suite}", [
                    "valgrind", "--quiet", "--leak-check=full", "--error-exitcode=9", "--fair-sched=yes", path,
                    f"--gtest_filter={suite}.*", "--gtest_brief=1"], digest_of_file(path), timeout_s=1200))
    run.steps(steps)


SOAK_MINUTES = 8


def soaks(run):
    """Each soak program for some minutes, a simulated day of SLAM, tuning killed many times."""
    programs = built_tests(run) / "bin"
    commands = {f"soak_{name}": ["--minutes", str(SOAK_MINUTES)]
                for name in ("allocations", "decoders", "logger", "monitor")}
    commands["endless_runs"] = ["--hours", "24", "--merge-from", "1", "--quiet", "--force", "--out", str(run.folder / "day")]
    commands["test_tune_killed"] = []
    run.steps([Step(name, [programs / name, *words], digest_of_file(programs / name), timeout_s=3000,
                    environment={"WAYFARE_TUNE_KILLS": "30"}, verdict=last_line) for name, words in commands.items()])
    for name, item in run.items.items():
        if item.state == "passed":
            run.figure(name.removeprefix("soak_"), " ".join(item.note.removeprefix("[  PASSED  ]").strip(" .").split()))


def last_line(code, output):
    return ("passed" if code == 0 else "failed"), "\n".join(output.strip().splitlines()[-1 if code == 0 else -8:])


def aarch64(run):
    cross(run, "aarch64-linux-gnu", PARTS + SYSTEMS, programs=("pose_graph",))
    vectors.check(run, run.folder)
    same_digits.check(run, [built_tests(run) / "bin" / "pose_graph"],
                      ["qemu-aarch64-static", run.folder / "bin" / "pose_graph"])


def armhf(run):
    cross(run, "arm-linux-gnueabihf", [*PARTS, "tests/abuse"])  # sizes of hostile input overflow here first


def s390x(run):
    cross(run, "s390x-linux-gnu", READERS)


def cross(run, triple, places, programs=()):
    """Cross-compiled, tested by emulation."""
    builds.configure(run, f"-DCMAKE_TOOLCHAIN_FILE={headers.HERE / 'cross.cmake'}", f"-DWAYFARE_CROSS={triple}",
                     *builds.tree_options(run, "-O2 -DNDEBUG", scans=200, examples=bool(programs)),
                     "-DCMAKE_DISABLE_FIND_PACKAGE_ROSCPP=ON", "-DCMAKE_DISABLE_FIND_PACKAGE_CycloneDDS=ON")
    builds.build(run, *all_of(places), *programs)
    builds.test(run, exclude=ELSEWHERE | {r"DeathTest\.": "starts its own program, which needs the emulator: gate tests"},
                places=places)


# Tests that other gates run, and why.
ELSEWHERE = {r"^MonitorInABrowser\.": "starts a browser",
         r"^(tutorial\.|programs\.(demo|compare_methods))": "takes long with optimisation, too: gate tests",
         r"^consumer\.": "a build of its own: gate consumers",
         r"^docs\.": "gate documents"}

ALL = (
    Gate("headers", "every public header alone and all together, C++20 and C++23, Clang and GCC, without "
         "exceptions and RTTI, conversion and shadow warnings", CODE, headers.check, ("clang++", "g++"), "clang g++"),
    Gate("tests", "Clang build and all tests", TREE, tests, ("clang++", "cmake"), "clang cmake"),
    Gate("demo", "all programs built by GCC with optimisation, the demo", TREE, demo, ("g++", "cmake"), "g++ cmake"),
    Gate("gcc", "libraries and programs by GCC with optimisation, each unit by itself", CODE + ("benchmarks/accuracy", "examples"),
         gcc, ("g++", "cmake"), "g++ cmake"),
    Gate("documents", "API pages without warnings; programs, options and figures of the documents", TREE,
         documents, ("doxygen",), "doxygen"),
    Gate("consumers", "a consumer's project with every subset of the optional packages",
         (*CODE, "tests/consumer"), consumers.check, ("clang++",), "clang"),
    Gate("address", "address and undefined-behaviour sanitizers, leaks, assertions: the parts", TREE, address,
         ("clang++", "ld.lld"), CLANG_PACKAGES),
    Gate("address_systems", "the same: SLAM, navigation, logger, ROS, misuse", TREE, address_systems,
         ("clang++", "ld.lld"), CLANG_PACKAGES),
    Gate("address_programs", "the same: programs, tour, fuzz targets", TREE, address_programs,
         ("clang++", "ld.lld"), CLANG_PACKAGES),
    Gate("coverage", "lines and branches that the tests of the three gates before ran", TREE, coverage.check,
         ("clang++", "llvm-cov", "llvm-profdata"), CLANG_PACKAGES),
    Gate("thread", "thread sanitizer: families that start threads", TREE, thread, ("clang++", "ld.lld"), CLANG_PACKAGES),
    Gate("gcc_debug", "GCC without optimisation: parts and systems with checked containers and iterators, "
         "assertions, matrices initialised with NaN", TREE, gcc_debug, ("g++",), "g++ googletest"),
    Gate("leaks", "logger and monitor by Valgrind", TREE, leaks, ("valgrind", "clang++"), "valgrind"),
    Gate("soaks", f"soak programs for {SOAK_MINUTES} minutes each, SLAM over a simulated day, tuning killed", TREE, soaks,
         ("clang++", "cmake"), "clang cmake"),
    Gate("fuzz", "fuzz targets of all readers and decoders, from the corpus kept", (*CODE, "tests/fuzz"),
         fuzzing.check, ("clang++",), CLANG_PACKAGES),
    Gate("tidy", "clang-tidy on every translation unit", (*TREE, ".clang-tidy", "benchmarks"), tidy.check,
         ("clang-tidy", "clang++", "llvm-config"), "clang-tidy libclang-dev llvm-dev"),
    Gate("aarch64", "cross build for 64-bit ARM, parts and systems under emulation, digits of optimised graphs", TREE, aarch64,
         ("aarch64-linux-gnu-g++", "qemu-aarch64-static"), "g++-aarch64-linux-gnu qemu-user-static"),
    Gate("armhf", "the same for 32-bit ARM: parts and misuse", TREE, armhf, ("arm-linux-gnueabihf-g++", "qemu-arm-static"),
         "g++-arm-linux-gnueabihf qemu-user-static"),
    Gate("s390x", "the same for a big-endian machine: decoders, readers, GNSS", TREE, s390x,
         ("s390x-linux-gnu-g++", "qemu-s390x-static"), "g++-s390x-linux-gnu qemu-user-static"),
    Gate("mutation", "random changes of single tokens that the tests notice", (*CODE, "tests"),
         mutation.check, ("clang++",), "clang"),
)
