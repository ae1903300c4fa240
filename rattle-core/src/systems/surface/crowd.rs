//! Which bodies are near other sheets, and when that is checked again: see [`crate::solve::crowd`].

use crate::error::Error;
use crate::motion::record::{Reading, Record};
use crate::solve::crowd::{Asked, EVERY, EVERY_ALONE};

/// It is asked for steps so much longer than the longest one.
const LONGER: f64 = 1.25;

/// Which bodies of a simulation are to be moved one by one, since other sheets are near.
#[derive(Debug, Clone)]
pub(crate) struct Crowd {
    /// A bit for each body of a tile.
    tiles: Vec<u64>,
    drifts: u64,
    longest: f64,
    pub(crate) asked: Asked,
}

impl Crowd {
    /// Room for so many tiles, of which nothing is known.
    pub(super) fn of(tiles: usize) -> Self {
        Self { tiles: vec![0; tiles], drifts: 0, longest: 0.0, asked: Asked::default() }
    }

    /// Before a drift of length h: if it is time to ask, after how many steps of [`shares`], and for which length.
    pub(super) fn turn(&mut self, h: f64) -> Option<(u64, f64)> {
        let (now, longer) = (self.drifts, h.abs() > self.longest);
        self.drifts += 1;
        if longer {
            self.longest = LONGER * h.abs(); // steps may grow a little each time
        }
        let turn = if longer { 0 } else { now / EVERY_ALONE * EVERY };
        (longer || now % EVERY_ALONE == 0).then_some((turn, self.longest))
    }

    pub(super) fn record(&self, to: &mut Record) {
        to.counts("crowded tiles", self.tiles.iter().copied());
        to.counts("crowd", [self.drifts, self.asked.in_one()]);
        to.numbers("crowd looked at", &[2], [self.longest, self.asked.reach]);
    }

    pub(super) fn recalled(from: &mut Reading<'_>, tiles: usize) -> Result<Self, Error> {
        let found = from.counts("crowded tiles")?;
        let [drifts, asked] = from.counted("crowd")?;
        let [longest, reach] = from.array("crowd looked at")?;
        let mut crowd = Self { drifts, longest, asked: Asked::of(asked, reach), ..Self::of(tiles) };
        crowd.tiles.iter_mut().zip(found).for_each(|(tile, &bits)| *tile = bits);
        Ok(crowd)
    }

    /// Notes which bodies of a tile are in a crowd.
    pub(super) fn note(&mut self, tile: usize, bodies: u64) {
        self.tiles[tile] = bodies;
    }

    /// The bodies of a tile that are to be moved one by one.
    pub(super) fn of_tile(&self, tile: usize) -> u64 {
        self.tiles[tile]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// After how many steps of [`shares`](crate::solve::crowd::shares) each drift of this length asks, and for which.
    fn asked(lengths: impl IntoIterator<Item = f64>) -> Vec<Option<(u64, f64)>> {
        let mut crowd = Crowd::of(1);
        lengths.into_iter().map(|h| crowd.turn(h)).collect()
    }

    #[test]
    fn it_is_asked_at_first_and_after_16_drifts_again() {
        for (drift, asked) in asked([-1.0; 50]).into_iter().enumerate() {
            let expected = match drift {
                0 => Some((0, 1.25)),
                16 => Some((64, 1.25)),
                32 => Some((128, 1.25)),
                48 => Some((192, 1.25)),
                _ => None,
            };
            assert_eq!(asked, expected, "drift {drift}");
        }
    }

    #[test]
    fn it_is_asked_anew_where_steps_are_a_quarter_longer() {
        let expected = [Some((0, 1.25)), None, None, Some((0, 1.5625 * 1.25)), None];
        assert_eq!(asked([1.0, -1.25, 0.5, -1.5625, 1.5625]), expected);
    }
}
