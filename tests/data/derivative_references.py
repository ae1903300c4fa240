"""Values, gradients and Hessian-vector products to 40 digits, by mpmath 1.3 at 80 digits.

Writes derivative_references.csv: surface, q (3), v (3), g, gradient (3), Hessian times v (3). For every
surface eight random points, of 10 bits, and four points of f64 next to the surface, where the terms of g
cancel. The formulas are written here a second time, after the sources that the surfaces name, in another
form where there is one; the derivatives are mpmath's numerical ones, whose step and working precision
leave more than 40 correct digits. Parameters are those of tests/common/catalogue.rs, as f64 has them.
"""
import random
from itertools import islice
from mpmath import mp, mpf, sqrt, sin, cos, exp, tanh, cosh, erf, log, atan, asinh, pi, diff, matrix, nstr

mp.dps = 80
half, quarter = mpf(1) / 2, mpf(1) / 4
phi = (1 + sqrt(5)) / 2


def norm(*xs):
    return sqrt(sum(x * x for x in xs))


def dented_cylinder(x, y, z):
    depth = quarter * cos(pi * z) ** 2 if abs(z) < half else 0  # (1 + cos 2t) / 2 = cos² t
    return x**2 + y**2 - (1 - depth) ** 2


def gaussian_bump(x, y, z):
    """Between the radii the cubic in the distance from the outer one, with the Gaussian's value and slope."""
    rho, inner, outer = norm(x, y), mpf(1), mpf(3) / 2
    gaussian = lambda t: half * exp(-2 * t * t)
    if rho < inner:
        return z - gaussian(rho)
    if rho > outer:
        return z
    value, slope, width = gaussian(inner), -4 * inner * gaussian(inner), inner - outer
    c3 = (slope * width - 2 * value) / width**3
    c2 = (3 * value - slope * width) / width**2
    return z - (rho - outer) ** 2 * (c2 + c3 * (rho - outer))


def spine(power):
    def g(x, y, z):
        c, b = (2, 1) if z > 0 else (1, half)
        return (1 - (z / c) ** 2) * (1 + (mpf(1.2) * sin(b * z * z)) ** power) - x * x - y * y
    return g


def thylakoid(x, y, z):
    """Bridge of radius 1/2 and length 1, flare 1/2; stacks of 21 by 21 with edges of radius 3."""
    u, v, rho = abs(x), abs(y), norm(y, z)
    face, back = mpf(1), mpf(22)
    du, dv = max(face + 3 - u, u - back + 3), v - mpf(15) / 2
    outside_stack = (norm(du, dv) if min(du, dv) > 0 else max(du, dv)) - 3
    if u < half:
        return min(rho - half, outside_stack)
    if rho < 1:
        return max(half - norm(u - half, rho - 1), u - back, v - mpf(21) / 2)
    return outside_stack


def lidinoid(x, y, z):
    loop = lambda a, b, c: sin(2 * a) * cos(b) * sin(c) - cos(2 * a) * cos(2 * b)
    return loop(x, y, z) + loop(y, z, x) + loop(z, x, y) + mpf(0.3)


def wrapped_package(x, y, z):
    pairs = cos(x) * cos(y) + cos(y) * cos(z) + cos(z) * cos(x)
    return 2 * pairs + 3 - 2 * (cos(x) ** 2 + cos(y) ** 2 + cos(z) ** 2)


def three_foci(x, y, z):
    """The product of the squared distances from the three corners of a triangle."""
    foci = [(1, 0), (-half, sqrt(3) / 2), (-half, -sqrt(3) / 2)]
    product = mpf(1)
    for a, b in foci:
        product *= (x - a) ** 2 + (y - b) ** 2
    return (product - 1) ** 2 + z**2 - mpf(1) / 16


def lemniscate(x, y, z):
    f = (x**2 + y**2) ** 2 - (x**2 - y**2)
    return f**2 + z**2 - mpf(1) / 64


def barth(x, y, z):
    a, b, c = (phi * x) ** 2 - y**2, (phi * y) ** 2 - z**2, (phi * z) ** 2 - x**2
    return 4 * a * b * c - (1 + 2 * phi) * (x**2 + y**2 + z**2 - 1) ** 2


def clebsch(x, y, z):
    return (81 * (x**3 + y**3 + z**3) - 189 * (x**2 * (y + z) + y**2 * (x + z) + z**2 * (x + y)) + 54 * x * y * z
            + 126 * (x * y + x * z + y * z) - 9 * (x**2 + y**2 + z**2) - 9 * (x + y + z) + 1)


def kummer(x, y, z):
    mu2 = mpf(25) / 16
    planes = ((1 - z) ** 2 - 2 * x**2) * ((1 + z) ** 2 - 2 * y**2)
    return (x**2 + y**2 + z**2 - mu2) ** 2 - (3 * mu2 - 1) / (3 - mu2) * planes


def decocube(x, y, z):
    ring = lambda a, b, c: (a**2 + b**2 - mpf(0.95) ** 2) ** 2 + (c**2 - 1) ** 2
    return ring(x, y, z) * ring(y, z, x) * ring(z, x, y) - mpf(0.02)


def dupin_cyclide(x, y, z):
    a, b, d = mpf(3) / 2, mpf(5) / 4, half
    c = sqrt(a**2 - b**2)
    return (x**2 + y**2 + z**2 + b**2 - d**2) ** 2 - 4 * (a * x - c * d) ** 2 - 4 * (b * y) ** 2


def chebyshev4(x):
    return 2 * (2 * x**2 - 1) ** 2 - 1


SURFACES = {
    "Sphere": lambda x, y, z: x**2 + y**2 + z**2 - mpf(9) / 4,
    "Ellipsoid": lambda x, y, z: x**2 + (y / mpf(1.5)) ** 2 + (2 * z) ** 2 - 1,
    "Cylinder": lambda x, y, z: x**2 + y**2 - mpf(9) / 4,
    "DentedCylinder": dented_cylinder,
    "Plane": lambda x, y, z: x + 2 * (y + z) - 3,
    "WigglyPlane": lambda x, y, z: z - sin(x) * cos(x),
    "GaussianBump": gaussian_bump,
    "Dumbbell": lambda x, y, z: (1 - z**2 / 4) * (1 + (mpf(1.2) * sin(z**2)) ** 4) - x**2 - y**2,
    "Spine": spine(4),
    "SpineTwo": spine(2),
    "Thylakoid": thylakoid,
    "Supersphere": lambda x, y, z: x**4 + y**4 + z**4 - 1,
    "SupersphereOfSevenHalves": lambda x, y, z: abs(x) ** mpf(3.5) + abs(y) ** mpf(3.5) + abs(z) ** mpf(3.5) - 1,
    "Superellipsoid": lambda x, y, z: (abs(x) ** 3 + abs(2 * y / 3) ** 3) ** (mpf(5) / 6) + abs(2 * z) ** mpf(2.5) - 1,
    "TorusByDistance": lambda x, y, z: (sqrt(x**2 + y**2) - mpf(3) / 2) ** 2 + z**2 - quarter,
    "Torus": lambda x, y, z: (x**2 + y**2 + z**2 + mpf(9) / 4 - quarter) ** 2 - 9 * (x**2 + y**2),
    "Gyroid": lambda x, y, z: sin(x) * cos(y) + sin(y) * cos(z) + sin(z) * cos(x),
    "Primitive": lambda x, y, z: cos(x) + cos(y) + cos(z) - 1,
    "Diamond": lambda x, y, z: cos(x) * cos(y) * cos(z) - sin(x) * sin(y) * sin(z),
    "Neovius": lambda x, y, z: 3 * (cos(x) + cos(y) + cos(z)) + 4 * cos(x) * cos(y) * cos(z),
    "IWrappedPackage": wrapped_package,
    "Lidinoid": lidinoid,
    "Lemniscate": lemniscate,
    "ThreeFoci": three_foci,
    "Clebsch": clebsch,
    "Cayley": lambda x, y, z: 4 * (x**2 + y**2 + z**2) + 16 * x * y * z - 1,
    "BarthSextic": barth,
    "Kummer": kummer,
    "Tanglecube": lambda x, y, z: sum(t**4 - 5 * t**2 for t in (x, y, z)) + mpf(11.8),
    "Chmutov": lambda x, y, z: chebyshev4(x) + chebyshev4(y) + chebyshev4(z),
    "Decocube": decocube,
    "Heart": lambda x, y, z: (x**2 + mpf(9) / 4 * y**2 + z**2 - 1) ** 3 - x**2 * z**3 - mpf(9) / 80 * y**2 * z**3,
    "DupinCyclide": dupin_cyclide,
    "Metaballs": lambda x, y, z: 1 / ((x - 1) ** 2 + y**2 + z**2) + 1 / ((x + 1) ** 2 + y**2 + z**2) - 2,
    "Hyperboloid": lambda x, y, z: x**2 + y**2 - 4 * z**2 / 9 - 1,
    "Paraboloid": lambda x, y, z: x**2 + 4 * y**2 / 9 - z,
    "Saddle": lambda x, y, z: (x - 2 * y / 3) * (x + 2 * y / 3) - z,
    "MonkeySaddle": lambda x, y, z: mp.re(mp.mpc(x, y) ** 3) - z,
    "Catenoid": lambda x, y, z: x**2 + y**2 - quarter * cosh(2 * z) ** 2,
    "Helicoid": lambda x, y, z: x * sin(2 * z) - y * cos(2 * z),
    "Scherk": lambda x, y, z: exp(z) * cos(y) - cos(x),
    "Functions": lambda x, y, z: erf(x * y) + log(1 + z**2) * atan(y) - asinh(x) * tanh(z) + x**2 * sqrt(1 + x * x),
}
# The stacks of the thylakoid begin at x = 1 and reach to x = 22.
REACH = {"Thylakoid": 8}
UNITS = [(1, 0, 0), (0, 1, 0), (0, 0, 1)]


def gradient(g, q):
    return [diff(g, tuple(q), unit) for unit in UNITS]


def hessian(g, q):
    sums = lambda a, b: tuple(i + j for i, j in zip(a, b))
    return [[diff(g, tuple(q), sums(a, b)) for b in UNITS] for a in UNITS]


def on_surface(g, q):
    """The f64 point next to where Newton's method along the gradient ends, if it ends nearby."""
    for _ in range(40):
        value, slope = g(*q), gradient(g, q)
        size = sum(s * s for s in slope)
        if abs(value) < mpf(10) ** -30:
            near = max(map(abs, q)) < 12 and size > mpf(10) ** -2
            return [mpf(float(x)) for x in q] if near else None
        if size < mpf(10) ** -6:
            return None
        q = [x - s * value / size for x, s in zip(q, slope)]
    return None


def row(name, g, q, v):
    product = [sum(h * w for h, w in zip(line, v)) for line in hessian(g, q)]
    numbers = [*q, *v, g(*q), *gradient(g, q), *product]
    return ",".join([name] + [nstr(x, 40, strip_zeros=True) for x in numbers]) + "\n"


if __name__ == "__main__":
    random.seed(1)
    with open("derivative_references.csv", "w") as out:
        out.write("# by derivative_references.py: mpmath, 80 digits, 40 written\n")
        out.write("surface,x,y,z,vx,vy,vz,g,gx,gy,gz,hx,hy,hz\n")
        for name, g in SURFACES.items():
            reach = lambda k: REACH.get(name, 1) if k % 2 else 1
            random_point = lambda k: [
                mpf(reach(k) * random.choice([-1, 1]) * random.randrange(128, 1400)) / 1024 for _ in range(3)]
            direction = lambda: [mpf(random.randrange(-1024, 1024)) / 1024 for _ in range(3)]
            for k in range(8):
                out.write(row(name, g, random_point(k), direction()))
            starts = (on_surface(g, random_point(k)) for k in range(400))
            near = list(islice((q for q in starts if q is not None), 4))
            assert len(near) == 4, name
            for q in near:
                out.write(row(name, g, q, direction()))
