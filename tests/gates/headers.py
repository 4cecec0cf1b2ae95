"""Public headers as strangers' compilers see them."""

import re
from pathlib import Path

from running import Step
from tree import ROOT, digest_of, digest_of_file, digest_of_unit, files, version_of

HERE = Path(__file__).resolve().parent
WARNINGS = ("-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wshadow", "-Wdouble-promotion", "-Werror")
PLAIN = ("-fno-exceptions", "-fno-rtti")
TOGETHER = (("clang++", ("-std=c++20",)), ("clang++", ("-std=c++2b", *PLAIN)),
            ("g++", ("-std=c++20",)), ("g++", ("-std=c++23", *PLAIN)))


def check(run):
    headers = files("include", suffixes=(".hpp",))
    includes = ["-I", ROOT / "include", "-isystem", "/usr/include/eigen3", "-isystem", "/usr/include/suitesparse"]
    steps = []
    for header in headers:
        command = ["clang++", "-std=c++20", "-fsyntax-only", *WARNINGS, *includes, "-include", ROOT / header,
                   "-x", "c++", "/dev/null"]
        steps.append(Step(header, command, digest_of_unit(ROOT / header, *command, version_of("clang++"))))
    names = [re.sub("^include/", "", h) for h in headers]
    for compiler, options in TOGETHER:
        for order, listed in (("forwards", names), ("backwards", names[::-1])):
            unit = run.folder / f"{order}.cpp"
            unit.write_text("".join(f"#include <{name}>\n" for name in listed), encoding="utf-8")
            command = [compiler, *options, "-fsyntax-only", *WARNINGS, *includes, unit]
            steps.append(Step(f"all {order}, {compiler} {' '.join(options)}", command, digest_of(
                *command, version_of(compiler), *(digest_of_file(ROOT / h) for h in headers))))
    run.steps(steps)
    run.figure("headers", len(headers))
