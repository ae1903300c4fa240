"""Discrete maps in 50-digit arithmetic, for golden_discrete_methods.csv: python3 discrete_maps.py > golden_discrete_methods.csv

Written from the formulas, with nothing in common with the library: plain sums, Newton's method to 1e-45, no guesses.
"""
import json, pathlib
from mpmath import mp, mpf, matrix

mp.dps = 50
HERE = pathlib.Path(__file__).parent
R = mpf(1.0 / 6.0)  # the double nearest to 1/6


def f(x, y):
    return (x * x + y * y) ** 2 - (x * x - y * y)


def g(q):
    return f(q[0], q[1]) ** 2 + q[2] ** 2 - R**2


def normal(q):
    x, y, z = q
    s = 4 * (x * x + y * y)
    return [2 * f(x, y) * x * (s - 2), 2 * f(x, y) * y * (s + 2), 2 * z]


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def add(a, c, b):
    return [x + c * y for x, y in zip(a, b)]


FORCE = [mpf(0), mpf(0), mpf(-1)]


def kick(p, c):
    return add(p, c, FORCE)


def tangent(q, p):
    n = normal(q)
    return add(p, -dot(n, p) / dot(n, n), n)


def land(q, p, h):
    """q + h (p + n c) on the surface: the new position and momentum."""
    n, c = normal(q), mpf(0)
    for _ in range(60):
        there = add(q, h, add(p, c, n))
        change = g(there) / (h * dot(normal(there), n))
        c -= change
        if abs(change) < mpf(10) ** -45:
            break
    else:
        raise ArithmeticError("no convergence")
    p = add(p, c, n)
    return add(q, h, p), p


def rattle(q, p, h):
    q, p = land(q, kick(p, h / 2), h)
    return q, tangent(q, kick(p, h / 2))


def free(q, p, h):
    q, p = land(q, p, h)
    return q, tangent(q, p)


def euler(q, p, h):
    q, p = land(q, kick(p, h), h)
    return q, tangent(q, p)


def shake(q, p, h):
    return land(q, kick(p, h), h)


def geodesic(q, p, h, inner=4):
    p = tangent(q, kick(p, h / 2))
    for _ in range(inner):
        q, p = free(q, p, h / inner)
    return q, tangent(q, kick(p, h / 2))


def position_verlet(q, p, h):
    q, p = free(q, p, h / 2)
    return free(q, tangent(q, kick(p, h)), h / 2)


def composition(base, half):
    gammas = half + half[-2::-1]

    def step(q, p, h):
        for gamma in gammas:
            q, p = base(q, p, gamma * h)
        return q, p

    return step


table = json.loads((HERE / "composition_coefficients.json").read_text())
half = {name: [mpf(digits) for digits in row["first_half"]] for name, row in table.items()}
methods = [("symplectic Euler", euler, 0.01), ("SHAKE", shake, 0.01), ("geodesic RATTLE", geodesic, 0.02)]
methods += [("position Verlet", position_verlet, 0.02)]
methods += [(name, composition(rattle, half[name]), 0.03) for name in half]
methods += [(f"{base} {name}", composition(step, half[name]), 0.03)
            for base, step, name in [("geodesic RATTLE", geodesic, "KAHAN_LI_1997_ORDER_6"),
                                     ("position Verlet", position_verlet, "SUZUKI_1990_ORDER_4")]]

print("method,h,n,x,y,z,px,py,pz")
for name, step, h in methods:
    root = mpf(0.7071067811865475244)
    below = root - mpf(2) ** -53
    q, p = [mpf(0), mpf(0), R], [root, below, mpf(0)]
    if step is shake:
        p = kick(p, -mpf(h) / 2)
    for n in range(1, 11):
        q, p = step(q, p, mpf(h))
        if n in (1, 10):
            print(",".join([name, str(h), str(n)] + [mp.nstr(x, 30) for x in q + p]))
