"""RATTLE on the lemniscate surface in JAX: all trajectories side by side, one array per coordinate.

The unrolled row is as fast as we could make it, with XLA_FLAGS=--xla_cpu_prefer_vector_width=512 besides. One of Newton's
corrections, one of Ostrowski's and a chord would be a tenth faster, but leave |g| = 1e-11 now and then."""

from functools import partial

import jax
import jax.numpy as jnp
from jax import lax

from opponent import H, R2, TOLERANCE, converse

jax.config.update("jax_enable_x64", True)


def value_and_half_gradient(x, y, z):
    y2 = y * y
    t = x * x + y2
    f = t * t - (x * x - y2)
    return f * f + (z * z - R2), (x * f * (4 * t - 2), y * f * (4 * t + 2), z)


def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def along(free, s, n):
    return tuple(x - s * c for x, c in zip(free, n))


def settled(free, n, s, v):
    """The end of a step, where s is known."""
    q = along(free, s, n)
    _, m = value_and_half_gradient(*q)
    k = s / H
    v = v[0] - k * n[0], v[1] - k * n[1], v[2] - H - k * n[2]
    mu = dot(m, v) / dot(m, m)
    return q, tuple(c - mu * a for c, a in zip(v, m)), m


def newton(free, n, s, updates):
    for _ in range(updates):
        g, m = value_and_half_gradient(*along(free, s, n))
        s = s + 0.5 * g / dot(m, n)
    return s


def until_solved(free, n, s):
    def off(carry):
        return jnp.any(jnp.abs(carry[1]) > TOLERANCE)

    def update(carry):
        s, g, m = carry
        s = s + jnp.where(jnp.abs(g) > TOLERANCE, 0.5 * g / dot(m, n), 0.0)
        return (s, *value_and_half_gradient(*along(free, s, n)))

    return lax.while_loop(off, update, (s, *value_and_half_gradient(*along(free, s, n))))[0]


def advance_with(solve, unroll=1):
    @partial(jax.jit, static_argnums=1)
    def run(state, steps):
        def step(carry, _):
            q, v, n, (s0, s1, s2) = carry
            free = q[0] + H * v[0], q[1] + H * v[1], q[2] - 0.5 * H * H + H * v[2]
            s = solve(free, n, 3 * (s0 - s1) + s2)
            return (*settled(free, n, s, v), (s, s0, s1)), None

        q, v, s = tuple(state[:3]), tuple(state[3:6]), tuple(state[6:])
        carry = q, v, value_and_half_gradient(*q)[1], s
        (q, v, _, s), _ = lax.scan(step, carry, None, length=steps, unroll=unroll)
        return jnp.stack([*q, *v, *s])

    return run


three = partial(newton, updates=3)
converse(
    {
        "newton_3": advance_with(three),
        "while": advance_with(until_solved),
        "newton_3_unrolled": advance_with(three, unroll=4),
    }
)
