"""The report of a check: a table as text, as Markdown and as a page."""

import html
import os
import platform
from pathlib import Path

from tree import ROOT, version_of

HEAD = ("gate", "result", "passed", "failed", "skipped", "not run", "minutes", "commit", "figures")


def _rows(results):
    for r in results:
        yield (r.gate.name, r.verdict(), *(str(r.count(s)) for s in ("passed", "failed", "skipped", "not run")),
               f"{r.seconds / 60:.0f}", r.commit, "; ".join(f"{k} {v}" for k, v in r.figures.items()))


def machine():
    """Processor, cores and tools, in a line."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
        model = next(line.split(":")[1].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        model = platform.machine()
    tools = [version_of(t).splitlines()[0] for t in ("clang++", "g++", "cmake") if version_of(t)]
    return f"{model}, {os.cpu_count()} cores; " + "; ".join(tools)


def text(results):
    rows = [HEAD, *_rows(results)]
    widths = [max(len(row[k]) for row in rows) for k in range(len(HEAD))]
    return machine() + "\n" + "\n".join(
        "  ".join(cell.ljust(width) for cell, width in zip(row, widths)).rstrip() for row in rows)


def markdown(results):
    template = (Path(__file__).resolve().parent / "checks.md.in").read_text(encoding="utf-8")
    lines = ["| " + " | ".join(HEAD) + " |", "|" + "---|" * len(HEAD)]
    lines += ["| " + " | ".join(row) + " |" for row in _rows(results)]
    gates = "\n".join(f"| `{r.gate.name}` | {r.gate.title} |" for r in results)
    reasons = "\n".join(f"| `{r.gate.name}` | {count} | {note} |" for r in results for note, count in _reasons(r))
    return template.replace("@machine@", machine()).replace("@table@", "\n".join(lines)).replace(
        "@gates@", gates).replace("@reasons@", reasons)


def _reasons(result):
    """Why items were skipped or not run, with their number: the most frequent first."""
    counts = {}
    for item in result.items.values():
        if item.state in ("skipped", "not run"):
            note = (item.note or item.state).splitlines()[0]
            counts[note] = counts.get(note, 0) + 1
    return sorted(counts.items(), key=lambda c: -c[1])


def write(results, folder):
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "report.txt").write_text(text(results) + "\n", encoding="utf-8")
    (folder / "report.html").write_text(_page(results), encoding="utf-8")


def _page(results):
    style = (Path(__file__).resolve().parent / "report.css").read_text(encoding="utf-8")
    rows = []
    for row, r in zip(_rows(results), results):
        kind = {"passed": "good", "FAILED": "bad"}.get(row[1], "open")
        cells = "".join(f"<td>{html.escape(c)}</td>" for c in row[2:])
        rows.append(f'<tr class="{kind}"><th title="{html.escape(r.gate.title)}"><a href="#{row[0]}">{row[0]}</a></th>'
                    f"<td class=verdict>{row[1]}</td>{cells}</tr>")
    parts = [f"<!doctype html><html lang=en><meta charset=utf-8><title>wayfare: checks</title><style>{style}</style>",
             f"<h1>wayfare: checks</h1><p>{html.escape(machine())}</p><table><tr>",
             "".join(f"<th>{h}</th>" for h in HEAD), "</tr>", *rows, "</table>"]
    for r in results:
        parts.append(f"<h2 id={r.gate.name}>{r.gate.name}</h2><p>{html.escape(r.gate.title)}. {html.escape(r.line())}"
                     f"{'. Ended ' + r.ended if r.ended else ''}</p>")
        for state in ("failed", "not run", "skipped"):
            items = [i for i in r.items.values() if i.state == state]
            if items:
                listed = "".join(f"<tr><td>{html.escape(i.name)}</td><td><pre>{html.escape(i.note[:2000])}</pre></td>"
                                 f"<td>{i.seconds:.1f} s</td></tr>" for i in items)
                parts.append(f"<details{' open' if state == 'failed' else ''}><summary>{len(items)} {state}</summary>"
                             f"<table class=items>{listed}</table></details>")
        slow = sorted(r.items.values(), key=lambda i: -i.seconds)[:10]
        if slow and slow[0].seconds > 1:
            listed = ", ".join(f"{html.escape(i.name)} {i.seconds:.0f} s" for i in slow if i.seconds > 1)
            parts.append(f"<p class=slow>longest: {listed}</p>")
    return "\n".join(parts) + "</html>\n"
