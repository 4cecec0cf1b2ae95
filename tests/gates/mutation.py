"""Random changes of single tokens, and whether the tests of the family notice.

A change that does not compile is not counted. One that survives is listed with its line: either a test is
missing or the two programs are the same (`<` for `<=` on real numbers that never are equal).
"""

import concurrent.futures
import random
import re
import shutil
import time

import builds
from running import Item, Stopped
from tree import ROOT, digest_of, digest_of_files, files, version_of

FAMILIES = ("core", "filter", "graph", "match", "decode")
CHANGES, LEAST = 200, 85.0  # changes that compile; percent noticed
SWAPS = {" + ": " - ", " - ": " + ", " * ": " / ", " / ": " * ", " < ": " <= ", " > ": " >= ", " <= ": " < ",
         " >= ": " > ", " == ": " != ", " != ": " == ", " && ": " || ", " || ": " && ", " += ": " -= ", " -= ": " += ",
         " *= ": " /= ", "++": "--", "true": "false", "false": "true", "std::min": "std::max", "std::max": "std::min",
         "std::sin": "std::cos", "std::cos": "std::sin", "continue;": "break;"}
TOKEN = re.compile("|".join([*(re.escape(t) if " " in t or "+" in t else rf"\b{re.escape(t)}"
                                for t in sorted(SWAPS, key=len, reverse=True)), r"(?<![\w.])\d+(?:\.\d+)?(?:e-?\d+)?(?![\w.'])"]))
# Comments, strings, characters, lines of the preprocessor, static assertions, attributes.
SKIPPED = re.compile(r'//[^\n]*|/\*.*?\*/|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])+\'|^[ \t]*#(?:\\\n|[^\n])*|'
                     r"static_assert\s*\(.*?\);|\[\[.*?\]\]|template\s*<[^;{]*?>\s", re.DOTALL | re.MULTILINE)


def changed(token):
    if token in SWAPS:
        return SWAPS[token]
    return str(int(token) + 1) if token.isdigit() else f"{2 * float(token) if float(token) else 1.0!r}"


def sites():
    """(family, file, offset, token) of all changes, in a fixed random order."""
    result = []
    for family in FAMILIES:
        for name in files(f"include/wayfare/{family}", f"src/{family}", suffixes=(".hpp", ".cpp", ".inl")):
            text = (ROOT / name).read_text(encoding="utf-8")
            hidden = [m.span() for m in SKIPPED.finditer(text)]
            for found in TOKEN.finditer(text):
                if not any(a <= found.start() < b for a, b in hidden):
                    result.append((family, name, found.start(), found.group()))
    random.Random(1).shuffle(result)
    return result


class Copy:
    """A copy of the tree with its build."""

    def __init__(self, run, number):
        self.run, self.tree, self.build = run, run.folder / f"tree{number}", run.folder / f"build{number}"
        self.seconds = {}

    def prepare(self):
        """Files as in the tree; builds the tests and measures how long each runs."""
        wanted = set(files("CMakeLists.txt", "cmake", "include", "src", "tests", "docs/reference", "README.md"))
        for name in wanted:
            target, text = self.tree / name, (ROOT / name).read_bytes()
            if not target.is_file() or target.read_bytes() != text:
                target.parent.mkdir(parents=True, exist_ok=True)
                target.write_bytes(text)
        for path in self.tree.rglob("*"):
            if path.is_file() and str(path.relative_to(self.tree)) not in wanted:
                path.unlink()
        options = ["-DCMAKE_CXX_COMPILER=clang++", "-DCMAKE_EXE_LINKER_FLAGS=-fuse-ld=lld", *builds.tree_options(
            self.run, "-O1", scans=200, examples=False), "-DWAYFARE_COMPONENTS=all", "-DWAYFARE_INSTALL=OFF"]
        builds.configure(self.run, *options, folder=self.build, source=self.tree)
        for family in FAMILIES:
            builds.build(self.run, *tests_of(family), folder=self.build)
            for test in tests_of(family):
                began = time.monotonic()
                code, output = self.run.command([self.build / "bin" / test, "--gtest_brief=1"], timeout_s=300)
                if code != 0:
                    raise Stopped(test, "failed", "fails without a change\n" + output[-800:])
                self.seconds[test] = time.monotonic() - began

    def try_change(self, family, name, offset, token):
        """'noticed' with the test, 'survived', 'does not compile', or None where no time was left."""
        path = self.tree / name
        text = path.read_text(encoding="utf-8")
        try:
            path.write_text(text[:offset] + changed(token) + text[offset + len(token):], encoding="utf-8")
            code, output = self.run.command(["cmake", "--build", self.build, "--parallel", "1", "--target", *tests_of(family)])
            if code is None:
                return None, ""
            if code != 0:
                # A static assertion of the library or its tests is a test.
                noticed = "static_assert" in output or "static assertion" in output
                return ("noticed", "static_assert") if noticed else ("does not compile", "")
            for test in sorted(tests_of(family), key=self.seconds.get):
                code, output = self.run.command([self.build / "bin" / test, "--gtest_brief=1", "--gtest_fail_fast"],
                                                timeout_s=15 + 5 * self.seconds[test])
                if code is None and self.run.seconds_left() < 1:
                    return None, ""
                if code != 0:
                    failed = re.search(r"\[  FAILED  \] (\S+)", output)
                    return "noticed", failed[1] if failed else f"{test} ends with {code}"
            return "survived", ""
        finally:
            path.write_text(text, encoding="utf-8")


def tests_of(family):
    text = (ROOT / "tests" / family / "CMakeLists.txt").read_text(encoding="utf-8")
    result = [f"test_{name}" for name in re.findall(r"wayfare_test\((\w+)", text)]
    for kind, folder in (("", "abuse"), ("sequences_", "abuse/sequences")):
        if any((ROOT / "tests" / folder).glob(f"{family}_*test.cpp")):
            result.append(f"test_abuse_{kind}{family}")
    return result


def check(run):
    tests = {f: digest_of_files("include", "src", f"tests/{f}", "tests/abuse", "cmake") for f in FAMILIES}
    all_sites = sites()
    before = dict(run.before.items)
    copies = [Copy(run, k) for k in range(run.jobs)]
    if shutil.which("ccache") is None:
        run.log("without ccache the second copy is compiled as long as the first")
    for copy in copies:
        copy.prepare()
    counted, next_site = 0, iter(all_sites)

    def work(copy):
        nonlocal counted
        for family, name, offset, token in next_site:
            if counted >= CHANGES:
                return
            line = (ROOT / name).read_text(encoding="utf-8").count("\n", 0, offset) + 1
            label = f"{name}:{line} {token.strip()} -> {changed(token).strip()}"
            digest = digest_of(tests[family], version_of("clang++"), offset)
            if run.keep_passed(label, digest):
                counted += 1
                continue
            if before.get(label) and before[label].digest == digest and before[label].note == "does not compile":
                continue
            if run.seconds_left() < 1:
                return
            began = time.monotonic()
            outcome, by = copy.try_change(family, name, offset, token)
            seconds = time.monotonic() - began
            if outcome in ("noticed", "survived"):
                counted += 1
                text = (ROOT / name).read_text(encoding="utf-8").splitlines()[line - 1].strip()
                run.keep(Item(label, "passed" if outcome == "noticed" else "skipped", seconds,
                              f"by {by}" if by else f"survived: {text}", digest))

    with concurrent.futures.ThreadPoolExecutor(run.jobs) as pool:
        for future in [pool.submit(work, copy) for copy in copies]:
            future.result()
    noticed = sum(i.state == "passed" for i in run.items.values())
    share = 100 * noticed / max(counted, 1)
    run.figure("changes", counted)
    run.figure("noticed", f"{share:.1f} %")
    if counted < CHANGES:
        run.keep(Item(f"{CHANGES - counted} changes", "not run", note="no time was left"))
    run.keep(Item("share noticed", "passed" if share >= LEAST else "failed", note=f"{share:.1f} %, least {LEAST} %"))
