#!/usr/bin/env python3
"""Changes of rattle-core's solvers that tests should see, all built into one set of test programs.

    python3 tests/mutants/run.py                        the changes of FILES, judged by PROGRAMS
    python3 tests/mutants/run.py solve/aim solve/root   those of some files
    AGAIN=survivors PROGRAMS=phase LONGEST=20 …         those that survived before, put to other or longer tests
    TESTS=iterations …                                  tests with names that match alone

A change is an `if` that asks whether its number is on (`src/main.rs` writes it, `on.rs` answers), so that nothing is
compiled anew for each. First each test is run alone, to see how long it takes and which changes it reaches. Then each
change is put to the tests that reach it, the cheapest first, until one fails; target/mutants/survivors has the others.
"""
import concurrent.futures, json, os, pathlib, re, resource, shutil, subprocess, sys, time

ROOT = pathlib.Path(__file__).resolve().parents[2]
WORK = ROOT / "target/mutants"
TREE, BUILD, LIST, SKIP = WORK / "tree", WORK / "build", WORK / "list", WORK / "skip"
FILES = """solve/aim solve/root solve/nearing solve/crowd solve/stop kernel/kinks motion/course
    systems/surface/landing systems/surface/position systems/surface/sheets systems/surface/passage
    systems/surface/around systems/surface/crowd systems/surface/equation systems/surface/step systems/surface/start
    systems/surface/collocation systems/linked/aim systems/linked/flight systems/linked/sheets systems/linked/chords
    systems/linked/start systems/phase/landing systems/phase/step systems/rigid/rotation
    run/ensemble/around run/ensemble/crossing run/ensemble/asked run/ensemble/loops run/ensemble/stages
    run/ensemble/linked_look""".split()
PROGRAMS = os.environ.get("PROGRAMS", "core roots shapes links networks phase ensembles lanes").split()
LONGEST = float(os.environ.get("LONGEST", "4"))  # CPU seconds: tests that take longer are left out
AGAIN = os.environ.get("AGAIN")  # a copy of target/mutants/survivors
TESTS = re.compile(os.environ.get("TESTS", ""))


def cargo(*arguments, **options):
    environment = dict(os.environ, CARGO_TARGET_DIR=str(BUILD))
    return subprocess.run(["cargo", *arguments], env=environment, capture_output=True, text=True, **options)


def rewrite(files):
    """Builds the changes in, but those that do not compile: these are found by the compiler's own errors."""
    tool = cargo("build", "--manifest-path", str(ROOT / "tests/mutants/Cargo.toml"))
    assert tool.returncode == 0, tool.stderr
    SKIP.write_text("")
    while True:
        for file in files:
            shutil.copy(ROOT / file, TREE / file)
        subprocess.run([BUILD / "debug/switch", LIST, SKIP, *files], cwd=TREE, check=True)
        check = cargo("check", "-p", "rattle-core", "--message-format=json", cwd=TREE)
        if check.returncode == 0:
            return
        bad = set(SKIP.read_text().split())
        lines = (json.loads(line) for line in check.stdout.splitlines() if line.startswith("{"))
        found = {change for line in lines for change in blamed(line, files)}
        assert found - bad, check.stderr[-3000:]
        SKIP.write_text(" ".join(bad | found))


def blamed(line, files):
    """The changes last asked for before the places of an error."""
    message = line.get("message") if line.get("reason") == "compiler-message" else None
    for span in (message or {}).get("spans", []):
        if message["level"] == "error" and span["is_primary"] and span["file_name"] in files:
            before = (TREE / span["file_name"]).read_bytes()[: span["byte_start"]].decode()
            yield from re.findall(r"mutant :: on \((\d+)u32\)", before)[-1:]


def build_tests():
    for program in PROGRAMS:
        inside = program == "core"  # the tests inside the library
        which = ["test", "-p", "rattle-core", "--lib"] if inside else ["long", "--test", program]
        built = cargo(*which, "--no-run", "--message-format=json", cwd=TREE)
        assert built.returncode == 0, built.stderr[-3000:]
        for line in map(json.loads, filter(lambda line: line.startswith("{"), built.stdout.splitlines())):
            if line.get("executable") and (inside or line["target"]["name"] == program):
                yield line["executable"], str(pathlib.Path(line["manifest_path"]).parent)


def test(executable, folder, names, seconds, **environment):
    """The exit status of these tests, −24 where they take more CPU seconds."""
    limit = lambda: resource.setrlimit(resource.RLIMIT_CPU, (int(seconds), int(seconds) + 1))
    environment = dict(os.environ, CARGO_MANIFEST_DIR=folder, RUST_BACKTRACE="0", **environment)
    command = [executable, "--exact", *names, "--test-threads", "1"]
    options = dict(cwd=folder, env=environment, capture_output=True, timeout=40 * seconds, preexec_fn=limit)
    try:
        return subprocess.run(command, **options).returncode
    except subprocess.TimeoutExpired:
        return -24


def reach(executable, folder):
    """Of each test its seconds and the changes that it reaches; none of those that fail or take long."""
    def listed(*more):
        listing = subprocess.run([executable, "--list", *more], cwd=folder, capture_output=True, text=True).stdout
        return {line[:-6] for line in listing.splitlines() if line.endswith(": test")}

    for name in filter(TESTS.search, sorted(listed() - listed("--ignored"))):
        before = os.times().children_user
        status = test(executable, folder, [name], 4 * LONGEST + 1, MUTANT="0")
        seconds = os.times().children_user - before
        if status != 0 or seconds > LONGEST:
            print("left out:", name, "takes long" if status in (0, -24, -9) else "fails", flush=True)
            continue
        (WORK / "reached").write_text("")
        test(executable, folder, [name], 8 * LONGEST + 1, MUTANT="reach", REACHED=str(WORK / "reached"))
        yield seconds, name, executable, folder, set((WORK / "reached").read_text().split())


def judge(change, tests):
    """What becomes of a change, and by how many tests."""
    chunks = []
    for seconds, name, executable, folder, reached in tests:
        if change not in reached:
            continue
        if chunks and chunks[-1][0] == executable and chunks[-1][2] + seconds <= 0.5:
            chunks[-1][2] += seconds
            chunks[-1][3].append(name)
        else:
            chunks.append([executable, folder, seconds, [name]])
    for executable, folder, seconds, names in chunks:
        status = test(executable, folder, names, 4 + 5 * seconds, MUTANT=change)
        if status != 0:
            return "without end" if status in (-24, -9) else "killed", len(names)
    return ("survived" if chunks else "not reached"), sum(len(chunk[3]) for chunk in chunks)


def main():
    files = [f"rattle-core/src/{file}.rs" for file in sys.argv[1:] or FILES]
    shutil.rmtree(TREE, ignore_errors=True)
    listing = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=True).stdout
    for file in listing.splitlines():
        if file.startswith(".cargo/"):
            continue  # that of the project holds here, too, and lists of both would be joined
        (TREE / file).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / file, TREE / file)
    shutil.copy(ROOT / "tests/mutants/on.rs", TREE / "rattle-core/src/mutant.rs")
    library = TREE / "rattle-core/src/lib.rs"
    library.write_text(library.read_text().replace("pub mod effect;", "pub mod mutant;\npub mod effect;", 1))
    rewrite(files)
    changes = [line.split("\t") for line in LIST.read_text().splitlines()]
    if AGAIN:
        survivors = {tuple(line.split("\t")[3:]) for line in pathlib.Path(AGAIN).read_text().splitlines()}
        changes = [change for change in changes if tuple(change[1:]) in survivors]
    print(len(changes), "changes;", len(SKIP.read_text().split()), "do not compile", flush=True)
    tests = sorted((row for program in build_tests() for row in reach(*program)), key=lambda row: row[0])
    print(len(tests), "tests", flush=True)
    counts, start = {}, time.time()
    with concurrent.futures.ThreadPoolExecutor() as pool, open(WORK / "survivors", "w") as survivors:
        for change, (verdict, by) in zip(changes, pool.map(lambda change: judge(change[0], tests), changes)):
            counts[verdict] = counts.get(verdict, 0) + 1
            if verdict != "killed":
                print(verdict, by, *change, sep="\t", file=survivors, flush=True)
            if sum(counts.values()) % 50 == 0:
                print(counts, f"{time.time() - start:.0f} s", flush=True)
    print(counts, "see target/mutants/survivors")


main()
