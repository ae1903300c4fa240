//! The bodies of a running simulation, stored side by side.

use crate::effect::noise::Noise;
use crate::number::real::Scalar;
use std::fmt::Debug;

/// The number of bodies of a scene, as a type: [`One`], known at compile time, or [`Many`].
pub trait Count: Copy + Debug + Send + Sync + 'static {
    /// Whether there can be more than one.
    const MANY: bool;
    /// Storage for one `X` per body.
    type Of<X: Copy + Debug + Send + Sync>: AsRef<[X]> + AsMut<[X]> + Clone + Debug + Send + Sync;

    /// The number of bodies.
    fn number(self) -> usize;
    /// The same `x` for each body.
    fn each<X: Copy + Debug + Send + Sync>(self, x: X) -> Self::Of<X>;
}

/// Exactly one body, known at compile time: readings such as `position()` need no body number.
#[diagnostic::on_unimplemented(
    message = "there may be many bodies here, and none of them is the one that is asked for",
    label = "a scene of one body has one position, momentum, velocity and multiplier",
    note = "of many bodies: `.positions()`, `.momenta()`, `.velocities()`, which are iterators, and `.multipliers()`",
    note = "a scene is one of many bodies after `.bodies(n)` and `Scene::points(n)`, even for n = 1; `Scene::on` and `Scene::point` make one of one"
)]
pub trait Alone: Count {}

impl Alone for One {}

/// One body: arrays of length one, so that the compiler removes loops over bodies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct One;

impl Count for One {
    const MANY: bool = false;
    type Of<X: Copy + Debug + Send + Sync> = [X; 1];

    #[inline(always)]
    fn number(self) -> usize {
        1
    }
    fn each<X: Copy + Debug + Send + Sync>(self, x: X) -> [X; 1] {
        [x]
    }
}

/// This many bodies, in vectors that are allocated once.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Many(pub usize);

impl Count for Many {
    const MANY: bool = true;
    type Of<X: Copy + Debug + Send + Sync> = Vec<X>;

    #[inline(always)]
    fn number(self) -> usize {
        self.0
    }
    fn each<X: Copy + Debug + Send + Sync>(self, x: X) -> Vec<X> {
        vec![x; self.0]
    }
}

/// Position and momentum of one body, each a sum of two numbers: `q + q_low` and `p + p_low`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Body<T, const D: usize> {
    /// Position, rounded.
    pub q: [T; D],
    /// The rounding error of `q`, to be added to it.
    pub q_low: [T; D],
    /// Momentum, rounded.
    pub p: [T; D],
    /// The rounding error of `p`, to be added to it.
    pub p_low: [T; D],
}

impl<T, const D: usize> Body<T, D> {
    /// The same in other numbers.
    pub(crate) fn map<U>(self, number: impl Fn(T) -> U) -> Body<U, D> {
        let Self { q, q_low, p, p_low } = self;
        let [q, q_low, p, p_low] = [q, q_low, p, p_low].map(|x| x.map(&number));
        Body { q, q_low, p, p_low }
    }
}

impl<T: Copy, const D: usize> Body<T, D> {
    /// Positions alone.
    #[inline(never)]
    pub(crate) fn positions(bodies: &[Self]) -> Vec<[T; D]> {
        bodies.iter().map(|body| body.q).collect()
    }

    /// Momenta alone.
    #[inline(never)]
    pub(crate) fn momenta(bodies: &[Self]) -> Vec<[T; D]> {
        bodies.iter().map(|body| body.p).collect()
    }
}

/// Bodies of which positions, momenta and what rounding took from them are in four lists.
#[inline(never)]
pub(crate) fn gathered<T: Copy, const D: usize>([q, q_low, p, p_low]: [&[[T; D]]; 4]) -> Vec<Body<T, D>> {
    (0..q.len()).map(|i| Body { q: q[i], q_low: q_low[i], p: p[i], p_low: p_low[i] }).collect()
}

/// And back.
#[inline(never)]
pub(super) fn scatter<T: Copy, const D: usize>(
    places: &[Body<T, D>],
    [q, q_low, p, p_low]: [&mut [[T; D]]; 4],
) {
    for (i, place) in places.iter().enumerate() {
        (q[i], q_low[i], p[i], p_low[i]) = (place.q, place.q_low, place.p, place.p_low);
    }
}

/// Positions and momenta of all bodies, and what a [`System`](crate::motion::system::System) has evaluated there.
///
/// Positions and momenta are compensated sums: the value is `q + q_low`, where `q_low` is the rounding error of `q`. Of
/// `kept`, a step reads only functions of positions and time.
#[derive(Debug, Clone)]
pub struct Bodies<N: Count, T: Scalar, X, const D: usize> {
    /// Positions, rounded.
    pub q: N::Of<[T; D]>,
    /// The rounding errors of `q`, to be added to it.
    pub q_low: N::Of<[T; D]>,
    /// Momenta, rounded.
    pub p: N::Of<[T; D]>,
    /// The rounding errors of `p`, to be added to it.
    pub p_low: N::Of<[T; D]>,
    /// The time, which a system has pass with its drifts wherever constraints or forces change with it.
    pub time: f64,
    /// Work done by moving constraints, potentials that change with time, flows of momenta and impacts since the start.
    pub work: T,
    /// ∂U/∂t by effects whose potential changes with time, with the last forces; zero where there are none.
    pub power: T,
    /// The position in the stream of random numbers; updated only where a scene has flows, or the method
    /// [draws](crate::motion::method::Method::DRAWS).
    pub noise: Noise,
    /// What effects remember from step to step, see [`Acting::marks`](crate::effect::Acting::marks).
    pub marks: Vec<T>,
    /// Quantities evaluated at the positions: normals, forces.
    pub kept: X,
    /// Room for a method to work in, made [before a run](crate::motion::method::Method::prepare).
    pub(crate) room: Option<Box<Room<N, T, D>>>,
}

/// A saved copy of positions, momenta, time and work, without `kept`, which is a function of them.
pub type Saved<N, T, const D: usize> = Bodies<N, T, (), D>;

/// Room for a method to work in.
#[derive(Debug, Clone)]
pub(crate) struct Room<N: Count, T: Scalar, const D: usize> {
    /// For what is put aside.
    saved: Saved<N, T, D>,
    /// Whole sets of one vector per body.
    vectors: Vec<[T; D]>,
    /// More of them, [lent](Bodies::lend) for a whole step, within which the others are used.
    lent: Vec<[T; D]>,
    /// In how many inner steps the last step went of a method that divides its steps.
    inner_steps: u32,
}

impl<N: Count, T: Scalar, X, const D: usize> Bodies<N, T, X, D> {
    /// Bodies at these positions and momenta, in their order.
    ///
    /// # Panics
    /// If there are fewer places than bodies.
    pub fn new(count: N, kept: X, places: &[Body<T, D>], time: f64) -> Self {
        let zero = count.each([T::from_f64(0.0); D]);
        let (q, q_low, p, p_low) = (zero.clone(), zero.clone(), zero.clone(), zero);
        let (work, power, noise) = (T::from_f64(0.0), T::from_f64(0.0), Noise::default());
        let marks = Vec::new();
        let mut bodies = Self { q, q_low, p, p_low, time, work, power, noise, marks, kept, room: None };
        bodies.put(&places[..count.number()]);
        bodies
    }

    /// Puts each body at one of these places.
    pub(crate) fn put(&mut self, places: &[Body<T, D>]) {
        let lists = [self.q.as_mut(), self.q_low.as_mut(), self.p.as_mut(), self.p_low.as_mut()];
        scatter(places, lists);
    }

    /// A saved copy, which [`save`](Self::save) can overwrite later.
    pub fn saved(&self) -> Saved<N, T, D> {
        let (q, q_low, p, p_low) = (self.q.clone(), self.q_low.clone(), self.p.clone(), self.p_low.clone());
        let Self { time, work, power, noise, .. } = *self;
        let marks = self.marks.clone();
        Bodies { q, q_low, p, p_low, time, work, power, noise, marks, kept: (), room: None }
    }

    /// Saves positions, momenta, time and work, without allocating. The memory of effects (`marks`) is saved by
    /// [`put_aside`](crate::motion::affected::Affected::put_aside).
    #[inline(always)]
    pub fn save(&self, to: &mut Saved<N, T, D>) {
        to.take_over(self);
    }

    /// Restores positions, momenta, time and work of as many bodies, without allocating. `kept` and `marks` are
    /// restored by [`put_back`](crate::motion::affected::Affected::put_back).
    #[inline(always)]
    pub fn restore(&mut self, from: &Saved<N, T, D>) {
        self.take_over(from);
    }

    #[inline(always)]
    fn take_over<Y>(&mut self, other: &Bodies<N, T, Y, D>) {
        self.q.as_mut().copy_from_slice(other.q.as_ref());
        self.q_low.as_mut().copy_from_slice(other.q_low.as_ref());
        self.p.as_mut().copy_from_slice(other.p.as_ref());
        self.p_low.as_mut().copy_from_slice(other.p_low.as_ref());
        (self.time, self.work) = (other.time, other.work);
    }

    /// Makes room for so many vectors per body, beside what is there.
    pub(crate) fn make_room(&mut self, vectors: usize) {
        let length = vectors * self.q.as_ref().len();
        let room = self.room.take();
        self.room = Some(self.roomier(room, length));
    }

    /// That room, or a new one, with so many vectors at least.
    fn roomier(&self, room: Option<Box<Room<N, T, D>>>, length: usize) -> Box<Room<N, T, D>> {
        let new =
            || Box::new(Room { saved: self.saved(), vectors: Vec::new(), lent: Vec::new(), inner_steps: 1 });
        let mut room = room.unwrap_or_else(new);
        let length = length.max(room.vectors.len());
        room.vectors.resize(length, [T::from_f64(0.0); D]);
        room
    }

    /// Does work with room to put the bodies aside and for so many vectors per body; made here where no simulation has
    /// made it before.
    #[inline(always)]
    pub(crate) fn with_room<R>(
        &mut self,
        vectors: usize,
        work: impl FnOnce(&mut Self, &mut Saved<N, T, D>, &mut [[T; D]]) -> R,
    ) -> R {
        let length = vectors * self.q.as_ref().len();
        let mut room = match self.room.take() {
            Some(room) if room.vectors.len() >= length => room,
            room => self.roomier(room, length),
        };
        let done = work(self, &mut room.saved, &mut room.vectors[..length]);
        self.room = Some(room);
        done
    }

    /// So many vectors, for a step that has [room](Self::with_room) itself; to be [taken back](Self::take_back).
    pub(crate) fn lend(&mut self, number: usize) -> Vec<[T; D]> {
        let mut lent = self.room.as_mut().map_or(Vec::new(), |room| std::mem::take(&mut room.lent));
        lent.resize(number, [T::from_f64(0.0); D]);
        lent
    }

    /// Keeps vectors that were lent, for the next time.
    pub(crate) fn take_back(&mut self, lent: Vec<[T; D]>) {
        if let Some(room) = &mut self.room {
            room.lent = lent;
        }
    }

    /// Notes in how many inner steps a step went.
    #[inline(always)]
    pub(crate) fn note_inner_steps(&mut self, number: u32) {
        self.room.iter_mut().for_each(|room| room.inner_steps = number);
    }

    /// In how many inner steps the last step went: in one, where a method does not divide its steps.
    pub(crate) fn inner_steps(&self) -> u32 {
        self.room.as_ref().map_or(1, |room| room.inner_steps)
    }

    /// Positions, what rounding took from them, momenta, and what rounding took from these.
    pub(crate) fn lists(&self) -> [&[[T; D]]; 4] {
        [self.q.as_ref(), self.q_low.as_ref(), self.p.as_ref(), self.p_low.as_ref()]
    }

    /// All bodies in their order.
    pub(crate) fn all(&self) -> Vec<Body<T, D>> {
        gathered(self.lists())
    }

    /// Body number `i`.
    pub fn body(&self, i: usize) -> Body<T, D> {
        Body {
            q: self.q.as_ref()[i],
            q_low: self.q_low.as_ref()[i],
            p: self.p.as_ref()[i],
            p_low: self.p_low.as_ref()[i],
        }
    }
}
