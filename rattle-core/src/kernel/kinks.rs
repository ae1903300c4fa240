//! Whether equations are smooth between two positions: where an argument of `abs`, `min`, `if` … has different signs at
//! the two, the normals on both sides of its zero are compared.
//!
//! ```text
//! q(s) = from + s (to − from)      s halved until a and b, on both sides, are 10⁻⁶ apart; 10⁻¹⁰ before a small jump is told
//! jump = |n(a) − n(b)|             n = ∇g/|∇g|; smooth is a jump of at most τ² between 10⁻⁶ and 1/16,
//! τ = |n(from) − n(a)| + |n(b) − n(to)|          how far the normal turns otherwise
//! ```
//!
//! A jump by θ changes an energy by about θ² at each crossing; a rotation of the normal by τ in a step has errors of
//! τ². The line leaves the surface by an eighth of τ times its length, where functions that agree on the surface need
//! not have the same normal: so less than τ² is not a jump. The same holds for g itself, as a length in units of the
//! path.

use crate::kernel::functions::{ConstraintKernel, PhaseConstraintKernel};
use crate::number::real::{Real, Scalar};
use crate::number::vector::{add_scaled, dot, largest, scaled};
use std::array::from_fn;

/// Arguments that are compared at a time.
const PAGE: usize = 32;
/// Halvings of the way until its two sides are compared: smooth normals differ there by some 10⁻⁶ of a turn.
const HALVINGS: u32 = 20;
/// So many more of them before a small jump is told: a normal that turns fast, but smoothly, turns by a four-thousandth
/// there.
const FURTHER: u32 = 12;
/// What turns by more within the first of them is as sharp as an edge to the step, however it is rounded.
const SHARP: f64 = 1e-3;
/// Smaller jumps change an energy by less than 10⁻¹² of itself.
const SMALLEST: f64 = 1e-6;
/// Larger ones are jumps however far the normal turns in the step.
const LARGEST: f64 = 1.0 / 16.0;

/// A position, or with H = 2 a position and a momentum.
type Place<T, const D: usize, const H: usize> = [[T; D]; H];

/// Equations between positions, or with H = 2 between positions and momenta.
pub(crate) trait Kinked<T, const D: usize, const H: usize, const M: usize> {
    /// What changes sign where they are not smooth, and its values from one on.
    const KINKS: &'static [&'static str];
    fn kinks(&self, at: &Place<T, D, H>, first: usize, found: &mut [T]);
    /// g and ∇g.
    fn slopes(&self, at: &Place<T, D, H>) -> ([T; M], [Place<T, D, H>; M]);
}

impl<T: Real, K: ConstraintKernel<T, D, M>, const D: usize, const M: usize> Kinked<T, D, 1, M> for K {
    const KINKS: &'static [&'static str] = K::KINKS;

    #[inline(always)]
    fn kinks(&self, [q]: &[[T; D]; 1], first: usize, found: &mut [T]) {
        ConstraintKernel::kinks(self, q, first, found);
    }

    #[inline(always)]
    fn slopes(&self, [q]: &[[T; D]; 1]) -> ([T; M], [[[T; D]; 1]; M]) {
        let (g, gradients) = self.value_and_jacobian(q);
        (g, gradients.map(|gradient| [gradient]))
    }
}

impl<T: Real, K: PhaseConstraintKernel<T, D, M>, const D: usize, const M: usize> Kinked<T, D, 2, M> for K {
    const KINKS: &'static [&'static str] = K::KINKS;

    #[inline(always)]
    fn kinks(&self, [q, p]: &[[T; D]; 2], first: usize, found: &mut [T]) {
        PhaseConstraintKernel::kinks(self, q, p, first, found);
    }

    #[inline(always)]
    fn slopes(&self, [q, p]: &[[T; D]; 2]) -> ([T; M], [[[T; D]; 2]; M]) {
        let (g, by_q, by_p) = self.value_and_jacobians(q, p);
        (g, from_fn(|i| [by_q[i], by_p[i]]))
    }
}

/// Where the normal of an equation jumps.
pub(crate) struct Kink {
    /// What changes its sign there.
    pub(crate) argument: &'static str,
    pub(crate) equation: usize,
    /// The part of the way that lies before it.
    pub(crate) share: f64,
    /// The position there.
    pub(crate) place: Vec<f64>,
    /// The angle by which the normal jumps.
    pub(crate) angle: f64,
    /// How far the surface jumps.
    pub(crate) gap: f64,
}

/// Whether an argument has another sign at one place than at the other. Nothing at all where equations have no
/// kinks.
#[inline(always)]
pub(crate) fn sign_changes<T, K, const D: usize, const H: usize, const M: usize>(
    kernel: &K,
    from: &Place<T, D, H>,
    to: &Place<T, D, H>,
) -> bool
where
    T: Scalar,
    K: Kinked<T, D, H, M>,
{
    let mut changes = of_page(kernel, 0, from, to);
    if const { K::KINKS.len() > PAGE } {
        for first in (PAGE..K::KINKS.len()).step_by(PAGE) {
            changes |= of_page(kernel, first, from, to);
        }
    }
    changes
}

/// Whether one of the arguments from this one on may have another sign; a product that is too small for a float
/// is taken for one.
#[inline(always)]
fn of_page<T, K, const D: usize, const H: usize, const M: usize>(
    kernel: &K,
    first: usize,
    from: &Place<T, D, H>,
    to: &Place<T, D, H>,
) -> bool
where
    T: Scalar,
    K: Kinked<T, D, H, M>,
{
    let zero = T::from_f64(0.0);
    let (mut before, mut after) = ([zero; PAGE], [zero; PAGE]);
    kernel.kinks(from, first, &mut before);
    kernel.kinks(to, first, &mut after);
    let mut changes = false;
    for i in 0..if K::KINKS.len() < PAGE { K::KINKS.len() } else { PAGE } {
        let (was, is) = (before[i], after[i]);
        let same = zero.lt(was * is) | (was.le(is) & is.le(was));
        changes |= !same;
    }
    changes
}

/// The first place on the way where the normal of an equation jumps.
pub(crate) fn first_kink<T, K, const D: usize, const H: usize, const M: usize>(
    kernel: &K,
    from: &Place<f64, D, H>,
    to: &Place<f64, D, H>,
) -> Option<Kink>
where
    T: Scalar,
    K: Kinked<T, D, H, M>,
{
    // A constant, so that the compiler does not go through the search where there are no kinks.
    let search: Search<K, D, H> =
        const { if K::KINKS.is_empty() { |_, _, _| None } else { search::<T, K, D, H, M> } };
    search(kernel, from, to)
}

/// Who looks for a kink between two places.
type Search<K, const D: usize, const H: usize> = fn(&K, &Place<f64, D, H>, &Place<f64, D, H>) -> Option<Kink>;

#[cold]
#[inline(never)]
fn search<T, K, const D: usize, const H: usize, const M: usize>(
    kernel: &K,
    from: &Place<f64, D, H>,
    to: &Place<f64, D, H>,
) -> Option<Kink>
where
    T: Scalar,
    K: Kinked<T, D, H, M>,
{
    let mut way = Way { kernel, from, change: less(to, from) };
    let mut part = 1.0;
    for _ in 0..CORNERS {
        let changes = (0..K::KINKS.len()).filter_map(|number| Some((number, way.change_of::<T, M>(number)?)));
        let changes: Vec<_> = changes.collect();
        let kinks = changes.iter().filter_map(|&(number, at)| way.kink::<T, M>(number, at));
        if let Some(kink) = kinks.min_by(|a, b| a.share.total_cmp(&b.share)) {
            return Some(Kink { share: part * kink.share, ..kink });
        }
        // No normal jumps where these arguments change their signs: near a corner it may where others do, and do so
        // once more behind it.
        let before = changes.iter().map(|(_, [before, _])| *before).min_by(f64::total_cmp)?;
        way.change = way.change.map(|half| scaled(before, &half));
        part *= before;
    }
    None
}

/// So many edges that meet in a corner are told apart.
const CORNERS: u32 = 4;

/// A gap of less than so many roundings is none.
const ROUNDINGS: f64 = 64.0;

/// A straight way between two places.
struct Way<'a, K, const D: usize, const H: usize> {
    kernel: &'a K,
    from: &'a Place<f64, D, H>,
    change: Place<f64, D, H>,
}

/// g, |∇g|, and ∇g/|∇g|.
type Side<const D: usize, const H: usize> = (f64, f64, Place<f64, D, H>);

/// g as a length, by the normal there, or where there is none by that of a place farther off.
fn as_length<const D: usize, const H: usize>(here: &Side<D, H>, farther: &Side<D, H>) -> f64 {
    here.0 / if here.1.is_normal() { here.1 } else { farther.1 }
}

impl<K, const D: usize, const H: usize> Way<'_, K, D, H> {
    fn at<T: Scalar>(&self, share: f64) -> Place<T, D, H> {
        from_fn(|h| add_scaled(&self.from[h], share, &self.change[h]).map(T::from_f64))
    }

    /// The sign of an argument, −1, 0 or 1.
    fn sign<T: Scalar, const M: usize>(&self, number: usize, share: f64) -> i8
    where
        K: Kinked<T, D, H, M>,
    {
        let mut found = [T::from_f64(0.0)];
        self.kernel.kinks(&self.at(share), number, &mut found);
        let argument = found[0].to_f64();
        i8::from(argument > 0.0) - i8::from(argument < 0.0)
    }

    fn side<T: Scalar, const M: usize>(&self, share: f64) -> [Side<D, H>; M]
    where
        K: Kinked<T, D, H, M>,
    {
        let (g, gradients) = self.kernel.slopes(&self.at(share));
        from_fn(|equation| {
            let gradient = gradients[equation].map(|half| half.map(T::to_f64));
            let length = length(&gradient);
            (g[equation].to_f64(), length, gradient.map(|half| half.map(|x| x / length)))
        })
    }

    /// Before and after where this argument changes its sign. A place where it is zero is on either side, so behind it
    /// a place is taken that is not.
    fn change_of<T: Scalar, const M: usize>(&self, number: usize) -> Option<[f64; 2]>
    where
        K: Kinked<T, D, H, M>,
    {
        let before = self.sign::<T, M>(number, 0.0);
        if self.sign::<T, M>(number, 1.0) == before {
            return None;
        }
        Some(self.nearer::<T, M>(number, [0.0, 1.0], HALVINGS))
    }

    /// Nearer to that place, by so many halvings.
    fn nearer<T: Scalar, const M: usize>(
        &self,
        number: usize,
        [mut a, mut b]: [f64; 2],
        halvings: u32,
    ) -> [f64; 2]
    where
        K: Kinked<T, D, H, M>,
    {
        let before = self.sign::<T, M>(number, a);
        for _ in 0..halvings {
            let middle = 0.5 * (a + b);
            *(if self.sign::<T, M>(number, middle) == before { &mut a } else { &mut b }) = middle;
        }
        let behind = (b + (b - a)).min(1.0);
        let on_it = self.sign::<T, M>(number, b) == 0 && self.sign::<T, M>(number, behind) != before;
        [a, if on_it { behind } else { b }]
    }

    /// The kink where this argument changes its sign, if a normal jumps there; where it jumps by little, from nearby
    /// too.
    fn kink<T: Scalar, const M: usize>(&self, number: usize, at: [f64; 2]) -> Option<Kink>
    where
        K: Kinked<T, D, H, M>,
    {
        let kink = self.jump::<T, M>(number, at)?;
        if kink.angle > SHARP {
            return Some(kink);
        }
        self.jump::<T, M>(number, self.nearer::<T, M>(number, at, FURTHER))
    }

    /// The kink between these two places, if a normal jumps there.
    fn jump<T: Scalar, const M: usize>(&self, number: usize, [a, b]: [f64; 2]) -> Option<Kink>
    where
        K: Kinked<T, D, H, M>,
    {
        let [start, last, first, end] = [0.0, a, b, 1.0].map(|share| self.side::<T, M>(share));
        let way = length(&self.change);
        let size = self.from.iter().map(largest).fold(way, f64::max);
        (0..M).find_map(|equation| {
            let [start, last, first, end] = [&start, &last, &first, &end].map(|side| &side[equation]);
            let turn = distance(&start.2, &last.2) + distance(&first.2, &end.2);
            // Where a quotient overflows there is no normal to compare, and the surface alone tells.
            let none = turn.is_nan();
            let smooth = if none { LARGEST } else { turn * turn };
            let smooth = smooth.clamp(SMALLEST.max(ROUNDINGS * T::EPSILON), LARGEST);
            // The rounding of g, as where the way begins, on the surface.
            let rounding = ROUNDINGS * (T::EPSILON * size + as_length(start, end).abs());
            let jump = if none { 0.0 } else { distance(&last.2, &first.2) };
            let gap = (as_length(last, start) - as_length(first, end)).abs();
            let jumps = jump > smooth || gap > smooth * way + rounding;
            jumps.then(|| Kink {
                argument: K::KINKS[number],
                equation,
                share: b,
                place: self.at::<f64>(b)[0].to_vec(),
                angle: 2.0 * (0.5 * jump).min(1.0).asin(),
                gap,
            })
        })
    }
}

fn less<const D: usize, const H: usize>(a: &Place<f64, D, H>, b: &Place<f64, D, H>) -> Place<f64, D, H> {
    from_fn(|h| add_scaled(&a[h], -1.0, &b[h]))
}

fn length<const D: usize, const H: usize>(of: &Place<f64, D, H>) -> f64 {
    of.iter().map(|half| dot(half, half)).sum::<f64>().sqrt()
}

fn distance<const D: usize, const H: usize>(a: &Place<f64, D, H>, b: &Place<f64, D, H>) -> f64 {
    length(&less(a, b))
}
