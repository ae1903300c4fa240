//! Lanes near other sheets of their surface.

use crate::number::instructions::Work;
use crate::number::lanes::Lane;
use crate::number::vector::dot;
use crate::number::vectors::{Vectors, at};
use crate::run::ensemble::block::{Block, Part};
use crate::run::ensemble::engine::Stuck;
use crate::run::ensemble::laws::Laws;
use crate::run::ensemble::row::LOOKING;
use crate::solve::crowd::{EVERY, FARTHER, is_alone, reach, rises, shares, shift};
use std::borrow::Borrow;

/// An error for the first of these lanes that has another sheet near, after so many steps: where g does not rise along
/// the normal, of this square, at some share of this factor of the normal to both sides; see [`crate::solve::crowd`].
#[inline(always)]
pub(super) fn look_around<S: Lane, const L: usize, const D: usize>(
    laws: &impl Laws<S, D>,
    steps: u64,
    lanes: &[bool; L],
    q: &Vectors<S, L, D>,
    normal: &Vectors<S, L, D>,
    square: &[S; L],
    furthest: &[S; L],
) -> Result<(), Stuck> {
    let mut least = *square;
    for share in shares(steps) {
        let share = S::from_f64(share);
        for i in 0..L {
            let shift = share * furthest[i];
            let rises = rises(laws.constraint(i).borrow(), &at(q, i), &at(normal, i), square[i], shift);
            least[i] = S::select(rises.le(least[i]), rises, least[i]);
        }
    }
    let crowded = (0..L).find(|&lane| lanes[lane] && !S::default().le(least[lane]));
    crowded.map_or(Ok(()), |lane| Err(Stuck { lane, failure: None }))
}

/// Looks around all lanes after so many steps, at these places, momenta, normals and accelerations, as far as steps
/// that do not follow their root may have led astray since it was looked in its [turn](EVERY).
#[inline(always)]
pub(super) fn look_as_far<S: Lane, const L: usize, const D: usize>(
    laws: &impl Laws<S, D>,
    steps: u64,
    [q, p, normal, pull]: [&Vectors<S, L, D>; 4],
    asked: &mut [S; L],
    astray: &mut [S; L],
) -> Result<(), Stuck> {
    let zero = S::default();
    let (mut square, mut furthest) = ([zero; L], [zero; L]);
    for l in 0..L {
        let far = reach(astray[l], asked[l]);
        if steps.is_multiple_of(EVERY) {
            (asked[l], astray[l]) = (far, zero);
        }
        let (n, p) = (at(normal, l), at(p, l));
        square[l] = dot(&n, &n);
        furthest[l] = shift(far, square[l], dot(&p, &p), dot(&n, &at(pull, l)));
    }
    look_around(laws, steps, &[true; L], q, normal, &square, &furthest)
}

/// Has lanes look around that have gone farther astray than was looked. Returns whether nothing speaks against the
/// step.
#[inline(always)]
pub(super) fn may_go<S: Lane, const L: usize>(asked: &[S; L], strays: &[S; L], going: &mut [S; L]) -> bool {
    let (zero, looking) = (S::default(), S::from_f64(LOOKING));
    let mut all = true;
    for l in 0..L {
        let look = zero.le(going[l]) & !strays[l].le(asked[l]);
        going[l] = S::select(look, looking, going[l]);
        all &= zero.le(going[l]);
    }
    all
}

/// Looks for other sheets where such a step leads a lane, to this place with momentum, normal and acceleration there,
/// if it has gone farther astray than it was looked before.
#[inline(always)]
pub(super) fn ask_around<S: Lane, const L: usize, const D: usize>(
    laws: &impl Laws<S, D>,
    lane: usize,
    end: [&Vectors<S, L, D>; 4],
    strays: S,
    asked: &mut S,
) -> Result<(), Stuck> {
    if strays.le(*asked) {
        return Ok(());
    }
    let [q, p, normal, pull] = end.map(|x| at(x, lane));
    let (reach, square) = (S::from_f64(FARTHER) * strays, dot(&normal, &normal));
    let furthest = shift(reach, square, dot(&p, &p), dot(&normal, &pull));
    *asked = reach;
    let alone = is_alone(laws.constraint(lane).borrow(), 0, [&q, &normal], square, furthest);
    if alone { Ok(()) } else { Err(Stuck { lane, failure: None }) }
}

/// Whether no other sheet is near the body of one of these lanes, after so many steps; see [`crate::solve::crowd`].
pub(super) struct LookingAround<
    'a,
    S,
    X,
    const L: usize,
    const D: usize,
    const SUMS: usize,
    const EQUAL: bool,
> {
    pub(super) block: &'a Block<S, L, D, SUMS, EQUAL>,
    pub(super) laws: &'a X,
    pub(super) parts: &'a [Part],
    pub(super) steps: u64,
    pub(super) lanes: &'a [bool; L],
    /// The momentum of a lane is taken to be no less. Not inlined: it must not compute by numbers that fuse.
    pub(super) least: &'a dyn Fn(usize) -> f64,
}

impl<S, X, const L: usize, const D: usize, const SUMS: usize, const EQUAL: bool> Work
    for LookingAround<'_, S, X, L, D, SUMS, EQUAL>
where
    S: Lane,
    X: Laws<S, D>,
{
    type Done = Result<(), Stuck>;

    #[inline(always)]
    fn run(self) -> Result<(), Stuck> {
        let Self { block, laws, parts, steps, lanes, least } = self;
        let (part, Block { q, way, normal, square, guess, past: [last, earlier], .. }) =
            (&parts[block.part], block);
        let mut furthest = [S::default(); L];
        for i in 0..L {
            let back = guess[i].abs().max(last[i].abs()).max(earlier[i].abs());
            let pushed = laws.kick(i, &at(q, i), part.push(), [S::default(); D]);
            furthest[i] = part.furthest(back, &at(way, i), &pushed, &at(normal, i), square[i], least(i));
        }
        look_around(laws, steps, lanes, q, normal, square, &furthest)
    }
}
