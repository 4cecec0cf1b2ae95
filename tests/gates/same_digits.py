"""Whether pose graphs optimised on another machine give the same digits as here."""

import json

from running import Item

GRAPHS = ("intel.g2o.gz", "M3500.g2o.gz", "parking-garage.g2o.gz", "sphere2500.g2o.gz")
MOST = 1e-6  # m and rad between the poses; the sums of squared errors are the same as printed, nine digits


def check(run, here, there):
    """`here` and `there` are the commands of pose_graph for this machine and the other."""
    for name in GRAPHS:
        path = run.data / "posegraph" / name if run.data else None
        if path is None or not path.is_file():
            run.keep(Item(f"digits of {name}", "skipped", note="recording is absent"))
            continue
        (facts, poses), (others, other_poses) = (_optimised(run, command, path) for command in (here, there))
        apart = max((abs(a - b) for a, b in zip(poses, other_poses)), default=float("inf"))
        same = facts and facts == others and len(poses) == len(other_poses) and apart <= MOST
        run.keep(Item(f"digits of {name}", "passed" if same else "failed",
                      note=f"{facts} and {others}; poses {apart:.1e} m or rad apart, most {MOST:.0e}"))


def _optimised(run, command, path):
    """(sum of squared errors after, iterations) as printed, and the numbers of all poses."""
    out = run.folder / "optimised.g2o"
    code, output = run.command([*command, path, "--out", out, "--force", "--json", "-"])
    if code != 0:
        return output[-300:], []
    facts = {f["name"]: f["text"] for f in json.loads(output)["blocks"][0]["facts"]}
    rows = [line.split() for line in out.read_text(encoding="utf-8").splitlines()]
    numbers = [float(word) for row in rows if row and row[0].startswith("VERTEX") for word in row[2:]]
    return (facts["after"], facts["iterations"]), numbers
