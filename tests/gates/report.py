"""The report of a check: a table as text, as Markdown and as a page."""

import html
from pathlib import Path

HEAD = ("gate", "result", "passed", "failed", "skipped", "not run", "minutes", "commit", "day", "machine", "figures")


def _rows(results):
    for r in results:
        numbers = [*(str(r.count(s)) for s in ("passed", "failed", "skipped", "not run")), f"{r.seconds / 60:.0f}"]
        yield (r.gate.name, r.verdict(), *(numbers if r.items else [""] * len(numbers)), r.commit, r.ended[:10], r.machine,
               "; ".join(f"{k} {v}" for k, v in r.figures.items()).replace("|", "/"))


def text(results):
    rows = [HEAD, *_rows(results)]
    widths = [max(len(row[k]) for row in rows) for k in range(len(HEAD))]
    return "\n".join(
        "  ".join(cell.ljust(width) for cell, width in zip(row, widths)).rstrip() for row in rows)


def markdown(results, before=""):
    """The document; rows of gates without a result are those of the document before."""
    def rows_before(name):
        return [line for line in before.splitlines() if line.startswith(f"| `{name}` | ")]

    rows, reasons = [], []
    for r, row in zip(results, _rows(results)):
        earlier = [] if r.items else rows_before(r.gate.name)
        is_row = [line.count(" | ") == len(HEAD) - 1 for line in earlier]
        rows += [line for line, yes in zip(earlier, is_row) if yes] or ["| " + " | ".join((f"`{row[0]}`", *row[1:])) + " |"]
        reasons += [line for line, yes in zip(earlier, is_row) if not yes and line.count(" | ") == 2]
        reasons += [f"| `{r.gate.name}` | {count} | {note} |" for note, count in _reasons(r)]
    lines = ["| " + " | ".join(HEAD) + " |", "|" + "---|" * len(HEAD), *rows]
    gates = "\n".join(f"| `{r.gate.name}` | {r.gate.title} |" for r in results)
    template = (Path(__file__).resolve().parent / "checks.md.in").read_text(encoding="utf-8")
    return template.replace("@table@", "\n".join(lines)).replace("@gates@", gates).replace("@reasons@", "\n".join(reasons))


def _reasons(result):
    """Why items were skipped or not run, with their number: the most frequent first."""
    counts = {}
    for item in result.items.values():
        if item.state in ("skipped", "not run"):
            note = (item.note or item.state).splitlines()[0].replace("|", "/")
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
             "<h1>wayfare: checks</h1><table><tr>",
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
