//! What the benchmark and its programs say to each other; the same as in `opponent.h` and `opponent.py`.

use crate::clock::cpu_seconds;
use std::io::{BufRead, BufReader, Write};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

/// Step size.
pub(crate) const H: f64 = 0.01;
/// |g| that counts as solved.
pub(crate) const TOLERANCE: f64 = 1e-14;

/// Position and velocity of trajectory `i` of `n` at the start.
pub(crate) fn start(i: usize, n: usize) -> ([f64; 3], [f64; 3]) {
    let angle = std::f64::consts::TAU * i as f64 / n as f64;
    ([0.0, 0.0, 1.0 / 6.0], [angle.cos(), angle.sin(), 0.0])
}

/// Trajectories under way, or one gas.
pub(crate) trait Run {
    /// Takes all trajectories so many steps on.
    fn advance(&mut self, steps: u64);
    /// Position and velocity.
    fn body(&self, i: usize) -> ([f64; 3], [f64; 3]);
    /// Evaluations of g and of ∇g so far, of all trajectories together; zeros where nobody counts.
    fn evaluations(&self) -> [u64; 2];
    /// Energy of the whole, where it is not the sum over trajectories under gravity.
    fn energy(&self) -> Option<f64> {
        None
    }
    /// max |g| of the whole, where it is not that of points on the lemniscate surface.
    fn residual(&self) -> Option<f64> {
        None
    }
    /// Kinetic energy of the whole, where momenta of unit masses do not tell.
    fn kinetic(&self) -> Option<f64> {
        None
    }
    /// Whether time is counted by the clock, because several threads work.
    fn by_the_clock(&self) -> bool {
        false
    }
}

/// Answers requests on the standard input until there are none. `make` is told the row, the number of trajectories, and
/// whether evaluations are counted.
pub(crate) fn serve(rows: &[&str], make: impl Fn(&str, usize, bool) -> Option<Box<dyn Run>>) {
    for line in std::io::stdin().lines() {
        let line = line.expect("a request");
        let words: Vec<&str> = line.split_whitespace().collect();
        match words[..] {
            ["rows"] => println!("{}", rows.join(" ")),
            [verb, row, n, steps] => {
                let (n, steps) = (n.parse().expect("a number"), steps.parse().expect("a number of steps"));
                let timed = verb == "time";
                let mut run = make(row, n, !timed).expect("a row of that name");
                if timed { time(&mut *run, steps) } else { check(&mut *run, n, steps) }
            }
            _ => panic!("{line}: no such request"),
        }
        std::io::stdout().flush().expect("a benchmark that listens");
    }
}

fn time(run: &mut dyn Run, steps: u64) {
    let (clock, cpu) = (std::time::Instant::now(), cpu_seconds());
    run.advance(steps);
    let (clock, cpu) = (clock.elapsed().as_secs_f64(), cpu_seconds() - cpu);
    println!("{:.9e}", if run.by_the_clock() { clock } else { cpu });
}

fn check(run: &mut dyn Run, n: usize, steps: u64) {
    let bodies = |run: &dyn Run| (0..n).map(|i| run.body(i)).collect::<Vec<_>>();
    let kinetic = |p: &[f64; 3]| 0.5 * (p[0] * p[0] + p[1] * p[1] + p[2] * p[2]);
    let energies = |run: &dyn Run| -> Vec<f64> {
        let each = || bodies(run).iter().map(|(q, p)| kinetic(p) + q[2]).collect();
        run.energy().map_or_else(each, |energy| vec![energy])
    };
    let first = energies(run);
    let (mut worst, mut deviation, mut kinetic_sum) = (0.0_f64, 0.0_f64, 0.0);
    for _ in 0..steps {
        run.advance(1);
        if let (Some(residual), Some(kinetic)) = (run.residual(), run.kinetic()) {
            (worst, kinetic_sum) = (worst.max(residual), kinetic_sum + kinetic);
        } else {
            for ([x, y, z], p) in bodies(run) {
                let f = (x * x + y * y).powi(2) - (x * x - y * y);
                let g = (f * f + z * z - 1.0 / 36.0).abs();
                worst = if g.is_nan() { f64::INFINITY } else { worst.max(g) };
                kinetic_sum += kinetic(&p);
            }
        }
        for (now, before) in energies(run).iter().zip(&first) {
            deviation = deviation.max((now - before).abs());
        }
    }
    let number = if run.energy().is_some() { 1.0 } else { n as f64 };
    let [values, gradients] = run.evaluations().map(|count| count as f64 / (n as f64 * steps as f64));
    let mean = kinetic_sum / (number * steps as f64);
    println!("{worst:.3e} {deviation:.6e} {mean:.6e} {values:.4} {gradients:.4}");
    for (q, p) in bodies(run) {
        println!("{:?} {:?} {:?} {:?} {:?} {:?}", q[0], q[1], q[2], p[0], p[1], p[2]);
    }
}

/// A program that waits for requests.
pub(crate) struct Program {
    child: Child,
    requests: Option<ChildStdin>,
    answers: BufReader<ChildStdout>,
}

/// What a row keeps, how many evaluations it makes per step, and where it arrives.
pub(crate) struct Check {
    /// max |g|.
    pub(crate) residual: f64,
    /// max |E − E₀| over the mean kinetic energy.
    pub(crate) deviation: f64,
    /// Of g and ∇g per step.
    pub(crate) evaluations: [f64; 2],
    /// Positions.
    pub(crate) positions: Vec<[f64; 3]>,
}

impl Program {
    /// Starts it.
    pub(crate) fn start(command: &mut Command) -> Result<Self, String> {
        let spawned = command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn();
        let mut child = spawned.map_err(|why| format!("{command:?} does not start: {why}"))?;
        let (requests, answers) = (child.stdin.take(), child.stdout.take());
        let answers = BufReader::new(answers.expect("a pipe was asked for"));
        Ok(Self { child, requests, answers })
    }

    fn line(&mut self) -> Result<Vec<String>, String> {
        let mut line = String::new();
        let length = self.answers.read_line(&mut line).map_err(|why| why.to_string())?;
        if length == 0 {
            return Err("it ended without an answer".into());
        }
        Ok(line.split_whitespace().map(String::from).collect())
    }

    fn numbers(&mut self) -> Result<Vec<f64>, String> {
        let words = self.line()?;
        words.iter().map(|word| word.parse().map_err(|_| format!("{word} is no number"))).collect()
    }

    fn ask(&mut self, request: &str) -> Result<(), String> {
        let requests = self.requests.as_mut().ok_or("it has ended")?;
        writeln!(requests, "{request}").and_then(|()| requests.flush()).map_err(|why| why.to_string())
    }

    /// The names of its rows.
    pub(crate) fn rows(&mut self) -> Result<Vec<String>, String> {
        self.ask("rows")?;
        self.line()
    }

    /// Seconds for so many steps of n trajectories or particles.
    pub(crate) fn time(&mut self, row: &str, n: usize, steps: u64) -> Result<f64, String> {
        self.ask(&format!("time {row} {n} {steps}"))?;
        self.numbers()?.first().copied().ok_or_else(|| "no time was told".into())
    }

    /// The same run, looked at after each step.
    pub(crate) fn check(&mut self, row: &str, n: usize, steps: u64) -> Result<Check, String> {
        self.ask(&format!("check {row} {n} {steps}"))?;
        let head = self.numbers()?;
        let &[residual, deviation, kinetic, values, gradients] = &head[..] else {
            return Err(format!("{head:?} are not five numbers"));
        };
        let mut positions = Vec::new();
        for _ in 0..n {
            let body = self.numbers()?;
            positions.push([body[0], body[1], body[2]]);
        }
        let evaluations = [values, gradients];
        Ok(Check { residual, deviation: deviation / kinetic, evaluations, positions })
    }
}

impl Drop for Program {
    fn drop(&mut self) {
        self.requests = None; // no more requests: it ends by itself
        let _ = self.child.wait();
    }
}
