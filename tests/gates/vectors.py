"""Whether the loops of kernels, compiled for 64-bit ARM, work on vectors."""

import re

from running import Item
from tree import digest_of_file

FLOATING = r"f(?:add|sub|mul|div|sqrt|abs|neg|n?madd|n?msub|mla|mls|max\w*|min\w*|cmp\w*|cm\w\w|csel|cvt\w+)|[su]cvtf"
VECTOR = re.compile(rf"({FLOATING}) v\d+\.")
SCALAR = re.compile(rf"({FLOATING}) [sd]\d+,")
BRANCH = re.compile(r"(?:b|b\.\w+|cbn?z|tbn?z)\b.*?\b([0-9a-f]+) <")
MOST = 50.0  # percent of the code: ends of arrays, sums of lanes in a fixed order, pivots and triangular blocks


def check(run, build):
    """Of the objects of all kernels of a build."""
    objects = [p for p in build.glob("src/**/kernels.cpp.o")]
    if not objects:
        run.keep(Item("kernels", "failed", note="no objects were found"))
    for path in sorted(objects):
        counts = in_loops(run.command(["aarch64-linux-gnu-objdump", "-dC", "--no-show-raw-insn", path])[1])
        vector, scalar = sum(c[1] for c in counts), sum(c[2] for c in counts)
        share = 100 * scalar / max(vector + scalar, 1)
        most = max(counts, key=lambda c: c[2] - c[1], default=("none", 0, 0))
        run.keep(Item(f"loops of {path.relative_to(build).parts[1]}", "passed" if vector and share <= MOST else "failed",
                      note=f"{share:.0f} % of {vector + scalar} floating-point instructions are scalar, most {MOST} %; "
                           f"{most[2]} of {most[1] + most[2]} in {most[0]}", digest=digest_of_file(path)))


def in_loops(listing):
    """(function, floating-point instructions on vectors, on scalars) in loops."""
    result = []
    for function in listing.split("\n\n"):
        name = re.search(r"^[0-9a-f]+ <(.*)>:$", function, re.MULTILINE)
        code = [(int(a, 16), f"{op} {rest}") for a, op, rest in re.findall(
            r"^\s+([0-9a-f]+):\s+(\S+)[ \t]*(.*)$", function, re.MULTILINE)]
        begin, inside = code[0][0] if code else 0, set()
        for address, text in code:
            target = BRANCH.match(text)
            if target and begin <= int(target[1], 16) <= address:
                inside.update(range(int(target[1], 16), address + 1, 4))
        texts = [text for address, text in code if address in inside]
        if name:
            result.append((name[1], sum(bool(VECTOR.match(t)) for t in texts), sum(bool(SCALAR.match(t)) for t in texts)))
    return result
