"""Peers with a compiled right-hand side, for `accuracy.py`: Numba, JAX with diffrax, CasADi, heyoka.

Each maker imports its package, compiles, and returns `run(start, setting)`; what is not installed raises ImportError.
"""

import functools

import numpy as np

T, Z = 5.0, 1 / 6
# Half of each: the others mirror them. Suzuki 1990 (order 4); Kahan and Li 1997 (orders 6 and 8).
GAMMAS = {
    2: [1.0],
    4: [0.4144907717943757, 0.4144907717943757, -0.657963087177503],
    6: [0.3921614440073141, 0.3325991367893594, -0.7062461725576393, 0.0822135962935508, 0.7985439909348300],
    8: [0.1302024830888901, 0.5611629817751084, -0.3894749626448473, 0.1588419065551556, -0.3959038941332376]
    + [0.1845396409783157, 0.2583743876863220, 0.2950117236093103, -0.6055085338300345],
}


def acceleration(x, y, z, u, v, w):
    """The index-reduced equations in scalars: what each of these compilers is given."""
    s = x * x + y * y
    f = s * s - (x * x - y * y)
    fx, fy = 4 * x * s - 2 * x, 4 * y * s + 2 * y
    along = fx * u + fy * v
    second = (4 * s + 8 * x * x - 2) * u * u + 16 * x * y * u * v + (4 * s + 8 * y * y + 2) * v * v
    a, b, c = 2 * f * fx, 2 * f * fy, 2 * z
    m = (2 * along * along + 2 * f * second + 2 * w * w - c) / (a * a + b * b + c * c)
    return -m * a, -m * b, -1 - m * c


def sums(rows, factor, names, add=None):
    """Source text: `name = [add +] factor * (c0 * k0 + c1 * k1 + …)` for each of six components, without zeros."""
    for i, name in enumerate(names):
        terms = " + ".join(f"{float(c)!r} * k{j}_{i}" for j, c in enumerate(rows) if c)
        yield f"{name} = {f'{add}{i} + ' if add else ''}{factor} * ({terms})"


@functools.cache
def dop853_source():
    """DOP853 with its step control, all loops over stages and components written out, from SciPy's tableau."""
    from scipy.integrate._ivp import dop853_coefficients as c

    def rate(j, at):
        return [f"k{j}_0, k{j}_1, k{j}_2 = {', '.join(at[3:])}", f"k{j}_3, k{j}_4, k{j}_5 = rate({', '.join(at)})"]

    six = range(6)
    y, at, new = ([f"{name}{i}" for i in six] for name in "yqn")
    lines = ["def run(start, tolerance, end):", f"    {', '.join(y)} = start"]
    lines += ["    " + line for line in rate(0, y)]
    lines += ["    t, h, steps = 0.0, 0.1 * tolerance**0.125, 0", "    while t < end:"]
    body = ["steps += 1", "h = min(h, end - t)"]
    for j in range(1, 12):
        body += [*sums(c.A[j, :j], "h", at, "y"), *rate(j, at)]
    body += [*sums(c.B, "h", new, "y"), *sums(c.E5, 1, [f"e{i}" for i in six]), *sums(c.E3, 1, [f"d{i}" for i in six])]
    body += [f"s{i} = 1 / (tolerance * (1 + max(abs(y{i}), abs(n{i}))))" for i in six]
    body += [f"{a} = {' + '.join(f'({b}{i} * s{i}) ** 2' for i in six)}" for a, b in (("five", "e"), ("three", "d"))]
    body += ["off = h * five / np.sqrt(6 * (five + 0.01 * three) + 1e-300)", "if off < 1:", "    t += h"]
    body += ["    " + line for line in [f"{', '.join(y)} = {', '.join(new)}", *rate(0, y)]]
    body += ["h *= min(6.0, max(0.333, 0.9 * (off + 1e-30) ** -0.125))"]
    return "\n".join([*lines, *("        " + line for line in body), "    return y0, y1, y2, steps"])


def numba_dop853():
    """DOP853 of Hairer and Wanner in Numba, `fastmath`."""
    import numba

    fast = numba.njit(fastmath=True, error_model="numpy")
    names = {"np": np, "rate": fast(acceleration)}
    exec(dop853_source(), names)
    compiled = fast(names["run"])
    return lambda start, tolerance: np.array(compiled(tuple(start.tolist()), tolerance, T)[:3])


def numba_odeint():
    """LSODA by SciPy's `odeint`, whose loop is compiled, with a right-hand side compiled by Numba."""
    import numba
    from scipy.integrate import odeint

    change = numba.njit(fastmath=True, error_model="numpy")(acceleration)

    @numba.njit(fastmath=True)
    def rates(y, _):
        out = np.empty(6)
        out[:3] = y[3:]
        out[3], out[4], out[5] = change(y[0], y[1], y[2], y[3], y[4], y[5])
        return out

    def run(start, tolerance):
        tolerances = {"rtol": max(tolerance, 2.3e-14), "atol": tolerance}
        return odeint(rates, start, [0.0, T], mxstep=1_000_000, **tolerances)[-1, :3]

    return run


def numba_rattle(order):
    """RATTLE by hand in Numba, composed: Newton's method for one multiplier, from the last one."""

    def make():
        import numba

        half = GAMMAS[order]
        gammas = np.array(half + half[-2::-1])

        @numba.njit(fastmath=True, error_model="numpy")
        def surface(x, y, z):
            s = x * x + y * y
            f = s * s - (x * x - y * y)
            return f * f + z * z - Z * Z, 2 * f * (4 * x * s - 2 * x), 2 * f * (4 * y * s + 2 * y), 2 * z

        @numba.njit(fastmath=True, error_model="numpy")
        def run(x, y, z, u, v, w, steps):
            _, a, b, c = surface(x, y, z)
            m = 0.0
            for _ in range(steps):
                for gamma in gammas:
                    h = gamma * T / steps
                    p, q, r = x + h * u, y + h * v, z + h * w - 0.5 * h * h
                    k = m * h * h
                    for _ in range(20):
                        x, y, z = p - k * a, q - k * b, r - k * c
                        g, d, e, f = surface(x, y, z)
                        change = g / (a * d + b * e + c * f)
                        k += change
                        if abs(change) * (abs(a) + abs(b) + abs(c)) < 1e-9:
                            break  # Newton's method squares what is left
                    x, y, z = p - k * a, q - k * b, r - k * c
                    m, k = k / (h * h), k / h
                    u, v, w = u - k * a, v - k * b, w - k * c - h
                    _, a, b, c = surface(x, y, z)
                    n = (u * a + v * b + w * c) / (a * a + b * b + c * c)
                    u, v, w = u - n * a, v - n * b, w - n * c
            return x, y, z

        return lambda start, h: np.array(run(*start.tolist(), round(T / h)))

    return make


def jax_diffrax():
    """diffrax's Dopri8, doubles, the whole run one compiled function; tolerances are arguments, compiled once."""
    import diffrax
    import jax
    import jax.numpy as jnp

    jax.config.update("jax_enable_x64", True)

    def rates(_, y, __):
        return jnp.concatenate([y[3:], jnp.stack(acceleration(*y))])

    @jax.jit
    def run(start, tolerance):
        control = diffrax.PIDController(rtol=tolerance, atol=tolerance)
        term, options = diffrax.ODETerm(rates), {"adjoint": diffrax.ForwardMode(), "max_steps": None}
        found = diffrax.diffeqsolve(
            term, diffrax.Dopri8(), 0.0, T, None, start, stepsize_controller=control, **options
        )
        return found.ys[-1, :3]

    return lambda start, tolerance: np.asarray(run(jnp.asarray(start), tolerance))


def casadi_sundials(solver, options):
    """SUNDIALS by CasADi, which evaluates expressions in its own machine; IDAS is given the multiplier as algebraic."""

    def make():
        import casadi

        y = casadi.SX.sym("y", 6)
        at = [y[i] for i in range(6)]
        change = acceleration(*at)
        problem = {"x": y, "ode": casadi.vertcat(*at[3:], *change)}
        guess, quiet = None, {"show_eval_warnings": False, "disable_internal_warnings": True}
        if solver == "idas":
            k = casadi.SX.sym("k")
            a, b = at[0], at[1]
            s = a * a + b * b
            f = s * s - (a * a - b * b)
            normal = casadi.vertcat(2 * f * (4 * a * s - 2 * a), 2 * f * (4 * b * s + 2 * b), 2 * at[2])
            free = casadi.vertcat(change[0], change[1], change[2] + 1)
            m = -casadi.dot(free, normal) / casadi.dot(normal, normal)
            ode = casadi.vertcat(*at[3:], -k * normal + casadi.DM([0, 0, -1]))
            problem = {"x": y, "z": k, "ode": ode, "alg": k - m}
            guess = casadi.Function("m", [y], [m])

        @functools.lru_cache(maxsize=1)
        def made(tolerance):
            settings = {"abstol": tolerance, "reltol": tolerance, "max_num_steps": 100_000, **quiet, **options}
            return casadi.integrator("I", solver, problem, 0.0, T, settings)

        def run(start, tolerance):
            extra = {"z0": guess(start)} if guess else {}
            return np.array(made(tolerance)(x0=start, **extra)["xf"]).ravel()[:3]

        return run

    return make


def heyoka_taylor():
    """heyoka's Taylor series, compiled by LLVM for one tolerance, which sets the order and the step."""
    import heyoka

    y = heyoka.make_vars("x", "y", "z", "u", "v", "w")
    rates = list(zip(y, [*y[3:], *acceleration(*y)]))

    @functools.lru_cache(maxsize=1)
    def made(tolerance):
        return heyoka.taylor_adaptive(rates, [0.0] * 6, tol=tolerance, fast_math=True)

    def run(start, tolerance):
        integrator = made(tolerance)
        integrator.time = 0.0
        integrator.state[:] = start
        outcome = integrator.propagate_until(T)[0]
        assert outcome == heyoka.taylor_outcome.time_limit, outcome
        return integrator.state[:3].copy()

    return run
