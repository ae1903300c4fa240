"""Values, gradients and Hessian-vector products to 40 digits, by mpmath 1.3 at 80 digits.

Writes derivative_references.csv: surface, q (3), v (3), g, gradient (3), Hessian times v (3). The
formulas are written here a second time; the derivatives are mpmath's numerical ones, whose step and
working precision leave more than 40 correct digits. Points have 10 bits, so they are exact in f64.
"""
import random
from mpmath import mp, mpf, sqrt, sin, cos, exp, tanh, cosh, erf, log, atan, asinh, diff, nstr

mp.dps = 80
half, quarter = mpf(1) / 2, mpf(1) / 4
phi = (1 + sqrt(5)) / 2


def lemniscate(x, y, z):
    f = (x**2 + y**2) ** 2 - (x**2 - y**2)
    return f**2 + z**2 - mpf(1) / 64


def barth(x, y, z):
    a, b, c = (phi * x) ** 2 - y**2, (phi * y) ** 2 - z**2, (phi * z) ** 2 - x**2
    return 4 * a * b * c - (1 + 2 * phi) * (x**2 + y**2 + z**2 - 1) ** 2


def clebsch(x, y, z):
    return (81 * (x**3 + y**3 + z**3) - 189 * (x**2 * (y + z) + y**2 * (x + z) + z**2 * (x + y)) + 54 * x * y * z
            + 126 * (x * y + x * z + y * z) - 9 * (x**2 + y**2 + z**2) - 9 * (x + y + z) + 1)


SURFACES = {
    "Lemniscate": lemniscate,
    "Torus": lambda x, y, z: (x**2 + y**2 + z**2 + mpf(9) / 4 - quarter) ** 2 - 9 * (x**2 + y**2),
    "TorusByDistance": lambda x, y, z: (sqrt(x**2 + y**2) - mpf(3) / 2) ** 2 + z**2 - quarter,
    "Ellipsoid": lambda x, y, z: x**2 + (y / mpf(1.5)) ** 2 + (2 * z) ** 2 - 1,
    "Gyroid": lambda x, y, z: sin(x) * cos(y) + sin(y) * cos(z) + sin(z) * cos(x),
    "Diamond": lambda x, y, z: cos(x) * cos(y) * cos(z) - sin(x) * sin(y) * sin(z),
    "BarthSextic": barth,
    "Clebsch": clebsch,
    "Heart": lambda x, y, z: (x**2 + mpf(9) / 4 * y**2 + z**2 - 1) ** 3 - x**2 * z**3 - mpf(9) / 80 * y**2 * z**3,
    "Metaballs": lambda x, y, z: 1 / ((x - 1) ** 2 + y**2 + z**2) + 1 / ((x + 1) ** 2 + y**2 + z**2) - 2,
    "Catenoid": lambda x, y, z: x**2 + y**2 - quarter * cosh(2 * z) ** 2,
    "Helicoid": lambda x, y, z: x * sin(2 * z) - y * cos(2 * z),
    "Scherk": lambda x, y, z: exp(z) * cos(y) - cos(x),
    "Supersphere": lambda x, y, z: abs(x) ** mpf(3.5) + abs(y) ** mpf(3.5) + abs(z) ** mpf(3.5) - 1,
    "Functions": lambda x, y, z: erf(x * y) + log(1 + z**2) * atan(y) - asinh(x) * tanh(z) + x**2 * sqrt(1 + x * x),
}

random.seed(1)
with open("derivative_references.csv", "w") as out:
    out.write("# by derivative_references.py: mpmath, 80 digits, 40 written\n")
    out.write("surface,x,y,z,vx,vy,vz,g,gx,gy,gz,hx,hy,hz\n")
    for name, g in SURFACES.items():
        for _ in range(8):
            q = [mpf(random.choice([-1, 1]) * random.randrange(128, 1400)) / 1024 for _ in range(3)]
            v = [mpf(random.randrange(-1024, 1024)) / 1024 for _ in range(3)]
            unit = [tuple(int(i == k) for i in range(3)) for k in range(3)]
            gradient = [diff(g, tuple(q), n) for n in unit]
            hessian = [[diff(g, tuple(q), tuple(a + b for a, b in zip(unit[i], unit[j]))) for j in range(3)] for i in range(3)]
            product = [sum(h * w for h, w in zip(row, v)) for row in hessian]
            numbers = [*q, *v, g(*q), *gradient, *product]
            out.write(",".join([name] + [nstr(x, 40, strip_zeros=True) for x in numbers]) + "\n")
