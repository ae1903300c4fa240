"""Error over time of peers beside this library's: a billiard on a lemniscate tube under gravity, a pendulum, a torus.

    VENV/bin/python benches/peers/accuracy.py          # ours by `cargo run --example accuracy`, then the peers
    VENV/bin/python benches/peers/accuracy.py --kept   # ours as it lies in out/accuracy
    VENV/bin/python benches/peers/accuracy.py --page   # tables and picture again, from accuracy.csv

It prints tables and writes accuracy.csv and docs/accuracy/peers.svg. All start where a reference with 30 digits starts
(tests/data), go to t = 5, and are judged there: an error is the distance from it, before anything is timed; what is
further off than 0.1 is not timed. Times are those of the processor for the process alone, the least mean of three
batches, without imports, compilation and set-up; a peer that is not installed is left out by name.

The equations of the billiard, in plain floats, which here is several times as fast as arrays of three:

    f = (x² + y²)² − (x² − y²),   g = f² + z² − 1/36,   q̈ = −(0, 0, 1) − λ ∇g,   λ = (vᵀ g″ v − g_z)/|∇g|²
"""

import csv
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Callable

import compiled
import numpy as np
import others
from scipy.integrate import solve_ivp

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
T, Z = 5.0, 1 / 6


def reference(file, having, columns):
    with open(ROOT / "tests/data" / file) as rows:
        found = [r for r in csv.DictReader(rows) if all(r[k] == v for k, v in having.items()) and float(r["t"]) == T]
    return np.array([float(found[0][k]) for k in columns])


SLANTED = 0.5**0.5
SCENES = {
    "lemniscate": (
        "A billiard on a surface of genus two under gravity",
        reference("lemniscate_gravity.csv", {"theta_deg": "45", "ic": "f64"}, "xyz"),
        np.array([0.0, 0.0, Z, SLANTED, float(np.nextafter(SLANTED, 0)), 0.0]),
    ),
    "pendulum": (
        "A pendulum from 90°",
        reference("planar_pendulum.csv", {"theta0": "pi/2"}, "xy"),
        np.array([1.0, 0.0, 0.0, 0.0]),
    ),
    "torus": (
        "A geodesic on a torus",
        reference("torus_geodesic.csv", {"case": "30deg"}, "xyz"),
        np.array([1.3, 0.0, 0.0, 0.0, np.cos(np.pi / 6), np.sin(np.pi / 6)]),
    ),
}


def bend(x, y, z, u, v, w):
    """∇g, and vᵀ g″ v."""
    s = x * x + y * y
    f = s * s - (x * x - y * y)
    fx, fy = 4 * x * s - 2 * x, 4 * y * s + 2 * y
    along = fx * u + fy * v
    second = (4 * s + 8 * x * x - 2) * u * u + 16 * x * y * u * v + (4 * s + 8 * y * y + 2) * v * v
    return (2 * f * fx, 2 * f * fy, 2 * z), 2 * along * along + 2 * f * second + 2 * w * w


def multiplier(y):
    (a, b, c), curved = bend(*y[:6])
    return (a, b, c), (curved - c) / (a * a + b * b + c * c)


def rates(_, y):
    y = y.tolist()
    (a, b, c), m = multiplier(y)
    return [y[3], y[4], y[5], -m * a, -m * b, -1 - m * c]


def scipy_tool(method):
    def run(start, tolerance):
        found = solve_ivp(rates, (0, T), start, method=method, rtol=max(tolerance, 2.3e-14), atol=tolerance)
        assert found.success, found.message
        return found.y[:3, -1]

    return lambda: run


def ida():
    from sksundae.ida import IDA

    def residual(t, y, yp, res):
        at = y.tolist()
        (a, b, c), m = multiplier(at)
        k = at[6]
        res[:3] = yp[:3] - y[3:6]
        res[3], res[4], res[5] = yp[3] + k * a, yp[4] + k * b, yp[5] + 1 + k * c
        res[6] = k - m

    def run(start, tolerance):
        _, first = multiplier(start.tolist())
        y0 = np.append(start, first)
        yp0 = np.append(np.array(rates(0, start)), 0.0)
        solver = IDA(residual, rtol=tolerance, atol=tolerance, algebraic_idx=[6], max_num_steps=1_000_000)
        found = solver.solve(np.array([0.0, T]), y0, yp0)
        assert found.success, found.message
        return found.y[-1][:3]

    return run


def mici():
    from mici.integrators import ConstrainedLeapfrogIntegrator
    from mici.states import ChainState
    from mici.systems import DenseConstrainedEuclideanMetricSystem

    def g(q):
        x, y, z = q.tolist()
        s = x * x + y * y
        f = s * s - (x * x - y * y)
        return np.array([f * f + z * z - Z * Z])

    system = DenseConstrainedEuclideanMetricSystem(
        neg_log_dens=lambda q: q[2],
        constr=g,
        dens_wrt_hausdorff=True,
        grad_neg_log_dens=lambda q: np.array([0.0, 0.0, 1.0]),
        jacob_constr=lambda q: np.array([bend(*q.tolist(), 0, 0, 0)[0]]),
    )

    def run(start, h):
        steps = round(T / h)
        kwargs = {"constraint_tol": 1e-13, "position_tol": 1e-12}
        integrator = ConstrainedLeapfrogIntegrator(
            system, step_size=T / steps, reverse_check_tol=1e-8, projection_solver_kwargs=kwargs
        )
        state = ChainState(pos=start[:3].copy(), mom=start[3:].copy(), dir=1)
        for _ in range(steps):
            state = integrator.step(state)
        return state.pos

    return run


def notebook():
    """The RATTLE of the notebook "Billiards on surfaces", as in `tools.py`."""
    import cases
    import tools

    s, difference = cases.X**2 + cases.Y**2, cases.X**2 - cases.Y**2
    g = (s**2 - difference) ** 2 + cases.Z**2 - cases.sympy.Rational(1, 36)
    case = cases.Case("", "", "", [g], [], 0.0, 0, None, potential=cases.Z)

    def run(start, h):
        case.steps = round(T / h)
        case.h, last = T / case.steps, None

        def record(_, q, __):
            nonlocal last
            last = q

        tools.notebook(case, start[:3], start[3:], record)
        return last

    return run


@dataclass
class Peer:
    make: Callable
    settings: list
    compiled: bool = False
    structure: bool = False
    scene: str = "lemniscate"


def steps(first, times):
    return [first / 2**k for k in range(times)]


TOLERANCES = [10.0**-k for k in range(3, 15)]
ADAMS = {"linear_multistep_method": "adams", "nonlinear_solver_iteration": "functional"}
PEERS = {
    "SciPy DOP853": Peer(scipy_tool("DOP853"), TOLERANCES),
    "SciPy LSODA": Peer(scipy_tool("LSODA"), TOLERANCES[:11]),
    "SciPy Radau": Peer(scipy_tool("Radau"), TOLERANCES[:8]),
    "SUNDIALS IDA": Peer(ida, TOLERANCES[:10]),
    "Mici, RATTLE": Peer(mici, steps(0.02, 6), structure=True),
    "notebook, RATTLE": Peer(notebook, steps(0.02, 6), structure=True),
    "Numba, DOP853": Peer(compiled.numba_dop853, [*TOLERANCES, 1e-15], compiled=True),
    "Numba, SciPy odeint": Peer(compiled.numba_odeint, TOLERANCES[:11], compiled=True),
    "heyoka, Taylor": Peer(compiled.heyoka_taylor, [*TOLERANCES, 1e-15], compiled=True),
    "JAX, diffrax Dopri8": Peer(compiled.jax_diffrax, [*TOLERANCES, 1e-15], compiled=True),
    "CasADi, IDAS": Peer(compiled.casadi_sundials("idas", {}), TOLERANCES[:11], compiled=True),
    "CasADi, CVODES": Peer(compiled.casadi_sundials("cvodes", ADAMS), TOLERANCES[2:11], compiled=True),
    "Numba, RATTLE": Peer(compiled.numba_rattle(2), steps(0.04, 12), compiled=True, structure=True),
    "Numba, order 4": Peer(compiled.numba_rattle(4), steps(0.08, 10), compiled=True, structure=True),
    "Numba, order 6": Peer(compiled.numba_rattle(6), steps(0.08, 8), compiled=True, structure=True),
    "Numba, order 8": Peer(compiled.numba_rattle(8), steps(0.1, 7), compiled=True, structure=True),
    "MuJoCo RK4": Peer(others.mujoco("RK4"), steps(0.8, 11), compiled=True, scene="pendulum"),
    "MuJoCo implicitfast": Peer(others.mujoco("implicitfast"), steps(0.1, 10), compiled=True, scene="pendulum"),
    "Drake RK5, fixed": Peer(others.drake("runge_kutta5", True), steps(0.8, 9), compiled=True, scene="pendulum"),
    "Drake RK5": Peer(others.drake("runge_kutta5", False), TOLERANCES[:11], compiled=True, scene="pendulum"),
    "Drake RK3": Peer(others.drake("runge_kutta3", False), TOLERANCES[:8], compiled=True, scene="pendulum"),
    "LAMMPS manifold/rattle": Peer(others.lammps, steps(0.32, 15), compiled=True, structure=True, scene="torus"),
}


def seconds(run, start, setting):
    """For one run: the least mean of three batches of some 20 ms; what times itself is believed."""
    means = []
    if hasattr(run, "seconds"):
        for _ in range(3):
            run(start, setting)
            means.append(run.seconds)
        return min(means)
    count = 1
    while len(means) < 3:
        begun = time.process_time()
        for _ in range(count):
            run(start, setting)
        spent = time.process_time() - begun
        if spent < 0.02:
            count = int(count * min(10.0, 0.03 / max(spent, 1e-6))) + 1
        else:
            means.append(spent / count)
    return min(means)


def measured():
    """All runs of all peers: (scene, peer, setting, error, nanoseconds for a unit of time)."""
    for name, peer in PEERS.items():
        try:
            run = peer.make()
        except ImportError as missing:
            print(f"{name:22} left out: {missing}", flush=True)
            continue
        _, exact, start = SCENES[peer.scene]
        for setting in peer.settings:
            try:
                off = float(np.linalg.norm(run(start, setting) - exact))
                if not off <= 0.1:
                    print(f"{name:22} {setting:8.1e} {off:9.1e}  not timed", flush=True)
                    continue
                ns = 1e9 * seconds(run, start, setting) / T
            except Exception as error:  # what a peer cannot do is told
                print(f"{name:22} {setting:8.1e}  {type(error).__name__}: {error}"[:110].splitlines()[0], flush=True)
                continue
            print(f"{name:22} {setting:8.1e} {off:9.1e} {ns:13,.0f} ns", flush=True)
            yield peer.scene, name, setting, off, ns


def ours(scene):
    """What nothing cheaper of ours is as exact as, to 1e-15; an error here is the largest of the whole run."""
    with open(ROOT / f"out/accuracy/{scene}.csv") as file:
        rows = [(float(r["seconds"]), float(r["position"]), r["method"]) for r in csv.DictReader(file) if r["position"]]
    best = float("inf")
    for cost, off, method in sorted(rows):
        if off < best and best > 1e-15:
            best = off
            yield scene, "ours", method, off, 1e9 * cost


def tables(found):
    """For each scene and number of digits: ours, and the best of each kind of peer."""
    kinds = {
        "best that calls Python": lambda peer: not peer.compiled,
        "best compiled": lambda peer: peer.compiled,
        "best with structure": lambda peer: peer.structure,
    }
    for scene, (title, _, _) in SCENES.items():
        points = {}
        for _, name, _, off, ns in (row for row in found if row[0] == scene):
            points.setdefault(name, []).append((ns, off))
        if len(points) < 2:
            continue
        mine = points.pop("ours")
        least = lambda all_, digits: min((ns for ns, off in all_ if off <= 10.0**-digits), default=None)
        shown = {k: v for k, v in kinds.items() if {n for n in points if v(PEERS[n])} not in (set(), set(points))}
        shown = shown or {"best peer": lambda peer: True}
        print(f"\n{title}\n\n| digits | this library | {' | '.join(f'{k} | times as long' for k in shown)} |")
        print("|--:|--:|" + "---|--:|" * len(shown))
        for digits in range(2, 13):
            own, cells = least(mine, digits), []
            for wanted in shown.values():
                best = [(least(p, digits), n) for n, p in points.items() if wanted(PEERS[n])]
                best = min((b for b in best if b[0]), default=None)
                cells.append(f"{spaced(best[0])} {best[1]} | {ratio(best[0] / own)}" if best else "– | –")
            print(f"| {digits} | {spaced(own)} | {' | '.join(cells)} |")


def ratio(number):
    return spaced(number) if number >= 10 else f"{number:.2g}"


def spaced(number):
    return f"{number:,.0f}".replace(",", " ")


def draw(found):
    import matplotlib

    matplotlib.use("svg")
    from matplotlib import pyplot as plt

    plt.rcParams["svg.hashsalt"] = "accuracy"
    figure, grid = plt.subplot_mosaic(
        [["lemniscate"] * 2, ["pendulum", "torus"]], figsize=(9, 11), height_ratios=[7, 4], layout="constrained"
    )
    for scene, axes in grid.items():
        names = list(dict.fromkeys(row[1] for row in found if row[0] == scene))
        for i, name in enumerate(names):
            points = [(row[4], row[3]) for row in found if row[:2] == (scene, name)]
            if name == "ours":
                axes.loglog(*zip(*points), "ko-", label="this library, its front", linewidth=2)
                continue
            marker = "s" if PEERS[name].structure else "o"
            line = "-" if PEERS[name].compiled else ":"
            colour = plt.get_cmap("tab20")(2 * (i - 1) % 20 + (2 * (i - 1) >= 20))
            axes.loglog(*zip(*points), marker + line, label=name, markersize=4, color=colour)
        axes.set(xlabel="nanoseconds for a unit of simulated time, one core", ylabel="error in position at t = 5")
        axes.set_title(SCENES[scene][0])
        axes.grid(alpha=0.3)
        axes.set_ylim(bottom=1e-17)
        free = {"lemniscate": ((1.0, 0.0), "lower right"), "pendulum": ((0.24, 0.01), "lower left")}
        corner, where = free.get(scene, ((1.0, 1.0), "upper right"))
        axes.legend(fontsize=7.5, ncols=2 if len(names) > 8 else 1, bbox_to_anchor=corner, loc=where)
    told = "squares keep the structure; dotted lines call Python for each evaluation; "
    told += "errors of this library are the largest of the run"
    figure.text(0.01, -0.02, told, fontsize=9)
    figure.savefig(ROOT / "docs/accuracy/peers.svg", metadata={"Date": None}, bbox_inches="tight")


def main():
    kept = HERE / "accuracy.csv"
    if "--page" not in sys.argv:
        if "--kept" not in sys.argv:
            command = ["cargo", "run", "--release", "--example", "accuracy"]
            subprocess.run(command, cwd=ROOT, check=True, stdout=subprocess.DEVNULL)
        rows = [*(row for scene in SCENES for row in ours(scene)), *measured()]
        with open(kept, "w", newline="") as file:
            out = csv.writer(file, lineterminator="\n")
            out.writerow(["scene", "peer", "setting", "error", "ns"])
            out.writerows([*row[:3], f"{row[3]:.3e}", f"{row[4]:.1f}"] for row in rows)
    with open(kept) as file:
        found = [(r["scene"], r["peer"], r["setting"], float(r["error"]), float(r["ns"])) for r in csv.DictReader(file)]
    tables(found)
    draw(found)


if __name__ == "__main__":
    main()
