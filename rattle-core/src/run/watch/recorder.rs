//! Recorders: a table of chosen quantities along a run, kept in memory or passed on, block by block, to a writer.
//!
//! A recorder holds only one block of rows, and passes full blocks to a [`Sink`]. So the memory of a run whose rows go
//! to a file does not grow.

use crate::error::Error;
use crate::number::clock::steps_to;
use crate::run::watch::observer::Observer;
use crate::run::watch::sight::Sight;
use std::collections::BTreeMap;
use std::fmt;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// A block is handed on when it has so many numbers, …
const NUMBERS: usize = 8192;
/// … or rows, …
const ROWS: usize = 1024;
/// … or, where rows come seldom, when it has waited so long.
const WAITS: Duration = Duration::from_secs(1);

/// What a column writes at a sight.
type Quantity<const D: usize> = Arc<dyn Fn(&Sight<'_, D>, &mut Vec<f64>) + Send + Sync>;

/// What a column has in a row.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Entry {
    /// A number.
    Number,
    /// A list of numbers, of which a single one counts as a number.
    Numbers,
    /// A vector for each body.
    Vectors,
}

/// The columns to be recorded, besides step, trajectory and time, which every row has.
///
/// ```
/// # use rattle::{Rattle, Scene, State, watch::{Columns, Recorder, Rows, Sight}};
/// # let start = State::of([[0.0, 1.0], [0.0, 2.0]]).moving([1.0, 0.0]);
/// let mut simulation = Scene::points(2).simulate(start, Rattle::new(0.1))?;
/// let columns = Columns::<2>::new().positions().energies().quantity("height", |now: &Sight<'_, 2>| now.positions[0][1]);
/// let mut recorder = Recorder::of(&columns, Rows::default());
/// simulation.observe(100, 10, &mut recorder)?;
/// let rows = recorder.finish()?;
/// assert_eq!((rows.len(), rows.column("q").unwrap().shape.clone()), (10, vec![2, 2]));
/// assert_eq!(rows.numbers("height").next(), Some(&[1.0][..]));
/// # Ok::<(), rattle::Error>(())
/// ```
#[doc(alias = "output")]
#[doc(alias = "log")]
#[derive(Clone)]
pub struct Columns<const D: usize> {
    columns: Vec<(String, Entry, Quantity<D>)>,
    times: Option<Arc<[f64]>>,
    with_start: bool,
}

impl<const D: usize> Columns<D> {
    /// A table with step, trajectory and time alone; the methods below add columns. Before closures of
    /// [`quantity`](Self::quantity) the compiler has to know the number of coordinates: `Columns::<3>::new()`.
    #[must_use]
    pub fn new() -> Self {
        Self { columns: Vec::new(), times: None, with_start: false }
    }

    /// Adds positions `q` of all bodies, shape [bodies, D].
    #[must_use]
    pub fn positions(self) -> Self {
        self.with("q", Entry::Vectors, |now, to| now.positions.iter().for_each(|q| to.extend(q.iter())))
    }

    /// Adds momenta `p`, shape [bodies, D].
    #[must_use]
    pub fn momenta(self) -> Self {
        self.with("p", Entry::Vectors, |now, to| now.momenta.iter().for_each(|p| to.extend(p.iter())))
    }

    /// Adds `energies`: kinetic and potential; in phase space all of the energy H(q, p), and 0.
    #[must_use]
    pub fn energies(self) -> Self {
        self.with("energies", Entry::Numbers, |now, to| {
            to.extend([now.kinetic_energy(), now.potential_energy()])
        })
    }

    /// Adds `effect_energies`, the potential energy of each effect in the order of the scene, without flows.
    #[must_use]
    pub fn effect_energies(self) -> Self {
        self.with("effect_energies", Entry::Numbers, |now, to| to.extend(now.effect_energies()))
    }

    /// Adds `residuals` g(q, t) of the equations, each in the unit of its g.
    #[must_use]
    pub fn residuals(self) -> Self {
        self.with("residuals", Entry::Numbers, |now, to| to.extend(now.residuals()))
    }

    /// Adds the `temperature` kT, an energy.
    #[must_use]
    pub fn temperature(self) -> Self {
        self.quantity("temperature", |now: &Sight<'_, D>| now.temperature())
    }

    /// Adds multipliers `lambda` of the equations, from g̈ = 0.
    #[must_use]
    pub fn multipliers(self) -> Self {
        self.with("lambda", Entry::Numbers, |now, to| to.extend(now.multipliers()))
    }

    /// Adds `constraint_forces` Gᵀλ on all bodies, shape [bodies, D].
    #[must_use]
    pub fn constraint_forces(self) -> Self {
        self.with("constraint_forces", Entry::Vectors, |now, to| {
            now.constraint_forces().iter().for_each(|force| to.extend(force.iter()));
        })
    }

    /// Adds `iterations`, the number of corrections in the solution of position equations since the start: for linked
    /// bodies that are not computed in lanes; NaN elsewhere. On surfaces, and in lanes,
    /// [`Counted`](crate::kernel::counted::Counted) counts evaluations, which a [`quantity`](Self::quantity) records.
    ///
    /// ```
    /// # use rattle::{prelude::*, surfaces::Sphere, watch::{Columns, Recorder, Rows}};
    /// # let start = State::at([1.0, 0.0, 0.0]).moving([0.0, 1.0, 0.0]);
    /// let sphere = Counted::new(Sphere { r: 1.0 });
    /// let counts = sphere.counts();
    /// let columns = Columns::<3>::new().quantity("evaluations", move |_| counts.values() as f64);
    /// # let mut simulation = Scene::on(sphere).simulate(start, Rattle::new(0.01))?;
    /// # let mut recorder = Recorder::of(&columns, Rows::default());
    /// # simulation.observe(100, 10, &mut recorder)?;
    /// # let rows = recorder.finish()?;
    /// # assert!(rows.numbers("evaluations").last().unwrap()[0] > 100.0);
    /// # Ok::<(), rattle::Error>(())
    /// ```
    #[must_use]
    pub fn iterations(self) -> Self {
        self.with("iterations", Entry::Number, |now, to| {
            to.push(now.corrections().map_or(f64::NAN, |count| count as f64))
        })
    }

    /// Adds a number of your own, a function of a sight.
    #[must_use]
    pub fn quantity(self, name: &str, of: impl Fn(&Sight<'_, D>) -> f64 + Send + Sync + 'static) -> Self {
        self.with(name, Entry::Number, move |now, to| to.push(of(now)))
    }

    /// Adds a row of the start, before the first step that is observed. It is written at the first sight, so none is in
    /// a run that ends before that.
    ///
    /// ```
    /// # use rattle::{Rattle, Scene, State, watch::{Columns, Recorder, Rows}};
    /// # let start = State::at([0.0]).moving([1.0]);
    /// let mut simulation = Scene::points(1).simulate(start, Rattle::new(0.5))?;
    /// let mut recorder = Recorder::of(&Columns::<1>::new().positions().with_start(), Rows::default());
    /// simulation.observe(4, 2, &mut recorder)?;
    /// assert_eq!(recorder.finish()?.numbers, [0.0, 1.0, 2.0]);
    /// # Ok::<(), rattle::Error>(())
    /// ```
    #[must_use]
    pub fn with_start(mut self) -> Self {
        self.with_start = true;
        self
    }

    /// Records only the first sight at or after each of these times, given in any order; where time runs back, at or
    /// before. The start counts as a sight where another follows: it is that of all times that it has reached. A time
    /// that is less than a millionth of a step ahead counts as reached, as by
    /// [`run_until`](crate::run::simulation::Simulation::run_until). Times are not met more exactly than the run is
    /// observed: one between the last sight of a call and its end is met by the first sight of the next call. A run
    /// that goes on from a checkpoint begins with such a sight as well; leave out the times that are recorded already.
    /// With a time that is NaN the run ends with [`Error::Recorder`] at its first row.
    #[must_use]
    pub fn at_times(mut self, times: impl IntoIterator<Item = f64>) -> Self {
        let mut times = times.into_iter().collect::<Vec<_>>();
        times.sort_by(f64::total_cmp);
        self.times = Some(times.into());
        self
    }

    fn with(
        mut self,
        name: &str,
        entry: Entry,
        write: impl Fn(&Sight<'_, D>, &mut Vec<f64>) + Send + Sync + 'static,
    ) -> Self {
        self.columns.push((name.into(), entry, Arc::new(write)));
        self
    }

    /// Whether a row of the start is wanted.
    fn wants_start(&self, start: &Sight<'_, D>) -> bool {
        self.with_start || self.times.as_ref().is_some_and(|times| reached(times, start) > 0)
    }

    /// What is wrong with the names and the times.
    fn mistake(&self) -> Option<String> {
        if self.times.as_ref().is_some_and(|times| times.iter().any(|time| time.is_nan())) {
            return Some("a time at which to record is NaN".into());
        }
        let mut names = vec!["step", "trajectory", "t"];
        for (name, ..) in &self.columns {
            if name.is_empty() {
                return Some("a column needs a name of its own, found an empty one".into());
            }
            if names.contains(&&**name) {
                return Some(format!("a column needs a name of its own, found `{name}` again"));
            }
            names.push(name);
        }
        None
    }
}

/// How many of these times, which are sorted, a trajectory has reached.
fn reached<const D: usize>(times: &[f64], sight: &Sight<'_, D>) -> usize {
    let h = sight.step_size();
    let is_reached = |time: &f64| steps_to(*time, sight.time, h) <= 0.0;
    match h < 0.0 {
        true => times.len() - times.partition_point(|time| !is_reached(time)),
        false => times.partition_point(is_reached),
    }
}

impl<const D: usize> Default for Columns<D> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const D: usize> fmt::Debug for Columns<D> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_list().entries(self.columns.iter().map(|column| &column.0)).finish()
    }
}

/// A column of a table.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Column {
    /// Its name.
    pub name: String,
    /// The shape of its entry in a row; empty for a single number.
    pub shape: Vec<usize>,
    /// The range of a row that it occupies.
    pub place: std::ops::Range<usize>,
}

/// Rows of a table: all of it, or a block.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Rows {
    /// The columns of a row; empty before the first sight.
    pub columns: Arc<[Column]>,
    /// Steps since the run was made.
    pub steps: Vec<u64>,
    /// Trajectory numbers; 0 for a simulation.
    pub trajectories: Vec<u64>,
    /// Times.
    pub times: Vec<f64>,
    /// The values, row by row.
    pub numbers: Vec<f64>,
}

impl Rows {
    /// The number of rows.
    #[must_use]
    pub fn len(&self) -> usize {
        self.times.len()
    }

    /// Whether there are no rows.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.times.is_empty()
    }

    /// The column of this name.
    #[must_use]
    pub fn column(&self, name: &str) -> Option<&Column> {
        self.columns.iter().find(|column| column.name == name)
    }

    /// The numbers of a column, row by row; empty where there is no such column.
    pub fn numbers(&self, name: &str) -> impl Iterator<Item = &[f64]> {
        let width = self.columns.last().map_or(1, |last| last.place.end).max(1);
        let place = self.column(name).map(|column| column.place.clone());
        let rows = self.numbers.chunks_exact(width);
        place.into_iter().flat_map(move |place| rows.clone().map(move |row| &row[place.clone()]))
    }

    /// Checks that these rows can follow others in one table: that they have the same columns.
    ///
    /// # Errors
    /// The first column that differs.
    pub fn fit(&self, others: &Self) -> Result<(), String> {
        if self.columns == others.columns {
            return Ok(());
        }
        let both = |(own, other): &(&Column, &Column)| own.name == other.name && own.shape != other.shape;
        Err(match self.columns.iter().zip(&*others.columns).find(both) {
            Some((Column { name, shape, .. }, Column { shape: other, .. })) => {
                of_another_size(name, other, shape)
            }
            None => "rows have other columns than those before".into(),
        })
    }
}

/// What is told where a column has another shape than in the rows before.
fn of_another_size(name: &str, before: &[usize], now: &[usize]) -> String {
    format!(
        "`{name}` has the shape {before:?} in the rows before and {now:?} in these; record runs of different sizes \
         apart, or into `NpzParts`, whose parts have a shape each"
    )
}

/// The receiver of rows.
pub trait Sink: Send {
    /// Takes a block of rows and leaves it empty, so that its memory can be used again. A block without rows has the
    /// columns of a run in which none was recorded.
    ///
    /// # Errors
    /// Why rows cannot be taken; no more rows are passed after an error.
    fn take(&mut self, rows: &mut Rows) -> Result<(), String>;
    /// Waits until the rows that were taken are where they belong, such as in a file.
    ///
    /// # Errors
    /// Why they cannot get there.
    fn flush(&mut self) -> Result<(), String> {
        Ok(())
    }
    /// Learns that no more rows come.
    fn end(&mut self) {}
    /// Adds the rows of the sink of the next trajectories.
    ///
    /// # Errors
    /// Why they cannot be added.
    fn join(&mut self, next: Self) -> Result<(), String>
    where
        Self: Sized;
}

impl Sink for Rows {
    fn take(&mut self, rows: &mut Rows) -> Result<(), String> {
        if self.is_empty() && !(rows.is_empty() && rows.columns.is_empty()) {
            self.columns = rows.columns.clone();
        } else if !rows.is_empty() {
            rows.fit(self)?;
        }
        self.steps.append(&mut rows.steps);
        self.trajectories.append(&mut rows.trajectories);
        self.times.append(&mut rows.times);
        self.numbers.append(&mut rows.numbers);
        Ok(())
    }
    fn join(&mut self, mut next: Self) -> Result<(), String> {
        self.take(&mut next)
    }
}

/// Records columns of each sight. In an ensemble, rows kept in memory are grouped by trajectory group; blocks passed to
/// a writer come in any order. Each row has its trajectory.
#[doc(alias = "log")]
#[doc(alias = "output")]
#[doc(alias = "dump")]
#[doc(alias = "csv")]
#[derive(Debug)]
pub struct Recorder<S: Sink, const D: usize> {
    columns: Columns<D>,
    rows: Rows,
    /// None once the recorder is finished.
    sink: Option<S>,
    handed_on: u64,
    /// When rows were handed on last.
    at: Instant,
    /// Whether it is known how much stands in a row.
    laid_out: bool,
    /// Steps of the start.
    start: Option<u64>,
    /// By trajectory, where there are times: steps of its last sight, and how many of the times it had reached.
    last: BTreeMap<usize, (u64, usize)>,
    failure: Option<Error>,
}

impl<S: Sink, const D: usize> Recorder<S, D> {
    /// A recorder of these columns into `sink`. Where two columns have one name, or a time is NaN, the run that it
    /// observes ends with [`Error::Recorder`] at its first row.
    pub fn of(columns: &Columns<D>, sink: S) -> Self {
        let failure = columns.mistake().map(|why| Error::Recorder { rows: 0, why });
        let (rows, at, laid_out) = (Rows::default(), Instant::now(), false);
        let (columns, sink) = (columns.clone(), Some(sink));
        let last = BTreeMap::new();
        Self { columns, rows, sink, handed_on: 0, at, laid_out, start: None, last, failure }
    }

    /// Passes on the last rows, and returns the sink. A recorder that is dropped passes them on too, and cannot say
    /// what went wrong.
    ///
    /// # Errors
    /// [`Error::Recorder`] where rows could not be taken.
    pub fn finish(mut self) -> Result<S, Error> {
        self.hand_on_the_last();
        let sink = self.sink.take().map(|mut sink| {
            sink.end();
            sink
        });
        match (self.failure.take(), sink) {
            (None, Some(sink)) => Ok(sink),
            (failure, _) => {
                Err(failure.unwrap_or(Error::Recorder { rows: 0, why: "it was finished".into() }))
            }
        }
    }

    /// Passes on all rows, and waits until they are where they belong, such as in a file: before a checkpoint, so that
    /// no row before it is missing. Files of some formats can be read only when they are finished, whatever was passed
    /// on.
    ///
    /// # Errors
    /// [`Error::Recorder`] where rows could not be taken.
    pub fn flush(&mut self) -> Result<(), Error> {
        self.hand_on();
        if let (None, Some(Err(why))) = (&self.failure, self.sink.as_mut().map(Sink::flush)) {
            self.failure = Some(Error::Recorder { rows: self.handed_on, why });
        }
        self.failure.clone().map_or(Ok(()), Err)
    }

    fn hand_on(&mut self) {
        if !self.rows.is_empty() {
            self.hand_on_all();
        }
    }

    /// The columns too, if there were no rows.
    fn hand_on_the_last(&mut self) {
        if !self.rows.is_empty() || self.handed_on == 0 && !self.rows.columns.is_empty() {
            self.hand_on_all();
        }
    }

    fn hand_on_all(&mut self) {
        let Some(sink) = &mut self.sink else { return };
        if self.failure.is_some() {
            return;
        }
        let rows = self.rows.len() as u64;
        match sink.take(&mut self.rows) {
            Ok(()) => self.handed_on += rows,
            Err(why) => self.failure = Some(Error::Recorder { rows: self.handed_on, why }),
        }
        self.at = Instant::now();
    }

    /// Whether one of the times, if there are some, is reached since the last sight of the trajectory, which may lie
    /// before that of this call; at its first, and where it begins anew, since `before`.
    fn wants(&mut self, before: &Sight<'_, D>, now: &Sight<'_, D>) -> bool {
        let Some(times) = &self.columns.times else { return true };
        let (at_first, number) = (reached(times, before), reached(times, now));
        let last = self.last.insert(now.trajectory, (now.step, number));
        let goes_on = last.filter(|last| last.0 <= before.step);
        number > goes_on.map_or(at_first, |last| last.1.min(at_first))
    }

    fn write(&mut self, now: &Sight<'_, D>) {
        if !self.laid_out {
            self.lay_out(now);
        }
        let already = self.rows.numbers.len();
        self.columns.columns.iter().for_each(|(_, _, write)| write(now, &mut self.rows.numbers));
        let width = self.rows.columns.last().map_or(0, |last| last.place.end);
        if self.rows.numbers.len() != already + width {
            self.rows.numbers.truncate(already);
            return self.refuse(now);
        }
        self.rows.steps.push(now.step);
        self.rows.trajectories.push(now.trajectory as u64);
        self.rows.times.push(now.time);
        let rows = self.rows.len();
        let is_full = self.rows.numbers.len() >= NUMBERS || rows >= ROWS;
        // The clock is asked seldom where rows come fast.
        if is_full || rows.is_power_of_two() && self.at.elapsed() >= WAITS {
            self.hand_on();
        }
    }

    /// Fails, since this sight has a row of another length than those before.
    #[cold]
    fn refuse(&mut self, now: &Sight<'_, D>) {
        let (now, before) = (self.layout(now), self.rows.columns.clone());
        let rows = |columns| Rows { columns, ..Rows::default() };
        let why = rows(now).fit(&rows(before)).err().unwrap_or_default();
        self.failure = Some(Error::Recorder { rows: self.handed_on, why });
    }

    #[cold]
    fn lay_out(&mut self, now: &Sight<'_, D>) {
        self.rows.columns = self.layout(now);
        self.laid_out = true;
    }

    /// How much stands in a row, by a sight. Quantities of a user's are not asked.
    fn layout(&self, now: &Sight<'_, D>) -> Arc<[Column]> {
        let (mut all, mut row) = (Vec::new(), Vec::new());
        for (name, entry, write) in &self.columns.columns {
            let from = row.len();
            match entry {
                Entry::Number => row.push(0.0),
                Entry::Numbers | Entry::Vectors => write(now, &mut row),
            }
            let number = row.len() - from;
            let shape = match entry {
                Entry::Vectors => vec![number / D, D],
                Entry::Number => Vec::new(),
                Entry::Numbers if number == 1 => Vec::new(),
                Entry::Numbers => vec![number],
            };
            all.push(Column { name: name.clone(), shape, place: from..row.len() });
        }
        all.into()
    }
}

impl<S: Sink, const D: usize> Drop for Recorder<S, D> {
    fn drop(&mut self) {
        self.hand_on_the_last();
        if let Some(sink) = &mut self.sink {
            sink.end();
        }
    }
}

impl<S: Sink, const D: usize> Observer<D> for Recorder<S, D> {
    fn see(&mut self, before: &Sight<'_, D>, now: &Sight<'_, D>) {
        if self.failure.is_some() {
            return;
        }
        if *self.start.get_or_insert(before.step) == before.step && self.columns.wants_start(before) {
            self.write(before);
        }
        if self.wants(before, now) {
            self.write(now);
        } else if !self.laid_out {
            self.lay_out(now); // for a file without rows
        }
    }

    fn join(&mut self, mut next: Self) {
        self.hand_on();
        next.hand_on();
        if !self.laid_out {
            self.rows.columns = next.rows.columns.clone();
            self.laid_out = next.laid_out;
        }
        self.last.append(&mut next.last);
        self.failure = self.failure.take().or(next.failure.take());
        if let (Some(sink), Some(next)) = (&mut self.sink, next.sink.take())
            && let Err(why) = sink.join(next)
        {
            self.failure.get_or_insert(Error::Recorder { rows: self.handed_on, why });
        }
        self.handed_on += next.handed_on;
    }

    fn failure(&self) -> Option<Error> {
        self.failure.clone()
    }
}
