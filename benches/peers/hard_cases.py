"""Runs hard cases of constrained mechanics with other tools, and writes what became of them.

python benches/peers/hard_cases.py                    # all, then results.json, the page and the picture
python benches/peers/hard_cases.py --case roof --tool notebook
python benches/peers/hard_cases.py --page             # the page and the picture again, from results.json
"""

import argparse
import datetime
import importlib.metadata
import json
import math
import multiprocessing
import platform
import time
import warnings
from pathlib import Path

import numpy as np

HERE = Path(__file__).resolve().parent
RESULTS = HERE / "results.json"
LIMIT = 45.0
"""Seconds that all starts of one case may take with one tool."""
KINDS = ["right", "error", "hang", "goes on", "wrong"]
"""How a run can end; several starts are summed up by the last kind that any of them ended in."""
PACKAGES = ["numpy", "scipy", "sympy", "mici", "mujoco", "scikit-sundae"]


class OutOfTime(Exception):
    pass


class Record:
    """What a tool shows, until its time is up."""

    def __init__(self, deadline):
        self.deadline = deadline
        self.times, self.places, self.velocities = [], [], []

    def __call__(self, t, q, v):
        self.times.append(t)
        self.places.append(np.array(q, dtype=float))
        self.velocities.append(np.array(v, dtype=float))
        self.look_at_clock()

    def look_at_clock(self):
        if time.monotonic() > self.deadline:
            raise OutOfTime


def run_start(case, tool, start, deadline):
    """One motion: how it ended, and what of the truth it left first."""
    record = Record(deadline)
    outcome, message = "right", None
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        try:
            tool(case, *[x.astype(float) for x in start], record)
        except OutOfTime:
            outcome, message = "hang", f"no end after {LIMIT:g} s"
        except Exception as error:
            outcome, message = "error", f"{type(error).__name__}: {error}"
    said = sorted(
        {
            f"{type(w).__name__ if not hasattr(w, 'category') else w.category.__name__}: {w.message}"
            for w in said
        }
    )
    worst, first = {}, None
    if record.times:
        with np.errstate(all="ignore"):
            measures = case.truth(*map(np.array, (record.times, record.places, record.velocities)))
        for name, values in measures.items():
            off = np.where(np.isfinite(values), values, np.inf)
            worst[name] = float(off.max() * case.units[name])
            if off.max() > 1:
                at = int(np.argmax(off > 1))
                if first is None or at < first["step"]:
                    first = {
                        "step": at,
                        "t": float(record.times[at]),
                        "measure": name,
                        "value": float(off[at] * case.units[name]),
                    }
    if first:
        outcome = "wrong"
    elif case.no_motion:
        outcome = {"error": "right", "right": "goes on"}.get(outcome, outcome)
    return {
        "outcome": outcome,
        "message": message,
        "warnings": said,
        "worst": worst,
        "left": first,
        "samples": len(record.times),
    }


def run_one(case_name, tool_name):
    import cases
    import tools

    case = next(c for c in cases.CASES if c.name == case_name)
    case.functions
    begin = time.monotonic()
    runs = [run_start(case, tools.TOOLS[tool_name][1], start, begin + LIMIT) for start in case.starts]
    counts = {kind: sum(r["outcome"] == kind for r in runs) for kind in KINDS}
    verdict = next(kind for kind in reversed(KINDS) if counts[kind])
    shown = next(r for r in runs if r["outcome"] == verdict)
    worst = {}
    for r in runs:
        for name, value in r["worst"].items():
            worst[name] = max(value, worst.get(name, 0.0))
    return {
        "case": case_name,
        "tool": tool_name,
        "verdict": verdict,
        "counts": counts,
        "worst": worst,
        "example": {k: shown[k] for k in ("message", "warnings", "left", "samples")},
        "seconds": round(time.monotonic() - begin, 2),
    }


def child(pair, answer):
    answer.send(run_one(*pair))


def nothing(pair, message, verdict):
    """The row of a process that had to be ended, or that ended itself."""
    example = {"message": message, "warnings": [], "left": None, "samples": 0}
    return {
        "case": pair[0], "tool": pair[1], "verdict": verdict, "counts": {verdict: 1}, "worst": {},
        "example": example, "seconds": LIMIT,
    }  # fmt: skip


def rows_of(pairs, workers):
    """Each pair in a process of its own, so many at a time."""
    fork = multiprocessing.get_context("fork")
    waiting, running = list(pairs), []
    while waiting or running:
        while waiting and len(running) < workers:
            receive, send = fork.Pipe(duplex=False)
            process = fork.Process(target=child, args=(waiting[0], send))
            process.start()
            send.close()
            running.append((waiting.pop(0), process, receive, time.monotonic() + LIMIT + 30))
        time.sleep(0.02)
        for one in list(running):
            pair, process, receive, deadline = one
            if receive.poll():
                try:
                    row = receive.recv()
                except EOFError:
                    process.join()
                    row = nothing(pair, f"the process ended with {process.exitcode}", "error")
            elif time.monotonic() > deadline:
                process.kill()
                row = nothing(pair, f"no end after {LIMIT + 30:g} s", "hang")
            else:
                continue
            process.join()
            running.remove(one)
            print(f"{pair[0]:24} {pair[1]:18} {row['verdict']:6} {row['seconds']:7.1f} s", flush=True)
            yield row


def run_all(workers, only):
    import mici  # noqa: F401  (here, not in each process)
    import sksundae  # noqa: F401

    import cases
    import tools

    for case in cases.CASES:
        case.functions
    order = [(c.name, t) for c in cases.CASES for t in tools.TOOLS if tools.applies(c, t)]
    pairs = [pair for pair in order if not only or set(only) & set(pair)]
    if any(tool == "ours" for _, tool in pairs):
        tools.program()
    rows = {}
    if only and RESULTS.exists():
        rows = {(r["case"], r["tool"]): r for r in json.loads(RESULTS.read_text())["rows"]}
    about = {
        "python": platform.python_version(),
        "limit_s": LIMIT,
        "command": "python benches/peers/hard_cases.py",
        "versions": {p: importlib.metadata.version(p) for p in PACKAGES},
    }
    for row in rows_of(pairs, workers):
        rows[row["case"], row["tool"]] = {**row, "date": datetime.date.today().isoformat()}
        kept = [rows[pair] for pair in order if pair in rows]
        RESULTS.write_text(
            json.dumps(finite({"about": about, "rows": kept}), indent=1, allow_nan=False) + "\n"
        )


def finite(value):
    """JSON has no infinity."""
    if isinstance(value, dict):
        return {k: finite(v) for k, v in value.items()}
    if isinstance(value, list):
        return [finite(v) for v in value]
    return str(value) if isinstance(value, float) and not math.isfinite(value) else value


def main():
    arguments = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    arguments.add_argument("--case", help="one case, with --tool")
    arguments.add_argument("--tool", help="one tool, with --case")
    arguments.add_argument(
        "--only", nargs="+", help="all rows of these cases or tools again, others as in results.json"
    )
    arguments.add_argument("--page", action="store_true", help="write page and picture from results.json")
    arguments.add_argument("--workers", type=int, default=1, help="runs side by side")
    given = arguments.parse_args()
    if given.case and given.tool:
        print(json.dumps(finite(run_one(given.case, given.tool))))
        return
    if not given.page:
        run_all(given.workers, given.only)
    import page

    page.write(json.loads(RESULTS.read_text()))


if __name__ == "__main__":
    main()
