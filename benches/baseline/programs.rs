//! The opponents: made ready, compared, timed.

use crate::conversation::{Check, Program};
use crate::linked;
use crate::ours;
use crate::tops;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Where the opponents' sources are.
const SOURCES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/benches/baseline");

/// Tasks of linked bodies.
pub(crate) const LINKED: [&str; 3] = ["double_pendulum", "chain", "top"];

/// One who takes part.
pub(crate) struct Entrant {
    /// The name in `ratio NAME VALUE`; ours has none, which is the first without one, nor has what only the table
    /// shows.
    ratio: Option<&'static str>,
    who: &'static str,
    program: Program,
    /// Its variants; after the heats the fastest alone.
    rows: Vec<String>,
    check: Option<Check>,
    /// How far its positions are from those of the first entrant, at each time where they are compared.
    apart: Vec<f64>,
    /// ns per step and trajectory, round by round.
    times: Vec<f64>,
}

/// What all do.
pub(crate) struct Task {
    pub(crate) name: &'static str,
    /// Trajectories, or particles.
    pub(crate) n: usize,
    pub(crate) steps: u64,
    pub(crate) entrants: Vec<Entrant>,
}

/// What the opponents need, in a folder of its own.
pub(crate) struct Programs {
    folder: PathBuf,
    /// A Python with Numba and JAX.
    python: Result<PathBuf, String>,
}

impl Programs {
    /// Makes the folder.
    pub(crate) fn make() -> Result<Self, String> {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("baseline");
        std::fs::create_dir_all(&folder).map_err(|why| format!("{}: {why}", folder.display()))?;
        let python = python(&folder);
        Ok(Self { folder, python })
    }

    /// Who takes part in the task of this name.
    pub(crate) fn entrants(&self, task: &str) -> Result<Vec<Entrant>, String> {
        match task {
            "one after the other" => self.scalar(),
            "side by side" => self.lanes(),
            "lobatto" => self.lobatto(),
            "gas of 21" => self.gas(21, 100, 0.01),
            "gas of 1000" => self.gas(1000, 2, 0.0025),
            "double pendulum" => self.linked("double_pendulum"),
            "pendulums side by side" => self.pendulums(),
            "chain of 1000" => self.linked("chain"),
            "tops side by side" => self.tops(),
            _ => self.linked("top"),
        }
    }

    /// Compiles a source, with these flags for the machine.
    fn compile(&self, source: &str, flags: &[&str]) -> Result<PathBuf, String> {
        let compiler = std::env::var("CC").unwrap_or_else(|_| "cc".into());
        let program = self.folder.join(source.trim_end_matches(".c").to_owned() + &flags.concat());
        let mut command = Command::new(&compiler);
        command.args(["-O3", "-o"]).arg(&program).arg(Path::new(SOURCES).join(source)).args(flags).arg("-lm");
        let output = command.output().map_err(|why| format!("no C compiler `{compiler}`: {why}"))?;
        if output.status.success() {
            Ok(program)
        } else {
            Err(format!("{source} does not compile here:\n{}", String::from_utf8_lossy(&output.stderr)))
        }
    }

    fn c(&self, source: &str, flags: &[&str]) -> Result<Program, String> {
        Program::start(&mut Command::new(self.compile(source, flags)?))
    }

    /// A Python opponent on one core.
    fn script(&self, script: &str, flags: &str) -> Result<Program, String> {
        let python = self.python.as_ref().map_err(String::clone)?;
        let one_core = Command::new("taskset").args(["-c", "0", "true"]).status().is_ok_and(|s| s.success());
        let mut command = if one_core { Command::new("taskset") } else { Command::new(python) };
        if one_core {
            command.args(["-c", "0"]).arg(python);
        }
        command.arg("-B").arg(Path::new(SOURCES).join(script));
        command.env("XLA_FLAGS", format!("--xla_cpu_multi_thread_eigen=false {flags}"));
        command.envs([("OMP_NUM_THREADS", "1"), ("JAX_PLATFORMS", "cpu")]);
        Program::start(&mut command)
    }

    /// Trajectories one after the other.
    fn scalar(&self) -> Result<Vec<Entrant>, String> {
        let c = || self.c("scalar.c", &["-march=native"]);
        Ok(present([
            entrant("Rust by hand", Some("scalar_over_rust"), &crate::HANDS, us("trajectories")),
            entrant("ours", None, &[ours::SCALAR], us("trajectories")),
            entrant(
                "ours, a simulation",
                Some("scalar_over_simulation"),
                &[ours::SIMULATION],
                us("trajectories"),
            ),
            entrant("C, guess as ours", Some("scalar_over_c"), &ours::SCALAR_GUESS, c()),
            entrant("C, guess of a simulation", Some("scalar_over_c_curvature"), &["curvature"], c()),
            entrant("C, fastest", Some("scalar_over_fastest_c"), &[], c()),
        ]))
    }

    /// Trajectories side by side.
    fn lanes(&self) -> Result<Vec<Entrant>, String> {
        let wide = "--xla_cpu_prefer_vector_width=512";
        let (arrays, one_array) =
            (["newton_32", "newton_64", "ostrowski_64"], ["one_array_newton_64", "one_array_ostrowski_64"]);
        Ok(present([
            entrant(
                "C, one after the other",
                Some("ensemble_over_c_scalar"),
                &[],
                self.c("scalar.c", &["-march=native"]),
            ),
            entrant("ours", None, &[ours::ENSEMBLE], us("trajectories")),
            entrant(
                "C, loops for the compiler",
                Some("ensemble_over_c_loops"),
                &[],
                self.c("loops.c", &["-march=native", "-ffast-math"]),
            ),
            entrant(
                "C, intrinsics",
                Some("ensemble_over_c_simd"),
                &[],
                self.c("lanes.c", &["-march=native"]),
            ),
            entrant(
                "C, intrinsics, to 5e-16",
                Some("ensemble_over_c_simd_to_the_floor"),
                &[],
                self.c("lanes.c", &["-march=native", "-DTOLERANCE=5e-16"]),
            ),
            entrant("Numba", Some("ensemble_over_numba"), &arrays, self.script("numba_lanes.py", "")),
            entrant(
                "Numba, one flat array",
                Some("ensemble_over_numba_flat"),
                &one_array,
                self.script("numba_lanes.py", ""),
            ),
            entrant(
                "JAX",
                Some("ensemble_over_jax"),
                &["newton_3", "while"],
                self.script("jax_lanes.py", ""),
            ),
            entrant(
                "JAX, unrolled, 512 bits",
                Some("ensemble_over_jax_unrolled"),
                &["newton_3_unrolled"],
                self.script("jax_lanes.py", wide),
            ),
            entrant(
                "ours, compensated",
                Some("ensemble_over_compensated"),
                &[ours::COMPENSATED],
                us("trajectories"),
            ),
            entrant("ours, a sweep", None, &[ours::SWEEP], us("trajectories")),
            entrant("ours, 2 threads", Some("threads2_over_1"), &[ours::THREADS_2], us("trajectories")),
        ]))
    }

    /// Trajectories side by side, by collocation.
    fn lobatto(&self) -> Result<Vec<Entrant>, String> {
        Ok(present([
            entrant(
                "ours, simulations",
                Some("lobatto_over_simulations"),
                &[ours::LOBATTO_APART],
                us("trajectories"),
            ),
            entrant("ours", None, &[ours::LOBATTO], us("trajectories")),
            entrant(
                "C, loops for the compiler",
                Some("lobatto_over_c_loops"),
                &[],
                self.c("lobatto.c", &["-march=native", "-ffast-math"]),
            ),
        ]))
    }

    /// A gas; it starts from points of one path, `every` so many steps.
    fn gas(&self, particles: usize, every: u64, h: f64) -> Result<Vec<Entrant>, String> {
        let file = self.folder.join(format!("gas_{particles}"));
        ours::write_gas(&file, particles, every, h).map_err(|why| why.to_string())?;
        let file = file.to_str().ok_or("the target folder's name is no text")?;
        let c = || Program::start(Command::new(self.compile("gas.c", &["-march=native"])?).arg(file));
        let names = match particles {
            21 => ["gas_21_over_c", "gas_21_over_c_simd"],
            _ => ["gas_1000_over_c", "gas_1000_over_c_simd"],
        };
        Ok(present([
            entrant("C", Some(names[0]), &["scalar"], c()),
            entrant("ours", None, &["gas"], us(file)),
            entrant("C, intrinsics", Some(names[1]), &["lanes"], c()),
        ]))
    }

    /// One of [`LINKED`].
    fn linked(&self, task: &str) -> Result<Vec<Entrant>, String> {
        let c = || Program::start(Command::new(self.compile("linked.c", &["-march=native"])?).arg(task));
        let names = match task {
            "double_pendulum" => ["double_pendulum_over_c", "double_pendulum_over_c_past"],
            "chain" => ["chain_over_c", "chain_over_c_past"],
            _ => ["top_over_c", "top_over_c_past"],
        };
        Ok(present([
            entrant("C, guess from the state", Some(names[0]), &["state"], c()),
            entrant("ours", None, &["linked"], us(task)),
            entrant("C, guess from the past", Some(names[1]), &["past"], c()),
        ]))
    }

    /// Double pendulums side by side.
    fn pendulums(&self) -> Result<Vec<Entrant>, String> {
        let name = linked::PENDULUMS;
        Ok(present([
            entrant(
                "C, loops for the compiler",
                Some("pendulums_over_c_loops"),
                &[],
                self.c("pendulums.c", &["-march=native", "-ffast-math", "-mprefer-vector-width=512"]),
            ),
            entrant("ours", None, &[linked::PENDULUMS], us(name)),
            entrant("ours, compensated", Some("pendulums_over_compensated"), &[linked::SUMS], us(name)),
            entrant("ours, simulations", Some("pendulums_over_simulations"), &[linked::APART], us(name)),
        ]))
    }

    /// Heavy tops side by side.
    fn tops(&self) -> Result<Vec<Entrant>, String> {
        let name = tops::TOPS;
        Ok(present([
            entrant(
                "C, loops for the compiler",
                Some("tops_over_c_loops"),
                &[],
                self.c("tops.c", &["-march=native", "-ffast-math", "-mprefer-vector-width=512"]),
            ),
            entrant("ours", None, &[tops::TOPS], us(name)),
            entrant("ours, compensated", Some("tops_over_compensated"), &[tops::SUMS], us(name)),
            entrant("ours, simulations", Some("tops_over_simulations"), &[tops::APART], us(name)),
        ]))
    }

    /// Instructions per step of those that go one after the other.
    pub(crate) fn callgrind(&self) -> Result<(), String> {
        // Callgrind knows no AVX-512.
        let c = self.compile("scalar.c", &["-march=haswell"])?;
        let us = std::env::current_exe().map_err(|why| why.to_string())?;
        let serve = ["--serve", "trajectories"];
        println!("instructions per step (callgrind; C for Haswell)");
        let rows = [
            ("C", &c, &[][..], "previous"),
            ("C", &c, &[], "quadratic"),
            ("C", &c, &[], "curvature"),
            ("C", &c, &[], "quadratic_chord"),
            ("Rust by hand", &us, &serve, crate::HANDS[0]),
            ("Rust by hand", &us, &serve, crate::HANDS[1]),
            ("ours", &us, &serve, ours::SIMULATION),
            ("ours", &us, &serve, ours::SCALAR),
        ];
        for (who, program, arguments, row) in rows {
            let (few, many) = (1_000, 11_000);
            let total = |steps| instructions(program, arguments, &format!("time {row} 1 {steps}\n"));
            println!("{who:14} {row:26} {:8.1}", (total(many)? - total(few)?) / f64::from(many - few));
        }
        Ok(())
    }
}

/// A Python with Numba and JAX, in an environment of its own that is made once.
fn python(folder: &Path) -> Result<PathBuf, String> {
    let environment = folder.join("python");
    let python = environment.join("bin/python");
    let run = |command: &mut Command| match command.output() {
        Ok(output) if output.status.success() => Ok(()),
        Ok(output) => Err(String::from_utf8_lossy(&output.stderr).into_owned()),
        Err(why) => Err(format!("{command:?}: {why}")),
    };
    let imports = ["-c", "import numba, jax"];
    if run(Command::new(&python).args(imports)).is_err() {
        eprintln!("installing Numba and JAX into {} …", environment.display());
        run(Command::new("python3").args(["-m", "venv"]).arg(&environment))?;
        run(Command::new(&python).args(["-m", "pip", "install", "--quiet", "numba", "jax"]))?;
        run(Command::new(&python).args(imports))?;
    }
    Ok(python)
}

/// This program, as a server.
fn us(what: &str) -> Result<Program, String> {
    let path = std::env::current_exe().map_err(|why| why.to_string())?;
    Program::start(Command::new(path).args(["--serve", what]))
}

/// Someone with these variants; all that the program knows if none is named.
fn entrant(
    who: &'static str,
    ratio: Option<&'static str>,
    rows: &[&str],
    program: Result<Program, String>,
) -> Result<Entrant, String> {
    let mut program = program.map_err(|why| format!("{who}: {why}"))?;
    let rows = if rows.is_empty() {
        program.rows().map_err(|why| format!("{who}: {why}"))?
    } else {
        rows.iter().map(ToString::to_string).collect()
    };
    Ok(Entrant { ratio, who, program, rows, check: None, apart: Vec::new(), times: Vec::new() })
}

/// Those that are here; says why others are not.
fn present<const N: usize>(entrants: [Result<Entrant, String>; N]) -> Vec<Entrant> {
    entrants
        .into_iter()
        .filter_map(|entrant| entrant.inspect_err(|why| println!("skipped {why}")).ok())
        .collect()
}

/// Instructions of one request, by callgrind.
fn instructions(program: &Path, arguments: &[&str], request: &str) -> Result<f64, String> {
    use std::io::Write;
    use std::process::Stdio;
    let mut command = Command::new("valgrind");
    command.args(["--tool=callgrind", "--callgrind-out-file=/dev/null"]).arg(program).args(arguments);
    command.stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::piped());
    let mut child = command.spawn().map_err(|why| format!("valgrind: {why}"))?;
    let mut requests = child.stdin.take().ok_or("no pipe")?;
    requests.write_all(request.as_bytes()).map_err(|why| why.to_string())?;
    drop(requests);
    let output = child.wait_with_output().map_err(|why| why.to_string())?;
    let report = String::from_utf8_lossy(&output.stderr).into_owned();
    let line = report.lines().find(|line| line.contains("Collected"));
    line.and_then(|line| line.rsplit(' ').next()?.parse().ok()).ok_or(report)
}

impl Entrant {
    fn ns_per_step(&mut self, row: &str, n: usize, steps: u64) -> Result<f64, String> {
        let seconds = self.program.time(row, n, steps).map_err(|why| format!("{}: {why}", self.who))?;
        Ok(1e9 * seconds / (n as f64 * steps as f64))
    }
}

impl Task {
    /// Keeps the fastest variant of each, and looks whether all do the same.
    ///
    /// Trajectories are chaotic: rounding grows from 1e-16 to about 3e-14 at t = 1 and 8e-12 at t = 5, for 25
    /// directions against quadruple precision; here are four times as many. A gas of 1000 shoots apart from much
    /// closer.
    pub(crate) fn compare(&mut self) -> Result<(), String> {
        let (looks, whole): (&[(usize, u64, f64)], _) = if self.name.starts_with("gas") {
            (&[(self.n, 20, 1e-9)], (self.n, self.steps.min(2000)))
        } else if self.name.contains("pendulums") {
            (&[(200, 100, 1e-12)], (200, 500))
        } else if self.name.contains("pendulum") || self.name.contains("chain") || self.name.contains("top") {
            (&[(self.n, 100, 1e-12)], (self.n, self.steps.min(2000)))
        } else if self.name == "lobatto" {
            (&[(100, 40, 1e-12), (100, 200, 1e-8)], (self.n, 80)) // the same times, and one where energies are alike
        } else {
            (&[(100, 100, 1e-12), (100, 500, 1e-8)], (1000, 2000))
        };
        let mut reference: Vec<Vec<[f64; 3]>> = Vec::new();
        let mut first_deviation = None;
        for entrant in &mut self.entrants {
            if entrant.rows.len() > 1 {
                let mut times = Vec::new();
                for row in entrant.rows.clone() {
                    let mut best = f64::INFINITY;
                    for _ in 0..3 {
                        best = best.min(entrant.ns_per_step(&row, self.n.min(2000), self.steps)?);
                    }
                    times.push((best, row));
                }
                times.sort_by(|a, b| a.0.total_cmp(&b.0));
                entrant.rows = vec![times.swap_remove(0).1];
            }
            let row = entrant.rows[0].clone();
            for (k, &(n, steps, bound)) in looks.iter().enumerate() {
                let check = entrant.program.check(&row, n, steps)?;
                let first = reference.get(k).unwrap_or(&check.positions);
                let pairs = check.positions.iter().flatten().zip(first.iter().flatten());
                let apart = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                if apart.partial_cmp(&bound).is_none_or(|order| order.is_gt()) {
                    return Err(format!("{} {row} is {apart:.1e} off after {steps} steps", entrant.who));
                }
                entrant.apart.push(apart);
                if reference.len() == k {
                    reference.push(check.positions);
                }
            }
            let check = entrant.program.check(&row, whole.0, whole.1)?;
            if check.residual.partial_cmp(&2e-14).is_none_or(|order| order.is_gt()) {
                return Err(format!("{} {row} leaves |g| = {:.1e}", entrant.who, check.residual));
            }
            // The method's own error, the same for all; a gas is at its mercy from where rounding has grown.
            let expected = first_deviation.get_or_insert(check.deviation);
            if !self.name.starts_with("gas") && (check.deviation / *expected - 1.0).abs() > 0.05 {
                return Err(format!("{} {row} is off in energy by {:.3e}", entrant.who, check.deviation));
            }
            entrant.check = Some(check);
        }
        Ok(())
    }

    /// Times all in turn, in so many rounds, and prints the table.
    pub(crate) fn race(&mut self, rounds: usize) -> Result<(), String> {
        let (n, steps, number) = (self.n, self.steps, self.entrants.len());
        for round in 0..rounds {
            for k in 0..number {
                let entrant = &mut self.entrants[(k + round) % number];
                let row = entrant.rows[0].clone();
                let time = entrant.ns_per_step(&row, n, steps)?;
                entrant.times.push(time);
            }
        }
        println!("\n{}: {n} × {steps} steps, {rounds} rounds", self.name);
        println!(
            "{:26} {:28} {:>9} {:>9} {:>7}   {:>6} {:>6}   {:>8}  {:>8}   apart",
            "", "", "ns min", "median", "× ours", "g", "∇g", "max |g|", "ΔE/K"
        );
        for entrant in &self.entrants {
            let Some(check) = &entrant.check else { continue };
            let [values, gradients] = check.evaluations.map(|count| match count {
                0.0 => "–".into(),
                count => format!("{count:.3}"),
            });
            let apart: Vec<String> = entrant.apart.iter().map(|apart| format!("{apart:.0e}")).collect();
            println!(
                "{:26} {:28} {:9.3} {:9.3} {:>7}   {values:>6} {gradients:>6}   {:8.1e}  {:8.2e}   {}",
                entrant.who,
                entrant.rows[0],
                entrant.times.iter().copied().fold(f64::INFINITY, f64::min),
                median(&entrant.times),
                self.over_ours(entrant).map_or("–".into(), |ratio| format!("{ratio:.3}")),
                check.residual,
                check.deviation,
                apart.join(" ")
            );
        }
        Ok(())
    }

    /// Its time by ours, median over rounds; none where ours is not here.
    fn over_ours(&self, entrant: &Entrant) -> Option<f64> {
        let ours = self.entrants.iter().find(|entrant| entrant.ratio.is_none())?;
        let pairs = entrant.times.iter().zip(&ours.times);
        Some(median(&pairs.map(|(them, us)| them / us).collect::<Vec<_>>()))
    }

    /// Prints `ratio NAME VALUE` for each opponent.
    pub(crate) fn ratios(&self) {
        for entrant in &self.entrants {
            let (Some(name), Some(ratio)) = (entrant.ratio, self.over_ours(entrant)) else { continue };
            // For two threads of ours it is the other way round.
            println!("ratio {name} {:.3}", if name.starts_with("threads") { 1.0 / ratio } else { ratio });
        }
    }
}

fn median(numbers: &[f64]) -> f64 {
    let mut sorted = numbers.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied().unwrap_or(f64::NAN)
}
