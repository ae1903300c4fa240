"""The tools, each moved as its documentation says: `tool(case, q, v, record)` shows every sample to `record`.

A tool that fails raises; what it had shown before counts all the same.
"""

import functools
import json
import os
import subprocess
import tempfile
import time
from pathlib import Path

import numpy as np
import scipy.integrate
import scipy.linalg
import scipy.optimize

import lammps_input
import mujoco_models


class ToolError(Exception):
    """What a tool reports by a status instead of an exception."""


def notebook(case, q, v, record):
    """RATTLE as in the notebook "Billiards on surfaces": `scipy.optimize.root` from the last multiplier, the result
    taken without a look at its status; normal equations for the momenta."""
    f, h, w = case.functions, case.h, case.functions.inverse_masses

    def tangent(q, v):
        jacobian = f.jacobian(q)
        mu = scipy.linalg.solve(jacobian @ (w[:, None] * jacobian.T), jacobian @ v, assume_a="pos")
        return v - w * (mu @ jacobian)

    v = tangent(q, v)
    multiplier = np.zeros(len(case.constraints))
    record(0.0, q, v)
    for i in range(case.steps):
        jacobian, force = f.jacobian(q), f.force(q)
        half = lambda m: v + 0.5 * h * w * (force - m @ jacobian)
        multiplier = scipy.optimize.root(lambda m: f.g(q + h * half(m)), multiplier).x
        middle = half(multiplier)
        q = q + h * middle
        v = tangent(q, middle + 0.5 * h * w * f.force(q))
        record((i + 1) * h, q, v)


def index_reduced(case):
    """q̈ with the multipliers from g̈ = 0, by least squares, so that equations may depend on each other."""
    f, w, n = case.functions, case.functions.inverse_masses, len(case.variables)

    def accelerations(q, v):
        jacobian, free = f.jacobian(q), w * f.force(q)
        right = jacobian @ free + f.bend(q, v)
        if len(right) == 1:
            row = jacobian[0]
            multiplier = right / (row @ (w * row))
        else:
            multiplier = np.linalg.lstsq(jacobian @ (w[:, None] * jacobian.T), right, rcond=1e-12)[0]
        return free - w * (multiplier @ jacobian), multiplier

    return lambda t, y: np.concatenate([y[n:], accelerations(y[:n], y[n:])[0]]), accelerations


def project(case, q, v):
    """Back onto the constraints by Newton's method, and the momenta onto the tangent space."""
    f, w = case.functions, case.functions.inverse_masses
    for _ in range(10):
        jacobian = f.jacobian(q)
        off = w * (np.linalg.lstsq(jacobian @ (w[:, None] * jacobian.T), f.g(q), rcond=1e-12)[0] @ jacobian)
        q = q - off
        if np.linalg.norm(off) <= 1e-14 * max(case.length, np.linalg.norm(q)):
            break
    jacobian = f.jacobian(q)
    return q, v - w * (
        np.linalg.lstsq(jacobian @ (w[:, None] * jacobian.T), jacobian @ v, rcond=1e-12)[0] @ jacobian
    )


def tolerances(case, q, v, relative):
    """Relative to the length of the case where that is above rounding; SciPy takes no rtol below 100 roundings."""
    farthest = np.max(np.abs(q))
    length = max(relative * case.length, 8 * np.finfo(float).eps * farthest)
    speed = length / case.length * max(1.0, np.max(np.abs(v)))
    rtol = max(relative * min(1.0, case.length / farthest), 2.3e-14)
    return rtol, np.concatenate([np.full(len(q), length), np.full(len(v), speed)])


def scipy_ode(method, relative=None, projected=False):
    """The loop of `solve_ivp` around its own solver, as a loop of its own to project after each step."""

    def tool(case, q, v, record):
        n = len(q)
        rates, _ = index_reduced(case)
        options = {}
        if relative:
            options["rtol"], options["atol"] = tolerances(case, q, v, relative)
        solver = method(rates, 0.0, np.concatenate([q, v]), case.h * case.steps, **options)
        record(0.0, q, v)
        while solver.status == "running":
            message = solver.step()
            if solver.status == "failed":
                raise ToolError(message)
            if projected:
                solver.y = np.concatenate(project(case, solver.y[:n], solver.y[n:]))
                solver.f = rates(solver.t, solver.y)
            record(solver.t, solver.y[:n].copy(), solver.y[n:].copy())

    return tool


def ida(case, q, v, record):
    """SUNDIALS IDA by scikit-sundae: the equations of index 1 as a DAE, multipliers in units of their normals."""
    from sksundae.ida import IDA

    f, w, n = case.functions, case.functions.inverse_masses, len(q)
    unit = np.linalg.norm(f.jacobian(q), axis=1)
    _, accelerations = index_reduced(case)

    def residual(t, y, yp, res):
        record.look_at_clock()
        at, going, multiplier = y[:n], y[n : 2 * n], y[2 * n :] / unit
        jacobian = f.jacobian(at)
        change = w * (f.force(at) - multiplier @ jacobian)
        res[:n] = yp[:n] - going
        res[n : 2 * n] = yp[n : 2 * n] - change
        res[2 * n :] = (jacobian @ change + f.bend(at, going)) / unit

    first, multiplier = accelerations(q, v)
    y0 = np.concatenate([q, v, multiplier * unit])
    yp0 = np.concatenate([v, first, np.zeros(len(unit))])
    rtol, atol = tolerances(case, q, v, 1e-8)
    atol = np.concatenate([atol, np.full(len(unit), 1e-8 * max(1.0, np.max(np.abs(multiplier * unit))))])
    solver = IDA(
        residual, rtol=rtol, atol=atol, algebraic_idx=list(range(2 * n, len(y0))), max_num_steps=10_000
    )
    # In pieces, so that what it did before it fails is seen.
    times = case.h * np.arange(case.steps + 1)
    record(0.0, q, v)
    yy, yyp = y0, yp0
    for begin in range(0, case.steps, 1000):
        solution = solver.solve(times[begin : begin + 1001], yy, yyp)
        for t, y in zip(solution.t[1:], solution.y[1:]):
            record(t, y[:n], y[n : 2 * n])
        if not solution.success:
            raise ToolError(str(solution.message))
        yy, yyp = solution.y[-1], solution.yp[-1]


def mici(tuned):
    """Mici's `ConstrainedLeapfrogIntegrator` with Newton's method and its check of reversibility: with its own
    tolerances, or with tolerances in the units of the case."""

    def tool(case, q, v, record):
        from mici.integrators import ConstrainedLeapfrogIntegrator
        from mici.states import ChainState
        from mici.systems import DenseConstrainedEuclideanMetricSystem

        f, masses = case.functions, np.array(case.masses)
        system = DenseConstrainedEuclideanMetricSystem(
            neg_log_dens=f.potential,
            constr=f.g,
            metric=masses,
            dens_wrt_hausdorff=True,
            grad_neg_log_dens=lambda at: -f.force(at),
            jacob_constr=f.jacobian,
        )
        options = {}
        if tuned:
            length = max(1e-12 * case.length, 8 * np.finfo(float).eps * np.max(np.abs(q)))
            slope = np.max(np.linalg.norm(f.jacobian(q), axis=1))
            options = {
                "reverse_check_tol": 100 * length,
                "projection_solver_kwargs": {
                    "constraint_tol": length * slope,
                    "position_tol": length,
                    "divergence_tol": 1e10 * slope,
                },
            }
        integrator = ConstrainedLeapfrogIntegrator(system, step_size=case.h, **options)
        state = ChainState(pos=q.copy(), mom=masses * v, dir=1)
        record(0.0, q, v)
        for i in range(case.steps):
            state = integrator.step(state)
            record((i + 1) * case.h, state.pos.copy(), state.mom / masses)

    return tool


def mujoco(case, q, v, record):
    """MuJoCo with RK4: joints where the mechanism has them, equality constraints (soft ones) else."""
    mujoco_models.run(case, q, v, record)


def lammps(case, q, v, record):
    """`fix nve/manifold/rattle` of the program that `lammps.sh` builds, with the tolerance of its documentation. What
    it dumps after each step is read when it has ended, or its time is up."""
    more = f"""dump each all custom 1 steps.txt x y z vx vy vz\ndump_modify each format float %.17g
        timestep {case.h!r}\nrun {case.steps}"""
    with tempfile.TemporaryDirectory() as folder:
        lammps_input.write(Path(folder), q, v, f"1e-8 100 {case.lammps}", more)
        command = [os.environ.get("LAMMPS", "lmp_serial"), "-in", "in.txt", "-log", "none"]
        done = None
        try:
            left = record.deadline - time.monotonic()
            done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=left)
        except subprocess.TimeoutExpired:
            pass
        dump = Path(folder) / "steps.txt"
        # A block of each step: nine lines of headings, and the one particle; none where it is lost.
        lines = iter(dump.read_text().splitlines() if dump.exists() else [])
        for line in lines:
            if line == "ITEM: TIMESTEP":
                step = int(next(lines))
            elif line.startswith("ITEM: ATOMS"):
                state = np.array(next(lines, "").split(), dtype=float)
                if len(state) == 6:
                    record(step * case.h, state[:3], state[3:])
    if done is None:
        record.look_at_clock()
    elif done.returncode:
        said = (done.stdout + done.stderr).strip().splitlines()
        raise ToolError(next((line for line in said if "ERROR" in line), said[-1]))


@functools.cache
def program():
    """Builds `ours.rs`, unless whoever started this process has done so."""
    if "RATTLE_PEERS" not in os.environ:
        command = ["cargo", "build", "--release", "--bench", "peers", "--message-format", "json"]
        built = subprocess.run(
            command, cwd=Path(__file__).parent, stdout=subprocess.PIPE, text=True, check=True
        ).stdout
        made = [json.loads(line).get("executable") for line in built.splitlines() if line.startswith("{")]
        os.environ["RATTLE_PEERS"] = next(path for path in reversed(made) if path)
    return os.environ["RATTLE_PEERS"]


def ours(case, q, v, record):
    """RATTLE of this library, as it comes; linked bodies are points in a plane, a crank's slider has a y of 0."""
    n = len(q)
    flat = n == 3 and case.program[0] == "crank"
    whole = lambda x: np.append(x, 0.0) if flat else x
    model, *parameters = case.program
    groups = [parameters, [case.potential != 0, case.h, case.steps], whole(q), whole(v)]
    command = [program(), model]
    for i, group in enumerate(groups):
        command += ["--"] * (i > 0) + [repr(float(x)) for x in group]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        try:
            for step, line in enumerate(process.stdout):
                if line.startswith("error: "):
                    raise ToolError(line.removeprefix("error: ").strip())
                state = np.array([float(x) for x in line.split()])
                record(step * case.h, *(part[:n] for part in np.split(state, 2)))
        finally:
            process.kill()
    if process.returncode > 0:
        raise ToolError(f"the process ended with {process.returncode}")


TOOLS = {
    "notebook": ("notebook's RATTLE", notebook),
    "dop853": ("SciPy DOP853, defaults", scipy_ode(scipy.integrate.DOP853)),
    "dop853-fine": ("SciPy DOP853, rtol 1e-10", scipy_ode(scipy.integrate.DOP853, 1e-10)),
    "dop853-projected": ("the same, projected", scipy_ode(scipy.integrate.DOP853, 1e-10, projected=True)),
    "radau": ("SciPy Radau, rtol 1e-8", scipy_ode(scipy.integrate.Radau, 1e-8)),
    "ida": ("IDA, rtol 1e-8", ida),
    "mici": ("Mici, defaults", mici(tuned=False)),
    "mici-tuned": ("Mici, scaled tolerances", mici(tuned=True)),
    "mujoco": ("MuJoCo, RK4", mujoco),
    "lammps": ("LAMMPS, manifold/rattle", lammps),
    "ours": ("this library's RATTLE", ours),
}


def applies(case, tool):
    return {"mujoco": case.mujoco, "lammps": case.lammps}.get(tool, "any") is not None
