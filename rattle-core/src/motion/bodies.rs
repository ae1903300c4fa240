//! The bodies of a running simulation, stored side by side.

use crate::number::real::Real;
use std::fmt::Debug;

/// How many bodies a scene has: exactly one, known when compiling, or many.
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

/// One body: its state lives in arrays of length one, and loops over bodies vanish.
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

/// This many bodies, allocated once.
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
    /// What rounding took from the position.
    pub q_low: [T; D],
    /// Momentum, rounded.
    pub p: [T; D],
    /// What rounding took from the momentum.
    pub p_low: [T; D],
}

/// Positions and momenta of all bodies, and what a [`System`](crate::motion::system::System) keeps at them.
///
/// Positions and momenta are compensated sums: the value is `q + q_low`, where `q_low` holds what
/// rounding took from `q`. What a step reads of what is kept is a function of positions and time alone.
#[derive(Debug, Clone)]
pub struct Bodies<N: Count, T: Real, X, const D: usize> {
    /// Positions, rounded.
    pub q: N::Of<[T; D]>,
    /// What rounding took from the positions.
    pub q_low: N::Of<[T; D]>,
    /// Momenta, rounded.
    pub p: N::Of<[T; D]>,
    /// What rounding took from the momenta.
    pub p_low: N::Of<[T; D]>,
    /// The time; only a system with moving constraints looks at it.
    pub time: f64,
    /// Work done by moving constraints and by flows of momenta since the start.
    pub work: T,
    /// What was evaluated at the positions: normals, forces.
    pub kept: X,
    /// Room for a [method](crate::motion::method::Method::room) to work in: whole sets of one vector per body.
    pub room: Vec<[T; D]>,
}

impl<N: Count, T: Real, X, const D: usize> Bodies<N, T, X, D> {
    /// The bodies in these places.
    pub fn new(count: N, kept: X, place: impl Fn(usize) -> Body<T, D>, time: f64) -> Self {
        let zero = count.each([T::from_f64(0.0); D]);
        let (q, q_low, p, p_low) = (zero.clone(), zero.clone(), zero.clone(), zero);
        let mut bodies = Self { q, q_low, p, p_low, time, work: T::from_f64(0.0), kept, room: Vec::new() };
        for i in 0..count.number() {
            let Body { q, q_low, p, p_low } = place(i);
            (bodies.q.as_mut()[i], bodies.q_low.as_mut()[i]) = (q, q_low);
            (bodies.p.as_mut()[i], bodies.p_low.as_mut()[i]) = (p, p_low);
        }
        bodies
    }

    /// Does work that needs room for so many vectors per body; made here where no simulation has made it before.
    #[inline(always)]
    pub(crate) fn with_room<R>(
        &mut self,
        vectors: usize,
        work: impl FnOnce(&mut Self, &mut [[T; D]]) -> R,
    ) -> R {
        let length = vectors * self.q.as_ref().len();
        let mut room = std::mem::take(&mut self.room);
        if room.len() < length {
            room = vec![[T::from_f64(0.0); D]; length];
        }
        let done = work(self, &mut room[..length]);
        self.room = room;
        done
    }

    /// The body of this number.
    pub fn body(&self, i: usize) -> Body<T, D> {
        Body {
            q: self.q.as_ref()[i],
            q_low: self.q_low.as_ref()[i],
            p: self.p.as_ref()[i],
            p_low: self.p_low.as_ref()[i],
        }
    }

    /// Takes over places and momenta of `other`, which has as many bodies, without allocating; not what is kept.
    #[inline(always)]
    pub fn copy_from<Y>(&mut self, other: &Bodies<N, T, Y, D>) {
        self.q.as_mut().copy_from_slice(other.q.as_ref());
        self.q_low.as_mut().copy_from_slice(other.q_low.as_ref());
        self.p.as_mut().copy_from_slice(other.p.as_ref());
        self.p_low.as_mut().copy_from_slice(other.p_low.as_ref());
        (self.time, self.work) = (other.time, other.work);
    }
}
