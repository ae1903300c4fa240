"""Writes docs/hard-cases-elsewhere.md and its picture from what the runs gave; no figure is typed by hand."""

import contextlib
from pathlib import Path

import numpy as np

import cases
import tools

DOCS = Path(__file__).resolve().parents[2] / "docs"
PAGE = DOCS / "hard-cases-elsewhere.md"
PICTURE = DOCS / "hard-cases-elsewhere.svg"
PICTURED = "shells k=1000 h=0.05"
CELLS = {"right": "right", "wrong": "**wrong**", "goes on": "goes on", "error": "error", "hang": "no end"}

INTRODUCTION = """\
# Hard cases elsewhere

{number} hard cases, of the kinds of [those of this library](hard-cases.md), put to other tools and judged by what is true of
the motion: the distance from the sheet that it started on, its energy, and its exact path where there is one. The runs
are of {dates}, by

```sh
{command}
```

with Python {python},
{versions}.
How each tool is set, and what is not tried, says [benches/peers/README.md](../benches/peers/README.md); all figures
are in [results.json](../benches/peers/results.json).

* **right**: none of the measures below leaves its bound, or the case has no motion and the tool says so;
* **wrong**: one does, in a state that the tool hands out without a word;
* **goes on**: the case has no motion to the end, and the tool chooses one without a word;
* **error**: the tool stops, and up to there the motion was right;
* **no end**: {limit_s:g} s were not enough; **–**: the tool has no such thing as the case.

Where a case has twenty starts, figures say how many went so. Tools with steps of their own choice (SciPy, IDA)
are not bound by a case's h: steps that are long for others are theirs to cut.
"""


def write(results):
    about, rows = results["about"], results["rows"]
    found = {(r["case"], r["tool"]): r for r in rows}
    used = [t for t in tools.TOOLS if any(r["tool"] == t for r in rows)]
    versions = ", ".join(f"{name} {version}" for name, version in about["versions"].items())
    dates = " and ".join(sorted({row["date"] for row in rows}))
    out = [INTRODUCTION.format(**{**about, "versions": versions, "dates": dates, "number": len(cases.CASES)})]
    out.append("| case | " + " | ".join(tools.TOOLS[t][0] for t in used) + " |")
    out.append("|---|" + "---|" * len(used))
    for case in cases.CASES:
        out.append(
            f"| {case.title} | " + " | ".join(cell(case, t, found.get((case.name, t))) for t in used) + " |"
        )
    out.append(
        "| **right / wrong / goes on / error / no end** | " + " | ".join(sums(rows, t) for t in used) + " |"
    )
    if draw(used):
        out.append(f"\n![The distance from the origin among shells, by tool]({PICTURE.name})\n")
        out.append(
            f"*The twenty starts of “{title(PICTURED)}”: the distance of the particle from the origin. Grey lines are"
            " the sheets; the motion stays on the one at 1.*"
        )
    out.append("\n## Case by case\n")
    for case in cases.CASES:
        out.append(f"**{case.title[0].upper()}{case.title[1:]}.** {case.hard} {bounds(case)}\n")
        out += [
            f"* {tools.TOOLS[t][0]}: {told(case, found[case.name, t])}"
            for t in used
            if (case.name, t) in found
        ]
        if case.ours:
            out.append(f"* a test of this library: `{case.ours}`")
        out.append("")
    PAGE.write_text("\n".join(out).rstrip() + "\n")


def title(name):
    return next(c.title for c in cases.CASES if c.name == name)


def cell(case, tool, row):
    if row is None:
        return "not run" if tools.applies(case, tool) else "–"
    if len(case.starts) == 1 or row["verdict"] == "right":
        return CELLS[row["verdict"]]
    return ", ".join(f"{CELLS[kind]} {row['counts'][kind]}" for kind in CELLS if row["counts"].get(kind))


def sums(rows, tool):
    return " / ".join(str(sum(r["tool"] == tool and r["verdict"] == v for r in rows)) for v in CELLS)


def bounds(case):
    return "Bounds: " + ", ".join(f"{name} {unit:.2g}" for name, unit in case.units.items()) + "."


def told(case, row):
    example, starts = row["example"], len(case.starts)
    worst = ", ".join(f"{name} {float(value):.2g}" for name, value in row["worst"].items())
    many = f" in {row['counts'].get(row['verdict'], 0)} of {starts}" if starts > 1 else ""
    message = " ".join((example["message"] or "").split())
    message = message if len(message) <= 160 else message[:157] + "…"
    warned = f"; it warns: `{' '.join(example['warnings'][0].split())[:120]}`" if example["warnings"] else ""
    if row["verdict"] == "right":
        if case.no_motion:
            return f"right, an error: `{message}`"
        return f"right (largest: {worst}){warned}"
    if row["verdict"] == "goes on":
        return f"goes on (largest: {worst}){warned}"
    if row["verdict"] == "wrong":
        left = example["left"]
        later = f", and ends later with `{message}`" if message else ""
        return (
            f"wrong{many}: {left['measure']} {float(left['value']):.2g} at step {left['step']}, t = {left['t']:.3g}"
            f" (largest: {worst}){later}{warned}"
        )
    return (
        f"{CELLS[row['verdict']]}{many}: `{message}`" + (f" (until then: {worst})" if worst else "") + warned
    )


def draw(used):
    import matplotlib

    matplotlib.use("svg")
    matplotlib.rcParams["svg.hashsalt"] = "peers"
    import matplotlib.pyplot as plt

    case = next(c for c in cases.CASES if c.name == PICTURED)
    gap, end = case.units["distance"] * 4, 0.7
    figure, axes = plt.subplots(figsize=(7, 3.6))
    for sheet in range(-12, 13):
        axes.axhline(1 + sheet * gap, color="0.85", lw=0.6, zorder=0)
    for tool, colour in (("notebook", "tab:red"), ("ours", "tab:blue")):
        label = tools.TOOLS[tool][0]
        for start in case.starts if tool in used else []:
            radii, times = [], []

            def record(t, q, v, radii=radii, times=times):
                times.append(t)
                radii.append(np.linalg.norm(q))
                if t > end:
                    raise StopIteration

            with contextlib.suppress(Exception):  # what it showed until it failed is drawn
                tools.TOOLS[tool][1](case, *start, record)
            axes.plot(times, radii, ".-", ms=3, lw=0.8, color=colour, label=label)
            label = None
    axes.set(
        xlabel="t", ylabel="distance from the origin", xlim=(0, end), ylim=(1 - 12.5 * gap, 1 + 12.5 * gap)
    )
    axes.legend(fontsize=8, loc="upper left")
    figure.tight_layout()
    figure.savefig(PICTURE, metadata={"Date": None})
    return True
