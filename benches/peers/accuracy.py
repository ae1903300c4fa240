"""Error over time of peers on the billiard on a lemniscate tube under gravity, beside this library's.

    cargo run --release --example accuracy            # ours: out/accuracy/lemniscate.csv
    VENV/bin/python benches/peers/accuracy.py         # two minutes; prints a table, writes docs/accuracy/peers.svg

All start where the reference with 30 digits starts (tests/data/lemniscate_gravity.csv), go to t = 5, and are judged there: an error is the
distance from it. Times are those of the processor for the process alone, the least of three runs, without imports and without set-up.

The equations, in plain floats, which here is several times as fast as arrays of three:

    f = (x² + y²)² − (x² − y²),   g = f² + z² − 1/36,   q̈ = −(0, 0, 1) − λ ∇g,   λ = (vᵀ g″ v − g_z)/|∇g|²
"""

import csv
import time
from pathlib import Path

import numpy as np
from scipy.integrate import solve_ivp

ROOT = Path(__file__).parents[2]
T, Z = 5.0, 1 / 6


def exact_and_start():
    with open(ROOT / "tests/data/lemniscate_gravity.csv") as file:
        rows = [r for r in csv.DictReader(file) if (r["theta_deg"], r["ic"], float(r["t"])) == ("45", "f64", T)]
    slanted = 0.5**0.5
    start = [0.0, 0.0, Z, slanted, float(np.nextafter(slanted, 0)), 0.0]
    return np.array([float(rows[0][k]) for k in "xyz"]), np.array(start)


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

    return run


def ida(start, tolerance):
    from sksundae.ida import IDA

    def residual(t, y, yp, res):
        at = y.tolist()
        (a, b, c), m = multiplier(at)
        k = at[6]
        res[:3] = yp[:3] - y[3:6]
        res[3], res[4], res[5] = yp[3] + k * a, yp[4] + k * b, yp[5] + 1 + k * c
        res[6] = k - m

    _, first = multiplier(start.tolist())
    y0 = np.append(start, first)
    yp0 = np.append(np.array(rates(0, start)), 0.0)
    solver = IDA(residual, rtol=tolerance, atol=tolerance, algebraic_idx=[6], max_num_steps=1_000_000)
    found = solver.solve(np.array([0.0, T]), y0, yp0)
    assert found.success, found.message
    return found.y[-1][:3]


def mici(start, h):
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
    steps = round(T / h)
    kwargs = {"constraint_tol": 1e-13, "position_tol": 1e-12}
    integrator = ConstrainedLeapfrogIntegrator(
        system, step_size=T / steps, reverse_check_tol=1e-8, projection_solver_kwargs=kwargs
    )
    state = ChainState(pos=start[:3].copy(), mom=start[3:].copy(), dir=1)
    for _ in range(steps):
        state = integrator.step(state)
    return state.pos


TOLERANCES = [10.0**-k for k in range(3, 15)]
PEERS = {
    "SciPy DOP853": (scipy_tool("DOP853"), TOLERANCES),
    "SciPy LSODA": (scipy_tool("LSODA"), TOLERANCES[:11]),
    "SciPy Radau": (scipy_tool("Radau"), TOLERANCES[:8]),
    "SUNDIALS IDA": (ida, TOLERANCES[:10]),
    "Mici, RATTLE": (mici, [0.02 / 2**k for k in range(6)]),
}


def measured():
    exact, start = exact_and_start()
    for name, (run, settings) in PEERS.items():
        for setting in settings:
            try:
                seconds = []
                for _ in range(3):
                    begun = time.process_time()
                    end = run(start, setting)
                    seconds.append(time.process_time() - begun)
            except Exception as error:  # what a peer cannot do is told
                print(f"{name:14} {setting:8.1e}  {type(error).__name__}: {error}"[:110])
                continue
            off, ns = np.linalg.norm(end - exact), 1e9 * min(seconds) / T
            print(f"{name:14} {setting:8.1e} {off:9.1e} {ns:13,.0f} ns", flush=True)
            yield name, off, ns


def ours():
    with open(ROOT / "out/accuracy/lemniscate.csv") as file:
        rows = [r for r in csv.DictReader(file) if r["front"] == "true"]
    return [(float(r["position"]), 1e9 * float(r["seconds"])) for r in rows]


def front(points):
    """What nothing cheaper is as exact as."""
    return [p for p in sorted(points, key=lambda p: p[1]) if all(q[0] > p[0] for q in points if q[1] < p[1])]


def main():
    import matplotlib

    matplotlib.use("svg")
    from matplotlib import pyplot as plt

    found = {}
    for name, off, ns in measured():
        found.setdefault(name, []).append((off, ns))
    mine = front(ours())
    print("\ndigits        ours  best peer  times as long")
    for digits in range(2, 13):
        least = lambda points: min((ns for off, ns in points if off <= 10.0**-digits), default=float("nan"))
        name, other = min(((n, least(p)) for n, p in found.items()), key=lambda x: (x[1] != x[1], x[1]))
        print(f"{digits:6} {least(mine):11,.0f} {other:13,.0f} {other / least(mine):8.0f}  {name}")
    plt.rcParams["svg.hashsalt"] = "accuracy"
    figure, axes = plt.subplots(figsize=(8, 6))
    axes.loglog([ns for _, ns in mine], [off for off, _ in mine], "ko-", label="this library, its front")
    for name, points in found.items():
        axes.loglog([ns for _, ns in points], [off for off, _ in points], "o-", label=name, markersize=4)
    axes.set(xlabel="nanoseconds for a unit of simulated time, one core", ylabel="error in position at t = 5")
    axes.set_title("A billiard on a surface of genus two under gravity")
    axes.grid(alpha=0.3)
    axes.legend()
    figure.savefig(ROOT / "docs/accuracy/peers.svg", metadata={"Date": None})


if __name__ == "__main__":
    main()
