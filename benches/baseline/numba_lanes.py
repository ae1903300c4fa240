"""RATTLE on the lemniscate surface in Numba: blocks of trajectories side by side, each pass a loop.

Twice: with an array per vector, as one writes it; and with everything in one flat array at fixed places and counts in
place of maxima, so that LLVM sees that nothing overlaps and vectorises every loop."""

import numpy as np
from numba import njit

from opponent import H, R2, TOLERANCE, converse


@njit(inline="always")
def value_and_half_gradient(x, y, z):
    y2 = y * y
    t = x * x + y2
    f = t * t - (x * x - y2)
    return f * f + (z * z - R2), x * f * (4 * t - 2), y * f * (4 * t + 2), z


def with_arrays(block, newton):
    """Blocks of so many trajectories; Newton from a quadratic guess, or Newton and one of Ostrowski's corrections."""

    @njit(fastmath=True, error_model="numpy")
    def step(q, v, n, m, free, s, gs, rs):
        for i in range(block):
            s0, s1, s2 = s[0, i], s[1, i], s[2, i]
            guess = 3 * (s0 - s1) + s2
            s[1, i], s[2, i] = s0, s1
            x, y = q[0, i] + H * v[0, i], q[1, i] + H * v[1, i]
            z = q[2, i] - 0.5 * H * H + H * v[2, i]
            free[0, i], free[1, i], free[2, i] = x, y, z
            if not newton:
                nx, ny, nz = n[0, i], n[1, i], n[2, i]
                g, a, b, c = value_and_half_gradient(x - guess * nx, y - guess * ny, z - guess * nz)
                r = 0.5 / (a * nx + b * ny + c * nz)
                guess += g * r
                k, a, b, c = value_and_half_gradient(x - guess * nx, y - guess * ny, z - guess * nz)
                guess += k * r * (1 + 2 * k / (g + 1e-300))
                rs[i] = r
            s[0, i] = guess
        for _ in range(50):
            worst = 0.0
            for i in range(block):
                nx, ny, nz, guess = n[0, i], n[1, i], n[2, i], s[0, i]
                x, y, z = free[0, i] - guess * nx, free[1, i] - guess * ny, free[2, i] - guess * nz
                g, a, b, c = value_and_half_gradient(x, y, z)
                q[0, i], q[1, i], q[2, i] = x, y, z
                m[0, i], m[1, i], m[2, i] = a, b, c
                gs[i] = g
                if newton:
                    rs[i] = 0.5 / (a * nx + b * ny + c * nz)
                worst = max(worst, abs(g))
            if worst <= TOLERANCE:
                break
            for i in range(block):
                s[0, i] += gs[i] * rs[i] if abs(gs[i]) > TOLERANCE else 0.0
        for i in range(block):
            k = s[0, i] * (1 / H)
            u, w, p = v[0, i] - k * n[0, i], v[1, i] - k * n[1, i], v[2, i] - H - k * n[2, i]
            a, b, c = m[0, i], m[1, i], m[2, i]
            mu = (a * u + b * w + c * p) / (a * a + b * b + c * c)
            v[0, i], v[1, i], v[2, i] = u - mu * a, w - mu * b, p - mu * c
            n[0, i], n[1, i], n[2, i] = a, b, c

    @njit(fastmath=True, error_model="numpy")
    def advance(state, steps):
        number = state.shape[1]
        q, v, n, m = np.empty((3, block)), np.empty((3, block)), np.empty((3, block)), np.empty((3, block))
        free, s, g, r = np.empty((3, block)), np.empty((3, block)), np.empty(block), np.empty(block)
        for base in range(0, number, block):
            for i in range(block):
                j = min(base + i, number - 1)
                for c in range(3):
                    q[c, i], v[c, i], s[c, i] = state[c, j], state[3 + c, j], state[6 + c, j]
                _, n[0, i], n[1, i], n[2, i] = value_and_half_gradient(q[0, i], q[1, i], q[2, i])
            for _ in range(steps):
                step(q, v, n, m, free, s, g, r)
            for i in range(min(block, number - base)):
                for c in range(3):
                    state[c, base + i] = q[c, i]
                    state[3 + c, base + i] = v[c, i]
                    state[6 + c, base + i] = s[c, i]
        return state

    return advance


def with_one_array(block, newton):
    """The same, laid out for the compiler: row k of the block is w[k * block + i]."""
    q0, q1, q2, v0, v1, v2, n0, n1, n2, m0, m1, m2, x0, x1, x2, s0, s1, s2, gs, rs = (k * block for k in range(20))
    kept = (q0, q1, q2, v0, v1, v2, s0, s1, s2)

    @njit(fastmath=True, error_model="numpy")
    def step(w):
        for i in range(block):
            guess = 3 * (w[s0 + i] - w[s1 + i]) + w[s2 + i]
            w[s2 + i] = w[s1 + i]
            w[s1 + i] = w[s0 + i]
            x, y, z = w[q0 + i] + H * w[v0 + i], w[q1 + i] + H * w[v1 + i], w[q2 + i] - 0.5 * H * H + H * w[v2 + i]
            w[x0 + i], w[x1 + i], w[x2 + i] = x, y, z
            if not newton:
                nx, ny, nz = w[n0 + i], w[n1 + i], w[n2 + i]
                g, a, b, c = value_and_half_gradient(x - guess * nx, y - guess * ny, z - guess * nz)
                r = 0.5 / (a * nx + b * ny + c * nz)
                guess += g * r
                k, a, b, c = value_and_half_gradient(x - guess * nx, y - guess * ny, z - guess * nz)
                guess += k * r * (1 + 2 * k / (g + 1e-300))
                w[rs + i] = r
            w[s0 + i] = guess
        for _ in range(50):
            off = 0
            for i in range(block):
                nx, ny, nz, guess = w[n0 + i], w[n1 + i], w[n2 + i], w[s0 + i]
                x, y, z = w[x0 + i] - guess * nx, w[x1 + i] - guess * ny, w[x2 + i] - guess * nz
                g, a, b, c = value_and_half_gradient(x, y, z)
                w[q0 + i], w[q1 + i], w[q2 + i] = x, y, z
                w[m0 + i], w[m1 + i], w[m2 + i] = a, b, c
                w[gs + i] = g
                if newton:
                    w[rs + i] = 0.5 / (a * nx + b * ny + c * nz)
                off += abs(g) > TOLERANCE
            if off == 0:
                break
            for i in range(block):
                w[s0 + i] += w[gs + i] * w[rs + i] if abs(w[gs + i]) > TOLERANCE else 0.0
        for i in range(block):
            k = w[s0 + i] * (1 / H)
            vx, vy, vz = w[v0 + i] - k * w[n0 + i], w[v1 + i] - k * w[n1 + i], w[v2 + i] - H - k * w[n2 + i]
            a, b, c = w[m0 + i], w[m1 + i], w[m2 + i]
            mu = (a * vx + b * vy + c * vz) / (a * a + b * b + c * c)
            w[v0 + i], w[v1 + i], w[v2 + i] = vx - mu * a, vy - mu * b, vz - mu * c
            w[n0 + i], w[n1 + i], w[n2 + i] = a, b, c

    @njit(fastmath=True, error_model="numpy")
    def advance(state, steps):
        number = state.shape[1]
        w = np.empty(20 * block)
        for base in range(0, number, block):
            for i in range(block):
                for row, place in enumerate(kept):
                    w[place + i] = state[row, min(base + i, number - 1)]
                _, w[n0 + i], w[n1 + i], w[n2 + i] = value_and_half_gradient(w[q0 + i], w[q1 + i], w[q2 + i])
            for _ in range(steps):
                step(w)
            for i in range(min(block, number - base)):
                for row, place in enumerate(kept):
                    state[row, base + i] = w[place + i]
        return state

    return advance


converse(
    {
        "newton_32": with_arrays(32, True),
        "newton_64": with_arrays(64, True),
        "ostrowski_64": with_arrays(64, False),
        "one_array_newton_64": with_one_array(64, True),
        "one_array_ostrowski_64": with_one_array(64, False),
    }
)
