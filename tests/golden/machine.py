"""What of a machine and a build the last digits of results depend on."""

import platform
import re
from pathlib import Path

# Instruction sets the library's kernels and the C library's functions are chosen by.
FEATURES = ("avx", "avx2", "fma", "avx512f", "avx512bw", "avx512dq", "avx512vl")


def _cpu():
    """Model and flags of the first core."""
    try:
        lines = Path("/proc/cpuinfo").read_text().split("\n\n")[0].splitlines()
    except OSError:
        return platform.processor(), set()
    fields = {k.strip(): v.strip() for k, _, v in (line.partition(":") for line in lines)}
    return fields.get("model name", ""), set(fields.get("flags", "").split())


def _compiler(programs):
    """As the compiler left its name in a program of the folder."""
    for path in sorted(p for p in programs.iterdir() if p.is_file()):
        named = re.search(rb"(?:GCC: \([^)]*\)|clang version) ([\d.]+)", path.read_bytes())
        if named:
            return named[0].decode()
    return ""


def description(programs):
    model, flags = _cpu()
    return {
        "compiler": _compiler(programs),
        "cpu": model,
        "features": " ".join(f for f in FEATURES if f in flags),
        "libc": " ".join(platform.libc_ver()),
        "machine": platform.machine(),
    }


def differences(recorded, programs):
    here = description(programs)
    return [f"{k} {here[k] or 'none'} (recorded: {recorded.get(k) or 'none'})"
            for k in here if here[k] != recorded.get(k)]
