"""The hard cases: what moves, from where, and what is true of the motion whatever tool moves it.

A case is written as formulas; SymPy differentiates them for all tools alike. What judges a run knows no tool: exact
distances from the sheet that the motion started on, the energy, and the exact path where there is one.
"""

from dataclasses import dataclass, field
from functools import cached_property
from typing import Callable

import numpy as np
import sympy
from scipy.integrate import solve_ivp

X, Y, Z = SPACE = sympy.symbols("x y z", real=True)
NEAR = 0.01
"""Distances below this, as parts of the length of the case, are right (a quarter of the gap between shells is)."""

RADIUS = sympy.sqrt(X**2 + Y**2 + Z**2)


@dataclass
class Case:
    """One scene, its starts and its truth.

    `truth(t, q, v)` gives, for all samples of one run, arrays of what has to be small, by name, each as a multiple of
    what is still right: a run is right where none of them is above 1.
    """

    name: str
    title: str
    hard: str
    """Why the case is hard: the sentence below the table."""
    constraints: list
    starts: list
    h: float
    steps: int
    truth: Callable
    variables: tuple = SPACE
    masses: tuple = (1.0, 1.0, 1.0)
    potential: object = sympy.Integer(0)
    length: float = 1.0
    """The length that tolerances are relative to."""
    no_motion: bool = False
    """The mathematics has no motion to the end of the run: an error is the right answer."""
    mujoco: str | None = None
    """Which MuJoCo model is the same mechanism, if there is one."""
    lammps: str | None = None
    """The same surface as a manifold of LAMMPS, if there is one; without forces."""
    program: tuple = ()
    """The model of `ours.rs` that is the same, and its parameters."""
    ours: str = ""
    """The test of this library that looks at the case."""
    units: dict = field(default_factory=dict)
    """What one unit of each measure of `truth` is, to show the figures themselves."""

    @cached_property
    def functions(self):
        return Functions(self)


class Functions:
    """Values and derivatives of a case, as fast as plain Python has them."""

    def __init__(self, case):
        q = case.variables
        v = sympy.symbols(f"v0:{len(q)}", real=True)
        g = sympy.Matrix(case.constraints)
        jacobian = g.jacobian(q)
        bend = [sum(sympy.diff(e, a, b) * s * t for a, s in zip(q, v) for b, t in zip(q, v)) for e in g]
        bend = [e.replace(sympy.DiracDelta, lambda *_: sympy.Integer(0)) for e in bend]
        force = [-sympy.diff(case.potential, a) for a in q]
        compile_ = lambda arguments, what: sympy.lambdify(arguments, what, modules="math", cse=True)
        value, rows = compile_(q, list(g)), compile_(q, jacobian.tolist())
        second, push, height = compile_((*q, *v), bend), compile_(q, force), compile_(q, case.potential)
        self.inverse_masses = 1.0 / np.array(case.masses)
        self.g = lambda at: np.array(value(*at), dtype=float)
        self.jacobian = lambda at: np.array(rows(*at), dtype=float)
        self.bend = lambda at, going: np.array(second(*at, *going), dtype=float)
        self.force = lambda at: np.array(push(*at), dtype=float)
        self.potential = lambda at: float(height(*at))

    def energies(self, q, v):
        kinetic = 0.5 * np.sum(v**2 / self.inverse_masses, axis=1)
        return kinetic + np.array([self.potential(at) for at in q])


def energy(case, q, v, scale, bound):
    """How far the energy is from that of the start."""
    energies = case.functions.energies(q, v)
    return np.abs(energies - energies[0]) / (scale * bound)


def random_tangents(count, speed):
    random = np.random.default_rng(1)
    starts = []
    for _ in range(count):
        q = random.normal(size=3)
        q /= np.linalg.norm(q)
        v = np.cross(random.normal(size=3), q)
        starts.append((q, speed * v / np.linalg.norm(v)))
    return starts


def shells(k, h):
    gap = np.pi / k
    case = Case(
        f"shells k={k:g} h={h:g}",
        f"shells sin({k:g}(abs(q) - 1)) under gravity, h = {h:g}",
        f"The next sheets are {gap:.1e} away and a step sags by up to {h * h:.1e}.",
        [sympy.sin(k * (RADIUS - 1))],
        random_tangents(20, 1.0),
        h,
        200,
        None,
        potential=Z,
        program=("shells", k),
        ours="optimised/tests/sheets.rs",
        units={"distance": gap / 4, "energy": 0.25},
    )
    case.truth = lambda t, q, v: {
        "distance": np.abs(np.linalg.norm(q, axis=1) - 1) / (gap / 4),
        "energy": energy(case, q, v, 1.0, 0.25),
    }
    return case


def three_shells(gap=1e-3, h=0.2):
    off = RADIUS - 1
    case = Case(
        "three shells",
        f"three shells {gap:g} apart, h = {h:g}",
        "The cubic has three roots along the normal, and the guess of a step is nearer to a wrong one.",
        [off * (off - gap) * (off + gap)],
        random_tangents(20, 1.0),
        h,
        200,
        None,
        potential=Z,
        program=("three shells", gap),
        ours="optimised/tests/sheets.rs",
        units={"distance": gap / 4, "energy": 0.25},
    )
    case.truth = lambda t, q, v: {
        "distance": np.abs(np.linalg.norm(q, axis=1) - 1) / (gap / 4),
        "energy": energy(case, q, v, 1.0, 0.25),
    }
    return case


def tube(minor, way, h):
    around = way == "around"
    case = Case(
        f"torus {minor:g} {way}",
        f"torus of minor radius {minor:g}, {way} the tube, h = {h:g}",
        "g is as small as the square of the minor radius, so that tolerances on g let go of the tube."
        if around
        else "A step sags by more than the tube is thick.",
        [(sympy.sqrt(X**2 + Y**2) - 1) ** 2 + Z**2 - minor**2],
        [(np.array([1 + minor, 0, 0]), np.array([0.0, 0.0, 1.0] if around else [0.0, 1.0, 0.0]))],
        h,
        1000,
        None,
        length=minor,
        lammps=f"torus 1.0 {minor!r}",
        program=("torus", minor),
        ours="optimised/tests/hard_cases.rs, thin_tube_keeps_its_particle",
        units={"distance": NEAR * minor, "energy": 0.05},
    )

    def truth(t, q, v):
        rho = np.hypot(q[:, 0], q[:, 1]) - 1
        return {
            "distance": np.abs(np.hypot(rho, q[:, 2]) - minor) / (NEAR * minor),
            "energy": energy(case, q, v, 0.5, 0.05 / 0.5),
        }

    case.truth = truth
    return case


def pinch(angle):
    straight = angle == 0
    f = (X**2 + Y**2) ** 2 - (X**2 - Y**2)
    case = Case(
        "pinch" if straight else "past the pinch",
        "lemniscate surface, straight to its pinch"
        if straight
        else f"lemniscate surface, past its pinch ({angle:g} rad beside), h = 0.01",
        "The normal is zero where the two halves meet: no force is defined there, and more than one path leads on."
        if straight
        else "The curvature is without bound near the pinch, and so is the energy that a step can make.",
        [f**2 + Z**2 - sympy.Rational(1, 16)],
        [(np.array([0, 0, 0.25]), np.array([np.cos(angle), np.sin(angle), 0.0]))],
        0.01,
        200,
        None,
        no_motion=straight,
        program=("pinch",),
        ours="tests/singular_points.rs, a_pinch_gives_no_energy",
        units={"distance": NEAR, "energy": 0.05},
    )

    def truth(t, q, v):
        """|g| / |∇g| is the distance to first order, and at the pinch itself |g| counts."""
        off = [
            abs(case.functions.g(at)[0]) / (np.linalg.norm(case.functions.jacobian(at)) + 1e-3) for at in q
        ]
        return {"distance": np.array(off) / NEAR, "energy": energy(case, q, v, 0.5, 0.1)}

    case.truth = truth
    return case


def cone(beside):
    """A cone of half angle 45°; unrolled, its geodesics are straight, and its angle is √2 times smaller."""
    straight = beside == 0
    start = np.array([1.0, 0.0, 1.0])
    along = np.array([-1.0, 0.0, -1.0]) / np.sqrt(2)
    aside = beside / np.sqrt(2)  # the distance from the apex at which a straight line passes
    v = np.sqrt(1 - aside**2) * along + aside * np.array([0.0, 1.0, 0.0])
    case = Case(
        "apex" if straight else "past the apex",
        "cone, straight to its apex"
        if straight
        else f"cone, past its apex at a distance of {beside:g}, h = 0.01",
        "The normal is zero at the apex: no force is defined there, and every line of the cone leads on."
        if straight
        else "The exact path, straight on the unrolled cone, turns within a distance of a tenth of a step.",
        [Z**2 - X**2 - Y**2],
        [(start, v)],
        0.01,
        300,
        None,
        no_motion=straight,
        program=("cone",),
        ours="tests/singular_points.rs, an_apex_is_not_gone_through",
        units={"energy": 0.05, "path": 0.05},
    )

    def truth(t, q, v):
        far = np.sqrt(2.0)
        across, down = aside * t, far - np.sqrt(1 - aside**2) * t
        distance, turned = np.hypot(across, down), np.arctan2(across, down) * np.sqrt(2)
        path = (
            distance[:, None]
            / np.sqrt(2)
            * np.stack([np.cos(turned), np.sin(turned), np.ones_like(t)], axis=1)
        )
        off = np.linalg.norm(q - path, axis=1) / 0.05
        return {"energy": energy(case, q, v, 0.5, 0.1), **({} if straight else {"path": off})}

    case.truth = truth
    return case


def octahedron():
    """Over its edge onto the next face: on the surface unrolled the path is straight, and the speed stays."""
    normal = np.ones(3) / np.sqrt(3)
    v = np.array([-1.0, 0.3, 0.0])
    v -= v @ normal * normal
    v /= np.linalg.norm(v)
    case = Case(
        "octahedron",
        "octahedron abs(x) + abs(y) + abs(z) = 1, over an edge, h = 0.01",
        "The normal jumps at the edge, and momenta that are put off one face are not of the speed on the next.",
        [abs(X) + abs(Y) + abs(Z) - 1],
        [(np.array([0.3, 0.4, 0.3]), v)],
        0.01,
        300,
        None,
        program=("octahedron",),
        ours="tests/kinks.rs, edges_of_polyhedra_are_errors",
        units={"distance": NEAR, "energy": 5e-3},
    )
    case.truth = lambda t, q, v: {
        "distance": np.abs(np.abs(q).sum(axis=1) - 1) / np.sqrt(3) / NEAR,
        "energy": energy(case, q, v, 0.5, 0.01),
    }
    return case


def roof():
    slope = np.sqrt(1.25)
    case = Case(
        "roof",
        "roof z + 0.5 abs(x) = 0, over its ridge, h = 0.01",
        "The normal turns by 53 degrees in one step at the ridge.",
        [Z + abs(X) / 2],
        [(np.array([-0.503, 0.0, -0.2515]), np.array([1.0, 0.0, 0.5]) / slope)],
        0.01,
        150,
        None,
        program=("roof",),
        ours="tests/kinks.rs, the_step_across_a_ridge_is_an_error",
        units={"energy": 5e-3, "path": 0.02},
    )

    def truth(t, q, v):
        x = -0.503 + t / slope
        path = np.stack([x, np.zeros_like(x), -np.abs(x) / 2], axis=1)
        return {"energy": energy(case, q, v, 0.5, 0.01), "path": np.linalg.norm(q - path, axis=1) / 0.02}

    case.truth = truth
    return case


def sphere(name, title, hard, *, h, steps, scale=1, centre=0, gravity=False, path=None, **more):
    """A particle on a unit sphere, as c·(|q − centre|² − 1) = 0."""
    g = scale * ((X - centre) ** 2 + Y**2 + Z**2 - 1)
    at = np.array([centre + 0.6, 0.0, -0.8])
    case = Case(
        name,
        title,
        hard,
        [g],
        [(at, np.array([0.0, 1.0, 0.0]))],
        h,
        steps,
        None,
        potential=Z if gravity else sympy.Integer(0),
        mujoco="ball",
        lammps=None if gravity or centre or scale != 1 else "sphere 1.0",
        program=("sphere", scale, centre),
        **more,
    )
    case.units = {"distance": NEAR, "energy": 0.01, **({} if gravity else {"plane": NEAR})}
    if path:
        case.units["path"] = path

    def truth(t, q, v):
        off = q - [centre, 0.0, 0.0]
        measures = {
            "distance": np.abs(np.linalg.norm(off, axis=1) - 1) / NEAR,
            "energy": energy(case, off + [centre, 0, 0], v, 0.5, 0.02),
        }
        if not gravity:
            measures["plane"] = np.abs(off @ [0.8, 0.0, 0.6]) / NEAR
        if path:
            exact = np.cos(t)[:, None] * [0.6, 0.0, -0.8] + np.sin(t)[:, None] * [0.0, 1.0, 0.0]
            measures["path"] = np.linalg.norm(off - exact, axis=1) / path
        return measures

    case.truth = truth
    return case


PLANE2 = sympy.symbols("x1 y1 x2 y2", real=True)


def double_pendulum(name, title, hard, *, masses, start, h, steps, followed, **more):
    x1, y1, x2, y2 = PLANE2
    m1, m2 = masses
    a, b = start
    q = np.array([np.sin(a), -np.cos(a), np.sin(a) + np.sin(b), -np.cos(a) - np.cos(b)])
    case = Case(
        name,
        title,
        hard,
        [x1**2 + y1**2 - 1, (x2 - x1) ** 2 + (y2 - y1) ** 2 - 1],
        [(q, np.zeros(4))],
        h,
        steps,
        None,
        variables=PLANE2,
        masses=(m1, m1, m2, m2),
        potential=m1 * y1 + m2 * y2,
        mujoco="double pendulum",
        program=("double pendulum", m1, m2),
        **more,
    )
    case.units = {"rods": NEAR, "path": 0.02} if followed else {"rods": NEAR, "energy": 0.05}

    def truth(t, q, v):
        upper = np.hypot(q[:, 0], q[:, 1])
        lower = np.hypot(q[:, 2] - q[:, 0], q[:, 3] - q[:, 1])
        measures = {"rods": np.maximum(np.abs(upper - 1), np.abs(lower - 1)) / NEAR}
        if followed:
            measures["path"] = np.linalg.norm(q - pendulum_by_angles(masses, start, t), axis=1) / 0.02
        else:
            measures["energy"] = energy(case, q, v, m1 + m2, 0.05 / (m1 + m2))
        return measures

    case.truth = truth
    return case


def pendulum_by_angles(masses, start, times):
    """The double pendulum by its two angles, without constraints, to twelve digits."""
    m1, m2 = masses

    def rates(_, s):
        a, b, p, r = s
        c, d = np.cos(a - b), np.sin(a - b)
        mass = m1 + m2 * d * d
        first = (-m2 * d * (r * r + c * p * p) - (m1 + m2) * np.sin(a) + m2 * c * np.sin(b)) / mass
        return [p, r, first, -c * first + d * p * p - np.sin(b)]

    end = max(times[-1], 1e-9)
    a, b = solve_ivp(
        rates, (0, end), [*start, 0, 0], method="DOP853", rtol=1e-13, atol=1e-13, dense_output=True
    ).sol(times)[:2]
    return np.stack([np.sin(a), -np.cos(a), np.sin(a) + np.sin(b), -np.cos(a) - np.cos(b)], axis=1)


def same_rod_twice():
    x, y = sympy.symbols("x y", real=True)
    case = Case(
        "same rod twice",
        "pendulum with the same rod twice, h = 0.01",
        "Two equal equations share one force between them in any way: the matrix of the multipliers is singular.",
        [x**2 + y**2 - 1, x**2 + y**2 - 1],
        [(np.array([1.0, 0.0]), np.zeros(2))],
        0.01,
        1000,
        None,
        variables=(x, y),
        masses=(1.0, 1.0),
        potential=y,
        mujoco="rod twice",
        program=("rod twice",),
        ours="tests/linked_errors.rs, dependent_and_contradictory_equations",
        units={"distance": NEAR, "energy": 0.01},
    )
    case.truth = lambda t, q, v: {
        "distance": np.abs(np.linalg.norm(q, axis=1) - 1) / NEAR,
        "energy": energy(case, q, v, 1.0, 0.01),
    }
    return case


def dead_point():
    """Crank and rod of one length: s = 2x is one family of motions, s = 0 another, and they meet where x = 0."""
    x, y, s = sympy.symbols("x y s", real=True)
    theta = 0.8
    q = np.array([np.cos(theta), np.sin(theta), 2 * np.cos(theta)])
    v = np.array([-np.sin(theta), np.cos(theta), -2 * np.sin(theta)])
    case = Case(
        "dead point",
        "crank and slider of equal arms through their dead point, h = 0.01",
        "Two families of motions cross where the slider passes the axle, and the normals depend on each other there;"
        " inertia goes straight on.",
        [x**2 + y**2 - 1, (x - s) ** 2 + y**2 - 1],
        [(q, v)],
        0.01,
        300,
        None,
        variables=(x, y, s),
        mujoco="crank",
        program=("crank",),
        ours="tests/linked_ends.rs, a_mechanism_that_branches_ends_at_the_branch",
        units={"branch": NEAR, "energy": 0.05},
    )
    case.truth = lambda t, q, v: {
        "branch": np.maximum(np.abs(q[:, 2] - 2 * q[:, 0]), np.abs(np.hypot(q[:, 0], q[:, 1]) - 1)) / NEAR,
        "energy": energy(case, q, v, 1.0, 0.05),
    }
    return case


CASES = [
    *(shells(k, h) for k in (300, 1e3, 1e4) for h in (0.05, 0.2)),
    three_shells(),
    tube(1e-2, "around", 2e-3),
    tube(1e-4, "around", 2e-5),
    tube(1e-2, "along", 0.05),
    tube(1e-4, "along", 0.05),
    pinch(0),
    pinch(1e-3),
    cone(0),
    cone(1e-3),
    octahedron(),
    roof(),
    sphere(
        "long step",
        "sphere, a step of 1.5 radii",
        "No point of the sphere is where a step of RATTLE of this length could end; variable steps are not bound by h.",
        h=1.5,
        steps=20,
        path=0.1,
        ours="optimised/tests/hard_cases.rs, sphere_up_to_the_solvability_limit",
    ),
    sphere(
        "g times 1e-30",
        "sphere as 1e-30 g = 0, under gravity, h = 0.01",
        "Any g is below a tolerance on g.",
        h=0.01,
        steps=1000,
        scale=1e-30,
        gravity=True,
        ours="optimised/tests/hard_cases.rs, any_multiple_of_the_constraint_gives_the_same_motion",
    ),
    sphere(
        "g times 1e30",
        "sphere as 1e30 g = 0, under gravity, h = 0.01",
        "No g is below a tolerance on g.",
        h=0.01,
        steps=1000,
        scale=1e30,
        gravity=True,
        ours="optimised/tests/hard_cases.rs, any_multiple_of_the_constraint_gives_the_same_motion",
    ),
    sphere(
        "far away",
        "sphere at a distance of 1e8, under gravity, h = 0.01",
        "Coordinates are known to 1.5e-8, so that a tolerance of 1e-9 is below rounding.",
        h=0.01,
        steps=1000,
        centre=1e8,
        gravity=True,
        ours="optimised/tests/hard_cases.rs, surfaces_through_the_origin_are_like_others",
    ),
    double_pendulum(
        "mass ratio 1e10",
        "double pendulum, the lower mass 1e-10 of the upper, h = 0.01",
        "The two equations differ by ten orders of magnitude in mass.",
        masses=(1.0, 1e-10),
        start=(0.5, 0.3),
        h=0.01,
        steps=1000,
        followed=True,
        ours="optimised/tests/linked_laws.rs, light_tips",
    ),
    same_rod_twice(),
    dead_point(),
    double_pendulum(
        "double pendulum",
        "double pendulum, 100 000 steps of 0.01",
        "Small errors of the energy add up over 100 000 steps.",
        masses=(1.0, 1.0),
        start=(np.pi / 2, np.pi / 2),
        h=0.01,
        steps=100_000,
        followed=False,
        ours="optimised/tests/linked_runs.rs",
    ),
    sphere(
        "long geodesic",
        "sphere geodesic, 100 000 steps of 0.05",
        "Drift from the surface and of the energy adds up over 100 000 steps.",
        h=0.05,
        steps=100_000,
        ours="optimised/tests/long_runs.rs, rounding_grows_like_the_root_of_the_steps",
    ),
]
