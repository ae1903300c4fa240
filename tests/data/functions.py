"""Values of elementary functions, by mpmath 1.3 at 400 digits.

Writes functions.csv: function, x, the nearest double, and what the value is beyond it, in units of that double's last place. Arguments
are random ones of all sizes, ends of the range, and those next to places where a method changes or digits cancel:
multiples of π/2 (the nearest of 400 in each binade), of ln 2 / 2, powers of 2.
"""
import math
import random
from mpmath import mp, mpf, pi, log, exp, sin, cos, sinh, cosh, tanh

mp.dps = 400
random.seed(6)


def around(x):
    x = float(x)
    return [math.nextafter(x, -math.inf), x, math.nextafter(x, math.inf)]


def spread(low, high, n):
    """Both signs, logarithmically."""
    return [random.choice([-1, 1]) * math.exp(random.uniform(math.log(low), math.log(high))) for _ in range(n)]


def uniform(low, high, n):
    return [random.uniform(low, high) for _ in range(n)]


def near_quarters(n_max):
    """Doubles that lie nearest to multiples of π/2, of each binade."""
    found = []
    for e in range(0, int(math.log2(n_max))):
        best = []
        for _ in range(400):
            n = random.randrange(2**e, 2 ** (e + 1))
            x = float(n * pi / 2)
            best.append((abs(mpf(x) - n * pi / 2), x))
        found += [x for _, x in sorted(best)[:2]]
    return found


angles = uniform(-4, 4, 150) + spread(1e-9, 1e5, 150) + spread(1e5, 4e5, 60) + near_quarters(2**18)
angles += [x for n in range(1, 40) for x in around(n * pi / 4)] + [1e-300, -1e-20, 0.5, 1.0]
far = spread(4e5, 2.0**40, 80)
exps = uniform(-1, 1, 150) + uniform(-745.1, 709.7, 150) + spread(1e-18, 1, 60)
exps += [x for n in range(-20, 20) for x in around((n + 0.5) * log(2))] + around(-708.3964) + uniform(-745, -708, 40)
exps += [709.782712893384, -745.1332191019411, 1.0, -1.0]
logs = [abs(x) for x in spread(1e-307, 1e307, 150)] + uniform(0.5, 2, 200) + around(math.sqrt(0.5)) + around(math.sqrt(2))
logs += [2.0**k for k in range(-1074, 1024, 61)] + [1.0 + x for x in spread(1e-15, 0.3, 150)] + uniform(1e-320, 1e-310, 20)
hyperbolic = uniform(-2, 2, 150) + uniform(-0.6, 0.6, 400) + spread(1e-12, 25, 200) + [x for n in range(1, 20) for x in around((n + 0.5) * log(2) / 2)]
large = spread(20, 710.4, 60) + [710.4758600739439]

rows = []
for name, f, arguments in [
    ('exp', exp, exps), ('ln', log, logs), ('sin', sin, angles + far), ('cos', cos, angles + far),
    ('sinh', sinh, hyperbolic + large), ('cosh', cosh, hyperbolic + large), ('tanh', tanh, hyperbolic + [19.5, -22.0, 40.0, 1e10]),
]:
    for x in arguments:
        value = f(mpf(x))
        high = float(value)
        rows.append([name, repr(x), repr(high), f'{float((value - mpf(high)) / mpf(math.ulp(high))):.6f}'])
with open('functions.csv', 'w') as file:
    file.write('function,x,nearest,beyond\n')
    file.writelines(','.join(row) + '\n' for row in rows)
