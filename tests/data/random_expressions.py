"""Writes ../macro_random/rows.rs: random expressions, in the language of the macros and in Rust."""
import random

random.seed(4)
FUNCTIONS = "sqrt cbrt exp ln log10 log2 sin cos tan asin acos atan sinh cosh tanh asinh acosh atanh abs".split()


def leaf():
    v = random.choice("xyza")
    m, r = random.choice([("2", "2.0"), ("0.5", "0.5"), ("pi", "PI")])
    return random.choice([(v, v), (v, v), (f"({m} * {v})", f"({r} * {v})"), (f"({v} + {m})", f"({v} + {r})")])


def tree(depth):
    if depth == 0 or random.random() < 0.1:
        return leaf()
    kind = random.randrange(12)
    if kind < 5:
        (m, r), (n, s), op = tree(depth - 1), tree(depth - 1), random.choice("+-*/+*")
        return f"({m} {op} {n})", f"({r} {op} {s})"
    m, r = tree(depth - 1)
    if kind == 5:
        return f"-{m}", f"(-{r})"
    if kind == 6:
        n = random.choice([2, 3, 4, 5, 6, 7, -1, -2, -3])
        return f"({m})^{n}", f"power({r}, {n})"
    if kind == 7:
        n = random.choice([1, 3, 5])
        return f"({m})^({n}/2)", f"half({r}, {n // 2})"
    if kind == 8:
        (n, s), op = tree(depth - 1), random.choice(["min", "max", "hypot", "atan2"])
        return f"{op}({m}, {n})", {"min": f"smaller({r}, {s})", "max": f"larger({r}, {s})"}.get(op, f"({r}).{op}({s})")
    if kind == 9:
        (n, s), (o, t), (p, u) = tree(depth - 2 if depth > 1 else 0), tree(depth - 1), tree(0)
        return f"(if {p} < {o} {{ {m} }} else {{ {n} }})", f"(if {u} < {t} {{ {r} }} else {{ {s} }})"
    f = random.choice(FUNCTIONS)
    return f"{f}({m})", f"({r}).{f}()"


rows = [tree(5) for _ in range(60)]
with open("../macro_random/rows.rs", "w") as out:
    out.write("//! Written by `tests/data/random_expressions.py`.\n\nuse super::*;\n\n")
    for i, (macro, _) in enumerate(rows):
        out.write(f"constraint! {{ #[doc = \"A row.\"] pub(super) struct Row{i} {{ a }} |x, y, z| x + y + z + a * ({macro}) }}\n")
    out.write("\npub(super) fn check_all() -> usize {\n    let mut agreed = 0;\n")
    for i, (_, rust) in enumerate(rows):
        out.write(f"    agreed += check(\"row {i}\", Row{i} {{ a: A }}, |x, y, z| {{ let a = A; x + y + z + a * ({rust}) }});\n")
    out.write("    agreed\n}\n")
