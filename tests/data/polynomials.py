"""Polynomials of rattle-core/src/number/functions, by the exchange algorithm of Remez in mpmath 1.3 at 60 digits.

Prints for each the largest error that it leaves in the result, relative or in units of the result's size, as a power of 2, and
the coefficients rounded to doubles, lowest first.
"""
from mpmath import mp, mpf, asin, atan, atanh, cos, erf, erfc, exp, log, lu_solve, matrix, pi, polyval, sqrt

mp.dps = 60


def remez(f, weight, low, high, n):
    """The polynomial p of n terms with the least max |weight (p - f)|, lowest first, and that error."""
    low, high = mpf(low), mpf(high)
    place = lambda i, of: (low + high) / 2 - (high - low) / 2 * cos(pi * i / of)
    points = [place(i, n) for i in range(n + 1)]
    for _ in range(30):
        system, right = matrix(n + 1, n + 1), matrix(n + 1, 1)
        for i, x in enumerate(points):
            for j in range(n):
                system[i, j] = x**j
            system[i, n] = (-1) ** i / weight(x)
            right[i] = f(x)
        solution = lu_solve(system, right)
        c = [solution[j] for j in range(n)]
        # The largest deviation between neighbouring changes of sign.
        peaks = []
        for x in (place(i, 24 * n) for i in range(24 * n + 1)):
            error = weight(x) * (polyval(c[::-1], x) - f(x))
            if not peaks or (error > 0) != (peaks[-1][1] > 0):
                peaks.append((x, error))
            elif abs(error) > abs(peaks[-1][1]):
                peaks[-1] = (x, error)
        while len(peaks) > n + 1:
            peaks.pop(0 if abs(peaks[0][1]) < abs(peaks[-1][1]) else -1)
        worst = max(abs(error) for _, error in peaks)
        if len(peaks) < n + 1 or worst < abs(solution[n]) * mpf('1.02'):
            break
        points = [x for x, _ in peaks]
    return c, worst


def of_square(f, at_zero):
    """f as a function of its argument's square; near zero, where the closed form loses all digits, its limit."""
    return lambda z: f(sqrt(z)) if z > mpf(10) ** -20 else at_zero


third, tan_eighth = mpf(1) / 3, sqrt(2) - 1
half = log(2) / 2 * mpf('1.0001')
FITS = [
    # name, function, weight, interval, terms
    ('EXP', lambda r: (exp(r) - 1 - r) / r**2 if abs(r) > mpf(10) ** -20 else mpf(1) / 2, lambda r: r**2 / exp(r) + mpf('1e-6'),
     -half, half, 10),
    ('ATAN', of_square(lambda t: (atan(t) - t) / t**3, -third), lambda z: z + mpf('1e-6'), 0, tan_eighth**2 * (1 + mpf('1e-12')), 11),
    ('ASIN', of_square(lambda s: (asin(s) - s) / s**3, third / 2), lambda z: z + mpf('1e-6'), 0, mpf(1) / 4, 13),
    ('ARTANH_FIFTH', of_square(lambda s: (2 * atanh(s) - 2 * s - 2 * third * s**3) / s**5, mpf(2) / 5),
     lambda z: z**2 / 2 + mpf('1e-9'), 0, (tan_eighth / (sqrt(2) + 1)) ** 2, 8),
    ('CBRT', lambda f: (1 + f) ** -third, lambda f: (1 + f) ** third, sqrt(mpf(1) / 2) - 1, tan_eighth, 6),
    ('ERF', of_square(lambda x: (erf(x) - 2 * x / sqrt(pi)) / x**3, -2 * third / sqrt(pi)), lambda z: z + mpf('1e-6'), 0, 1, 12),
    ('ERFC', lambda t: -log(erfc(1 + t)), lambda t: erfc(1 + t) + mpf('1e-18'), 0, mpf('4.93'), 18),
]
for name, f, weight, low, high, n in FITS:
    c, worst = remez(f, weight, low, high, n)
    print(f'{name}: 2^{float(log(worst, 2)):.1f}')
    print('\n'.join(f'    {float(x)!r}' for x in c))
