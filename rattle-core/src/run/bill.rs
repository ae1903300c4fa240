//! The bill: what a step costs, in total and for each effect.

use crate::effect::interval::Half;
use crate::effect::list::Forces;
use crate::error::Error;
use crate::motion::course::look;
use crate::motion::method::Method;
use crate::motion::stir::{Chosen, stir, times};
use crate::motion::system::System;
use crate::run::simulation::Simulation;
use std::fmt;
use std::hint::black_box;
use std::time::{Duration, Instant};

/// Samples of each item, of which the median counts.
const SAMPLES: usize = 5;
/// A sample lasts so long at least: clocks tell 50 ns.
const SAMPLE: Duration = Duration::from_micros(400);

/// The time of a step on one thread, item by item; made by [`Simulation::bill`] and, for one trajectory of an ensemble,
/// by [`Ensemble::bill`](crate::run::ensemble::Ensemble::bill). `Display` shows a table.
#[doc(alias = "profile")]
#[doc(alias = "benchmark")]
#[doc(alias = "cost")]
#[derive(Debug, Clone, PartialEq)]
pub struct Bill {
    /// Nanoseconds per step.
    pub step: f64,
    /// The parts that are measured separately, and at last the rest of the step. Where parts by themselves take longer
    /// than in the step, which does several at once, the rest is 0, and their sum is more than the step.
    pub items: Vec<Item>,
    /// The number of bodies.
    pub bodies: usize,
    /// How many trajectories are computed at once in SIMD lanes; times are those for one of them.
    pub side_by_side: usize,
}

/// An item of a [`Bill`].
#[derive(Debug, Clone, PartialEq)]
pub struct Item {
    /// The name of an effect's type, or of a part of the step.
    pub what: String,
    /// Nanoseconds per step.
    pub nanoseconds: f64,
}

impl Item {
    /// That of a force.
    pub(in crate::run) fn of_force(name: &str, nanoseconds: f64) -> Self {
        Self { what: format!("force of `{name}`"), nanoseconds }
    }
}

impl Bill {
    /// That of nothing.
    pub(in crate::run) fn nothing() -> Self {
        Self { step: 0.0, items: Vec::new(), bodies: 0, side_by_side: 0 }
    }

    /// The bill of a step that takes so many nanoseconds, with these items and what is left of it.
    pub(in crate::run) fn new(step: f64, mut items: Vec<Item>, rest: String, bodies: usize) -> Self {
        let known: f64 = items.iter().map(|item| item.nanoseconds).sum();
        items.push(Item { what: rest, nanoseconds: (step - known).max(0.0) });
        Self { step, items, bodies, side_by_side: 1 }
    }
}

impl fmt::Display for Bill {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let width = self.items.iter().map(|item| item.what.chars().count()).max().unwrap_or(0).max(4);
        let digits = if self.step < 10.0 { 3 } else { 1 };
        for Item { what, nanoseconds } in &self.items {
            let share = 100.0 * nanoseconds / self.step;
            writeln!(f, "{what:width$}  {nanoseconds:>10.digits$} ns  {share:>5.1} %")?;
        }
        write!(f, "{:width$}  {:>10.digits$} ns", "step", self.step)?;
        if self.bodies > 1 {
            write!(f, ", {:.1} ns a body", self.step / self.bodies as f64)?;
        }
        if self.side_by_side > 1 {
            write!(f, " of each of {} side by side", self.side_by_side)?;
        }
        Ok(())
    }
}

impl<Y: System<f64, D>, S: Method, const D: usize> Simulation<Y, S, D> {
    /// What a step costs at the present state, item by item. A copy of the simulation is run for some milliseconds (for
    /// some steps, if they are long), and its parts are timed separately. The simulation itself is unchanged, and other
    /// runs are not slowed.
    ///
    /// Forces are counted as often as a step evaluates them. For methods whose number of evaluations is not known in
    /// advance (`Lobatto`, `Taylor`, `Dop853`, `Bdf2`) forces are not listed separately.
    ///
    /// ```
    /// # use rattle::potentials::Gravity;
    /// # use rattle::{surfaces::Torus, Rattle, Scene, State};
    /// let scene = Scene::on(Torus { major: 1.0, minor: 0.25 }).with(Gravity { g: 1.0 });
    /// let mut simulation = scene.simulate(State::at([1.25, 0.0, 0.0]).moving([0.0, 1.0, 0.0]), Rattle::new(0.01))?;
    /// simulation.run(100)?;
    /// let bill = simulation.bill()?;
    /// println!("{bill}");
    /// assert_eq!(bill.items[0].what, "force of `Gravity`");
    /// assert_eq!(simulation.steps(), 100);
    /// # Ok::<(), rattle::Error>(())
    /// ```
    ///
    /// # Errors
    /// Those of the steps that are tried.
    #[inline(never)]
    pub fn bill(&self) -> Result<Bill, Error> {
        let mut copy = self.clone();
        copy.step()?;
        let mut failed = None;
        let step = time(&mut || {
            if failed.is_none() {
                failed = copy.step().err();
            }
        });
        if let Some(error) = failed {
            return Err(error);
        }

        let mut items = Vec::new();
        let mut copy = self.clone();
        if let Some(evaluations) = self.method.evaluations() {
            let mut forces = vec![[0.0; D]; self.bodies()];
            for number in 0..Y::EFFECTS {
                let mut alone =
                    || copy.system.add_force_alone(number, &mut copy.bodies, black_box(&mut forces));
                if let Some(name) = alone() {
                    let one = time(&mut || {
                        alone();
                    });
                    items.push(Item::of_force(name, evaluations as f64 * one));
                }
            }
        }
        if const { Y::FLOWS > 0 } {
            let mut names = Vec::new();
            for number in 0..Y::FLOWS {
                names.push(self.system.effects().manner(number).1);
            }
            let h = 1e-6 * self.method.step_size();
            let (system, bodies) = (&copy.system, &mut copy.bodies);
            let one = time(&mut || drop(black_box(stir(Chosen::All, Half::Before, h, system, bodies))));
            let nanoseconds = f64::from(times::<S, _, _, D>(&self.system)) * one;
            items.push(Item { what: format!("momenta by `{}`", names.join("`, `")), nanoseconds });
        }
        let mut copy = self.clone();
        let look = time(&mut || {
            let h = copy.method.step_size();
            drop(black_box(look::<S, _, _, D>(h, &copy.system, &copy.before, &mut copy.bodies)));
        });
        items.push(Item { what: "looking whether a step is right".into(), nanoseconds: look });
        let rest = format!("places and constraints by {}", self.method.name());
        Ok(Bill::new(step, items, rest, self.bodies()))
    }
}

/// Nanoseconds that it takes: the median of some samples.
pub(in crate::run) fn time(work: &mut dyn FnMut()) -> f64 {
    let mut repeats = 1_u32;
    let mut sample = |repeats: u32| {
        let start = Instant::now();
        (0..repeats).for_each(|_| work());
        start.elapsed()
    };
    while sample(repeats) < SAMPLE && repeats < 1 << 20 {
        repeats *= 2;
    }
    let mut samples: Vec<_> = (0..SAMPLES).map(|_| sample(repeats)).collect();
    samples.sort();
    samples[SAMPLES / 2].as_nanos() as f64 / f64::from(repeats)
}
