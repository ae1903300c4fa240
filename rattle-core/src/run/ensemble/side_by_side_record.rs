//! Checkpoints of trajectories in lanes.

use crate::error::{Error, RecordMistake};
use crate::motion::bodies::Body;
use crate::motion::record::{Hallmark, Reading, Record};
use crate::number::vectors::LANES;
use crate::run::ensemble::engine::Draws;
use crate::run::ensemble::side_by_side::{Ended, SideBySide};
use crate::run::fingerprint::{Looks, allowing, of_options};
use std::array::from_fn;

/// What a checkpoint calls such a group.
const IN_LANES: &str = "trajectories in lanes";

/// A body as vectors.
fn numbers<const D: usize>(body: &Body<f64, D>) -> [[f64; D]; 4] {
    [body.q, body.q_low, body.p, body.p_low]
}

/// And back, so many of each trajectory.
fn bodies<const D: usize>(numbers: &[[f64; D]], number: usize) -> Vec<Vec<Body<f64, D>>> {
    let body = |&[q, q_low, p, p_low]: &[[f64; D]; 4]| Body { q, q_low, p, p_low };
    numbers
        .chunks((4 * number).max(1))
        .map(|of_each| of_each.as_chunks().0.iter().map(body).collect())
        .collect()
}

impl<const D: usize> SideBySide<D> {
    /// Writes everything needed to continue.
    pub(super) fn write_record(&self, to: &mut Record) {
        let (times, lanes): (Vec<_>, _) =
            (self.start_time.iter().map(|&(t, low)| [t, low]).collect(), self.engine.width());
        to.text("what", IN_LANES);
        to.vectors("times of the starts", &times);
        to.counts("trajectories", self.draws.map(|of| of.trajectory));
        to.counts("numbered", self.draws.map(|of| u64::from(of.numbered)));
        to.counts("steps before the starts", self.draws.map(|of| of.steps));
        to.counts("steps", [self.steps]);
        to.counts("moving", self.moving.map(u64::from));
        to.counts("copy of", self.copy_of.map(|lane| lane as u64));
        to.counts("crowded", self.crowded.map(u64::from));
        to.counts("crowded until", [self.crowded_until]);
        to.counts("halvings", [u64::from(self.halvings)]);
        to.counts("by themselves", self.own.iter().map(|own| own.0 as u64));
        let own = self.own.iter().flat_map(|(_, bodies)| bodies).flat_map(numbers).collect::<Vec<_>>();
        to.vectors("where these are", &own);
        to.counts("ended", self.ended.iter().flat_map(|ended| [ended.lane as u64, ended.steps]));
        let ended = self.ended.iter().flat_map(|ended| &ended.bodies).flat_map(numbers).collect::<Vec<_>>();
        to.vectors("where these rest", &ended);
        if self.engine.work(0).is_some() {
            to.list("the work on these", &self.ended.iter().map(|ended| ended.work).collect::<Vec<_>>());
        }
        for ended in &self.ended {
            to.text("failure", &ended.failure.to_string());
        }
        to.within(&format!("{lanes} lanes"), |to| self.engine.record(to));
        to.within("run", |to| self.hallmarks(false).iter().for_each(|mark| mark.write(to)));
    }

    /// A copy of this group, at the states of a record.
    ///
    /// # Errors
    /// [`Error::Record`] for the record of another group.
    pub(super) fn read_record(&self, from: &mut Reading<'_>) -> Result<Self, Error> {
        from.expect(IN_LANES)?;
        let times = from.vectors::<2>("times of the starts", self.start_time.len())?;
        let trajectories = from.counted::<LANES>("trajectories")?;
        let numbered = from.counted::<LANES>("numbered")?;
        let before = from.counted::<LANES>("steps before the starts")?;
        let draws = from_fn(|lane| Draws {
            trajectory: trajectories[lane],
            numbered: numbered[lane] != 0,
            steps: before[lane],
            time: times.get(lane).or(times.first()).map_or((0.0, 0.0), |&[time, low]| (time, low)),
        });
        let [steps] = from.counted("steps")?;
        let moving = from.counted("moving")?.map(|moves| moves != 0);
        let lane = |lane: u64| (lane as usize).min(self.engine.width() - 1);
        let copy_of = from.counted("copy of")?.map(lane);
        let crowded = from.counted("crowded")?.map(|crowded| crowded != 0);
        let [crowded_until] = from.counted("crowded until")?;
        let [halvings] = from.counted("halvings")?;
        let option = |halvings: u64| if halvings == 0 { "none".into() } else { format!("retry({halvings})") };
        if halvings != u64::from(self.halvings) {
            let [file, here] = [halvings, self.halvings.into()].map(option);
            return Err(Error::Record(RecordMistake::Another { part: "options".into(), file, here }));
        }
        let apart = from.counts("by themselves")?;
        let n = self.engine.bodies_of_each();
        let places = from.vectors::<D>("where these are", 4 * n * apart.len())?;
        let own = apart.iter().zip(bodies(places, n)).map(|(&own, of)| (lane(own), of)).collect();
        let ends = from.counts("ended")?.as_chunks().0;
        let places = from.vectors::<D>("where these rest", 4 * n * ends.len())?;
        let works = if self.engine.work(0).is_some() {
            from.numbers("the work on these", &[ends.len()])?.to_vec()
        } else {
            vec![0.0; ends.len()]
        };
        let mut ended = Vec::new();
        for ((&[own, steps], bodies), work) in ends.iter().zip(bodies(places, n)).zip(works) {
            let failure = Error::Before(from.text("failure")?.into());
            ended.push(Ended { lane: lane(own), steps, bodies, work, failure });
        }
        let lanes = format!("{} lanes", self.engine.width());
        let at_first = self.at_first.as_ref().unwrap_or(&self.engine);
        let mut engine = from.within(&lanes, |from| at_first.recalled(from))?;
        for (lane, &draws) in draws.iter().enumerate().take(engine.width()) {
            engine.draw_as(lane, draws);
        }
        let at_first = (!ended.is_empty()).then(|| engine.clone());
        for (to, &from) in
            copy_of.iter().enumerate().take(self.engine.width()).filter(|&(to, &from)| to != from)
        {
            engine.obey(from, to);
        }
        let again = Self {
            engine,
            at_first,
            h: self.h,
            steps,
            start_time: times.iter().map(|&[time, low]| (time, low)).collect(),
            draws,
            moving,
            copy_of,
            ended,
            crowded,
            own,
            crowded_until,
            halvings: self.halvings,
            checked: self.checked,
        };
        let marks = allowing(again.hallmarks(false), &again.hallmarks(true));
        from.within("run", |from| from.same(&marks))?;
        Ok(again)
    }

    /// What tells this group from another, of the lanes that no other stands in for; asked where they are, or at
    /// places that are rounded otherwise.
    fn hallmarks(&self, rounded: bool) -> Vec<Hallmark> {
        let mut marks: Vec<Hallmark> = Vec::new();
        for lane in (0..self.engine.width()).filter(|&lane| self.moving[lane] && self.copy_of[lane] == lane) {
            let looks = Looks::in_lanes(self.bodies_in(lane));
            let own = self.engine.hallmarks(lane, &if rounded { looks.rounded() } else { looks });
            if marks.is_empty() {
                marks = own;
            } else {
                marks.iter_mut().zip(own).for_each(|(all, own)| all.extend(own));
            }
        }
        // First: what flows do, and where lanes are, is of its steps.
        marks.insert(0, self.engine.method());
        let checked = self.checked.map(|tolerance| ("check_reversal", tolerance));
        let options = of_options(checked.as_slice());
        marks.push(if checked.is_none() { options.later() } else { options });
        marks
    }
}
