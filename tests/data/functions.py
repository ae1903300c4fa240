"""Values of elementary functions, by mpmath 1.3 at 400 digits.

Writes functions.csv: function, x, the nearest double, and what the value is beyond it, in units of that double's last place;
and functions_of_two.csv: the same of x and y. Arguments
are random ones of all sizes, ends of the range, and those next to places where a method changes or digits cancel:
multiples of π/2 (the nearest of 400 in each binade), of ln 2 / 2, powers of 2, powers near 1.
"""
import math
import random
from mpmath import mp, mpf, pi, log, exp, sin, cos, sinh, cosh, tanh, tan, atan, atan2, asin, acos, cbrt, sqrt, erf
from mpmath import asinh, acosh, atanh

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


def write(rows, name, f, arguments):
    value = f(*map(mpf, arguments))
    high = float(value)
    beyond = float((value - mpf(high)) / mpf(math.ulp(high)))
    rows.append([name, *map(repr, arguments), repr(high), f'{beyond:.6f}'])


rows = []
for name, f, arguments in [
    ('exp', exp, exps), ('ln', log, logs), ('sin', sin, angles + far), ('cos', cos, angles + far),
    ('sinh', sinh, hyperbolic + large), ('cosh', cosh, hyperbolic + large), ('tanh', tanh, hyperbolic + [19.5, -22.0, 40.0, 1e10]),
]:
    for x in arguments:
        write(rows, name, f, [x])


def odd_root(x):
    return cbrt(x) if x > 0 else -cbrt(-x)


def below_one():
    return [random.choice([-1, 1]) * (1 - abs(x)) for x in spread(1e-16, 0.5, 120)]


positive = [abs(x) for x in logs]
ratios = uniform(-4, 4, 200) + uniform(0.3, 0.6, 60) + uniform(2, 3, 40) + spread(1e-20, 1e20, 120) + spread(1e-307, 1e307, 30)
ratios += [x for limit in (math.sqrt(2) - 1, math.sqrt(2) + 1) for x in around(limit)] + [1.0, 1e308]
chords = uniform(-1, 1, 250) + uniform(-0.6, 0.6, 60) + spread(1e-18, 1, 80) + below_one() + around(0.5) + [1.0, -1.0]
tens = [10.0**k for k in range(23)]
roots = uniform(-9, 9, 200) + spread(1e-323, 1e308, 200) + [float(n**3) for n in range(1, 40)] + [2.0**k for k in range(-1074, 1024, 61)]
bells = uniform(-1.2, 1.2, 300) + uniform(-6.2, 6.2, 150) + spread(1e-300, 1, 60) + around(1.0)
rising = uniform(-4, 4, 250) + spread(1e-18, 1e18, 150) + spread(1e-300, 1e308, 50) + around(2.0**30)
above_one = [1 + abs(x) for x in spread(3e-16, 1, 200) + spread(1e-3, 1e10, 200)] + [abs(x) for x in spread(1, 1e308, 50)] + around(2.0**30)
inside = uniform(-1, 1, 250) + uniform(-0.4, 0.4, 60) + spread(1e-300, 1, 80) + below_one()
for name, f, arguments in [
    ('tan', tan, angles + far), ('atan', atan, ratios), ('asin', asin, chords), ('acos', acos, chords),
    ('log2', lambda x: log(x) / log(2), positive), ('log10', lambda x: log(x) / log(10), positive + tens),
    ('cbrt', odd_root, roots), ('erf', erf, bells), ('asinh', asinh, rising), ('acosh', acosh, above_one), ('atanh', atanh, inside),
]:
    for x in arguments:
        write(rows, name, f, [x])


def powers(n):
    """x > 0 and y whose power is within the floats, with large exponents of numbers near 1 among them."""
    found = []
    while len(found) < n:
        kind = len(found) % 4
        x = abs([spread(1e-300, 1e300, 1)[0], random.uniform(0.2, 5), 1 + spread(1e-12, 0.5, 1)[0], spread(1e-3, 1e3, 1)[0]][kind])
        y = [random.uniform(-744, 709) / math.log(x), random.uniform(-300, 300), spread(1, 1e14, 1)[0], random.uniform(-10, 10)][kind]
        if -744 < y * math.log(x) < 709.5:
            found.append([x, y])
    return found


def pairs(n, *spreads):
    return [list(pair) for spread_x, spread_y in spreads for pair in zip(spread_x(n), spread_y(n))]


def of_sizes(low, high):
    return lambda n: spread(low, high, n)


points = pairs(120, (of_sizes(0.1, 10), of_sizes(0.1, 10)), (of_sizes(1e-5, 1e5), of_sizes(1e-5, 1e5)))
points += pairs(60, (of_sizes(1e-307, 1e308), of_sizes(1e-307, 1e308)), (of_sizes(1e-323, 1e-300), of_sizes(1e-323, 1e-300)))
points += pairs(60, (of_sizes(1e-323, 1e-300), of_sizes(1e-15, 1e8)))
two = []
for name, f, arguments in [
    ('atan2', atan2, points), ('hypot', lambda x, y: sqrt(x * x + y * y), points + pairs(60, (of_sizes(1e307, 1.2e308),) * 2)),
    ('powf', lambda x, y: x**y, powers(600) + [[2.0, 0.5], [10.0, 22.0], [1.5, -1.0], [2.0, -1074.0]]),
]:
    for x in arguments:
        write(two, name, f, x)

# Where errors were the largest among 250 000 random arguments of each function.
WORST = {
    'tan': [-13.335853489664096, -3.923938735874983, 368605.42401822924, -2.3784195124918197],
    'atan': [-0.43172289451452767, -0.4696291544417514, -0.4143210969309155, -0.41615846321648636],
    'asin': [-0.5864513753933658, -0.6207462680421492, -0.5864521920476897, -0.5338086416524019],
    'acos': [0.5676129123317584, 0.5602816363358716, 0.5457528107645799, 0.570515663304128],
    'log2': [1.4051559954915223, 1.39823827113968, 1.373985061905576, 1.4089779159588554],
    'log10': [0.6782285787650031, 0.6881639793925585, 1.3322253338300705, 1.4413968366590648],
    'ln': [1.272582278692212, 1.2714879245127364, 1.4016863016622307, 1.2810088543756748],
    'cbrt': [3.8220151307022494, 3.7189185784361136, 8.22892080838482e-93, -1.0893319548034177e+195],
    'erf': [-0.9841665549380434, 0.9743450000960756, 0.9844052651552975, 0.998364736481961],
    'asinh': [1.1261452137443193, -1.151919437206626, 1.1682798344704857, -1.1120661088546632e-16],
    'acosh': [1.0078027981013435, 1.1186229568192152, 1.0000000000038598, 1.0016078460648827],
    'atanh': [-6.139958612541646e-17, -5.705101699402436e-17, -0.1711594694308558, 0.23278879210751335],
    'sin': [-249919.21113430493, -168833.08285537284, 266191.0422625423, -315961.7700266276],
    'cos': [-361266.65065265796, -292965.25578439876, -306972.1163573659, 326503.38319887244],
    'exp': [-24.591124562018088, -513.9633303227583, 25.31773376506367, 0.3490599007887918],
    'sinh': [-0.3764600392696432, 0.23639526266595412, 0.11902875069455138, -0.23304935262031146, 0.2447837768736183],
    'cosh': [2.4664884143828463, 3.1655186515204514, -6.595737398800427],
    'tanh': [-0.12375168968158246, 0.5486458398754909, -0.015438639848445327, -0.21937863661885781, 0.06224983676676731],
}
WORST_OF_TWO = {
    'atan2': [[-2.7007034279245173e-302, 549048.6635829352], [-3.5221861777681225e-304, 5078.249203240077], [-4.07730306936085e-310, 0.004777299990710559], [-8.54457315e-316, 1.552386200300691e-08]],
    'hypot': [[-0.00013973099791468133, -0.0001262170806993692], [0.4060785654105301, -0.6277176569601788], [0.5506412658083193, 0.5432667646034852], [0.4779380092261136, 0.6086401036768989]],
    'powf': [[1.4290159226399173, -1642.67007863789], [0.7237149952237486, 1311.2020952278785], [0.35389122998326206, -165.22565488333206], [1.427760035989389e-209, 1.4732328684223321]],
}

FUNCTIONS = {
    'exp': exp, 'ln': log, 'sin': sin, 'cos': cos, 'sinh': sinh, 'cosh': cosh, 'tanh': tanh, 'tan': tan, 'atan': atan, 'asin': asin,
    'acos': acos, 'log2': lambda x: log(x) / log(2), 'log10': lambda x: log(x) / log(10), 'cbrt': odd_root, 'erf': erf,
    'asinh': asinh, 'acosh': acosh, 'atanh': atanh,
}
OF_TWO = {'atan2': atan2, 'hypot': lambda x, y: sqrt(x * x + y * y), 'powf': lambda x, y: x**y}
for name, arguments in WORST.items():
    for x in arguments:
        write(rows, name, FUNCTIONS[name], [x])
for name, arguments in WORST_OF_TWO.items():
    for x in arguments:
        write(two, name, OF_TWO[name], x)


def save(path, header, rows):
    with open(path, 'w') as file:
        file.write(header + '\n')
        file.writelines(','.join(row) + '\n' for row in rows)


save('functions.csv', 'function,x,nearest,beyond', rows)
save('functions_of_two.csv', 'function,x,y,nearest,beyond', two)
