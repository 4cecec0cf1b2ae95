"""A case of the golden check."""

import re
from dataclasses import dataclass


@dataclass(frozen=True)
class Case:
    """Commands run in order in one folder, whose files and streams are digested.

    {data} is the folder of the recordings, {inputs} that of this check's own files, {out} the case's
    folder, {out:NAME} that of another case, which then runs before. `exit` is what the last command
    ends with. `varies` are pairs of a pattern and the reason why what it matches differs from run to
    run.
    """

    name: str
    commands: tuple
    exit: int = 0
    varies: tuple = ()

    @property
    def needs(self):
        return sorted(set(re.findall(r"\{out:([\w-]+)\}", " ".join(self.commands))))

    def matches(self, pattern):
        return pattern is None or re.search(pattern, self.name) is not None
