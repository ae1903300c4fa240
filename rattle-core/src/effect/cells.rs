//! Cell lists: bodies sorted by cells of space, to find near pairs.
//!
//! Cells are cubes of up to three coordinates, at least as wide as the search distance. Each has a number, computed
//! from its position along each coordinate, and bodies are sorted by this number: so memory is proportional to the
//! number of bodies, however far apart they are. Neighbouring cells along the last coordinate have successive numbers,
//! so the cells next to a cell are a few contiguous ranges of bodies.
//!
//! Source: M. P. Allen, D. J. Tildesley, *Computer Simulation of Liquids*, 2nd ed. (2017), 5.3.2, with sorted bodies
//! for linked lists.

use crate::kernel::space::Space;
use std::array::from_fn;
use std::ops::Range;

/// Coordinates that cells have.
const AXES: usize = 3;
/// The most stretches of bodies beside a cell: three by three, each in two where space closes.
pub(crate) const STRETCHES: usize = 18;
/// Bodies that are looked at together: any so many, from any on, are there to be read.
pub(crate) const BLOCK: usize = 32;
/// Bits of a place along a coordinate.
const BITS: u32 = 21;
/// Farther from the middle cells are one: there are as many to either side.
const FARTHEST: f64 = ((1_u64 << (BITS - 1)) - 2) as f64;
/// By so much cells are wider than needed, for what is rounded on the way to a body's cell.
const MARGIN: f64 = 1.0 + 1.0 / 256.0;

/// Bodies in the order of their cells.
#[derive(Debug, Clone)]
pub(crate) struct Cells<const D: usize> {
    axes: [Axis; AXES],
    bodies: Vec<(u64, u32)>,
    /// The key of each cell with bodies in it, and where they begin; and one beyond the last.
    cells: Vec<(u64, usize)>,
    /// The numbers of the bodies, and a block of anything beyond.
    pub(crate) numbers: Vec<u32>,
    /// Their coordinates, the same.
    pub(crate) places: [Vec<f64>; D],
}

/// Cells along a coordinate.
#[derive(Debug, Clone, Copy)]
struct Axis {
    coordinate: usize,
    middle: f64,
    /// Cells in a unit of length; periods in it where space is closed.
    per_length: f64,
    /// How many cells there are once around, if space is closed.
    around: Option<u64>,
}

impl Axis {
    /// One cell for all.
    const NONE: Self = Self { coordinate: 0, middle: 0.0, per_length: 0.0, around: Some(1) };

    /// The place of a coordinate that is finite.
    #[inline(always)]
    fn place(&self, x: f64) -> u64 {
        match self.around {
            None => {
                let cell = ((x - self.middle) * self.per_length).floor();
                (cell.clamp(-FARTHEST, FARTHEST) + (FARTHEST + 1.0)) as u64
            }
            Some(around) => {
                let periods = x * self.per_length;
                let part = periods - periods.floor();
                ((part * around as f64) as u64).min(around - 1)
            }
        }
    }

    /// The places beside one, itself among them, in stretches.
    fn beside(&self, at: u64) -> impl Iterator<Item = (u64, u64)> + Clone {
        let [first, second] = match self.around {
            None => [Some((at - 1, at + 1)), None],
            Some(around @ 1..=3) => [Some((0, around - 1)), None],
            Some(around) if at == 0 => [Some((0, 1)), Some((around - 1, around - 1))],
            Some(around) if at == around - 1 => [Some((at - 1, at)), Some((0, 0))],
            Some(_) => [Some((at - 1, at + 1)), None],
        };
        first.into_iter().chain(second)
    }

    /// The same one by one.
    fn each_beside(&self, at: u64) -> impl Iterator<Item = u64> + Clone {
        self.beside(at).flat_map(|(from, to)| from..=to)
    }
}

impl<const D: usize> Cells<D> {
    /// Room for so many bodies.
    pub(crate) fn new(bodies: usize) -> Self {
        Self {
            axes: [Axis::NONE; AXES],
            bodies: Vec::with_capacity(bodies),
            cells: Vec::with_capacity(bodies + 1),
            numbers: Vec::with_capacity(bodies + BLOCK),
            places: from_fn(|_| Vec::with_capacity(bodies + BLOCK)),
        }
    }

    /// Sorts bodies, all in finite places: who is nearer than `reach` is in a cell beside. Where space is closed, the
    /// reach is some thousand roundings of the largest coordinate at least.
    pub(crate) fn sort<B: Space<D>>(&mut self, positions: &[[f64; D]], space: &B, reach: f64) {
        let width = reach * MARGIN;
        self.axes = axes(positions, space, width);
        let axes = self.axes;
        let key = |q: &[f64; D]| {
            let places = axes.map(|axis| axis.place(q[axis.coordinate]));
            key(places)
        };
        self.bodies.clear();
        self.bodies.extend((0..).zip(positions).map(|(number, q)| (key(q), number)));
        self.bodies.sort_unstable();
        self.numbers.clear();
        self.numbers.extend(self.bodies.iter().map(|&(_, number)| number));
        for (d, places) in self.places.iter_mut().enumerate() {
            places.clear();
            places.extend(self.numbers.iter().map(|&number| positions[number as usize][d]));
            places.extend([0.0; BLOCK]);
        }
        self.numbers.extend([0; BLOCK]);
        self.cells.clear();
        let mut last = None;
        for (at, &(key, _)) in self.bodies.iter().enumerate() {
            if last != Some(key) {
                self.cells.push((key, at));
                last = Some(key);
            }
        }
        self.cells.push((u64::MAX, self.bodies.len()));
    }

    /// How many cells have bodies in them.
    pub(crate) fn number(&self) -> usize {
        self.cells.len() - 1
    }

    /// The bodies of a cell.
    pub(crate) fn of(&self, cell: usize) -> Range<usize> {
        self.cells[cell].1..self.cells[cell + 1].1
    }

    /// The stretches of bodies in a cell and beside it, and how many there are. Hints are where those of the last cell
    /// asked about were, at first anything within bounds: the next ones are not far.
    pub(crate) fn beside(
        &self,
        cell: usize,
        hints: &mut [usize; STRETCHES],
    ) -> ([Range<usize>; STRETCHES], usize) {
        let [a, b, c] = places(self.cells[cell].0);
        let (mut stretches, mut count) = ([const { 0..0 }; STRETCHES], 0);
        for a in self.axes[0].each_beside(a) {
            for b in self.axes[1].each_beside(b) {
                for (first, last) in self.axes[2].beside(c) {
                    let hint = &mut hints[count];
                    let from = self.first_at(key([a, b, first]), hint);
                    let to = self.first_at(key([a, b, last]) + 1, &mut hint.clone());
                    stretches[count] = from..to;
                    count += 1;
                }
            }
        }
        (stretches, count)
    }

    /// The first body in a cell of at least this key, sought from the cell `hint` on, which is left there.
    #[inline(always)]
    fn first_at(&self, key: u64, hint: &mut usize) -> usize {
        while self.cells[*hint].0 < key {
            *hint += 1;
        }
        while *hint > 0 && self.cells[*hint - 1].0 >= key {
            *hint -= 1;
        }
        self.cells[*hint].1
    }
}

fn key(places: [u64; AXES]) -> u64 {
    places.iter().fold(0, |key, place| key << BITS | place)
}

fn places(key: u64) -> [u64; AXES] {
    [2, 1, 0].map(|back| key >> (back * BITS) & ((1 << BITS) - 1))
}

/// Cells of at least this width along up to three coordinates: those in which some of the bodies lie farthest apart.
fn axes<B: Space<D>, const D: usize>(positions: &[[f64; D]], space: &B, width: f64) -> [Axis; AXES] {
    const SOME: usize = 63;
    let mut chosen = [(0.0, Axis::NONE); AXES];
    for coordinate in 0..D {
        let period = space.periods()[coordinate];
        let every = (positions.len() / SOME).max(1);
        let (mut sample, mut size) = ([0.0; SOME], 0);
        for q in positions.iter().step_by(every).take(SOME) {
            sample[size] = q[coordinate];
            size += 1;
        }
        sample[..size].sort_unstable_by(f64::total_cmp);
        let axis = if period.is_finite() {
            let around = (period / width).floor().clamp(1.0, FARTHEST) as u64;
            Axis { coordinate, middle: 0.0, per_length: period.recip(), around: Some(around) }
        } else {
            Axis { coordinate, middle: sample[size / 2], per_length: width.recip(), around: None }
        };
        // Seven eighths of them, so that few far away decide nothing.
        let spread = (sample[size - 1 - size / 16] - sample[size / 16]).min(period);
        let last = &mut chosen[AXES - 1];
        if spread >= last.0 {
            *last = (spread, axis);
            chosen.sort_by(|a, b| b.0.total_cmp(&a.0));
        }
    }
    chosen.map(|(_, axis)| axis)
}
