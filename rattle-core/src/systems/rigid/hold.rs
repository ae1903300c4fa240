//! Rigid bodies as the constraints of a scene.

use crate::effect::list::Effects;
use crate::error::{Error, NetworkMistake, StartFailure};
use crate::motion::bodies::{Body, Count};
use crate::motion::hold::{Hold, Kind};
use crate::motion::start::{START_TOLERANCE, finite};
use crate::motion::state::State;
use crate::systems::rigid::body::{Rigid, spread, turning_part};
use crate::systems::rigid::kept::Turning;
use nalgebra::{Matrix3, Vector3};

/// Matrices that lengthen one direction by less than this part of another have no rotation that is clearly the nearest.
const SINGULAR: f64 = 1e-3;

impl Hold<9> for Rigid {
    type System<E: Effects<9>, N: Count> = Turning<E::Forces<f64>, N>;

    const KIND: Kind = Kind::Rigid;

    fn system<E: Effects<9>, N: Count>(
        &self,
        effects: &E,
        count: N,
        start: &State<9>,
        _: f64,
        _: bool,
    ) -> Result<Self::System<E, N>, Error> {
        // Also sums and inverses are numbers.
        let fine = |moment: &f64| *moment > 0.0 && moment.is_finite() && (1.0 / moment).is_finite();
        let least = -4.0 * f64::EPSILON * self.inertia.amax();
        let triangle = self.column_masses().iter().all(|d| *d >= least && d.is_finite());
        if !(self.inertia.iter().all(fine) && triangle) {
            return Err(Error::Network(NetworkMistake::Inertia { moments: self.inertia.into() }));
        }
        for (body, state) in start.bodies.iter().enumerate() {
            check(state).map_err(|cause| Error::Start { body, cause })?;
        }
        Ok(Turning { body: *self, moments: self.moments(), effects: effects.forces(), count })
    }

    fn pull(&self, q: &[f64; 9], force: &[f64; 9]) -> [f64; 9] {
        spread(&turning_part(&Self::attitude(q), &Self::attitude(force)))
    }

    fn project(&self, state: &State<9>) -> Result<State<9>, Error> {
        let mut state = State { remembered: None, ..state.clone() };
        for (number, body) in state.bodies.iter_mut().enumerate() {
            let nowhere = |cause| Error::Start { body: number, cause };
            finite("position", &body.q).and_then(|()| finite("momentum", &body.p)).map_err(nowhere)?;
            turns_alone(&body.p).map_err(nowhere)?;
            let attitude = straightened(&Self::attitude(&body.q)).map_err(nowhere)?;
            body.q = Self::coordinates(&attitude);
            (body.q_low, body.p_low) = ([0.0; 9], [0.0; 9]);
        }
        Ok(state)
    }
}

/// The rotation that is nearest to a matrix, whatever the size of its entries.
fn straightened(matrix: &Matrix3<f64>) -> Result<Matrix3<f64>, StartFailure> {
    let largest = matrix.amax();
    let size = if largest > 0.0 { largest } else { 1.0 };
    let matrix = matrix / size; // squares of entries are numbers then
    let svd = matrix.svd(true, true);
    let [least, most] = [svd.singular_values.min(), svd.singular_values.max()];
    if let (Some(u), Some(v)) = (svd.u, svd.v_t)
        && least > SINGULAR * most
        && (u * v).determinant() > 0.0
    {
        return Ok(u * v);
    }
    let deviation = (svd.singular_values * size - Vector3::repeat(1.0)).amax();
    Err(StartFailure::NoAttitude { determinant: matrix.determinant() * size * size * size, deviation })
}

/// Whether momenta are an angular momentum and six zeros.
fn turns_alone(momenta: &[f64; 9]) -> Result<(), StartFailure> {
    if momenta[3..] == [0.0; 6] { Ok(()) } else { Err(StartFailure::NoAngularMomentum) }
}

fn check(state: &Body<f64, 9>) -> Result<(), StartFailure> {
    finite("position", &state.q)?;
    finite("momentum", &state.p)?;
    let attitude = Rigid::attitude(&state.q);
    let deviation = (attitude.transpose() * attitude - Matrix3::identity()).amax();
    let determinant = attitude.determinant();
    if deviation > START_TOLERANCE || determinant < 0.0 {
        return Err(StartFailure::NoAttitude { determinant, deviation });
    }
    turns_alone(&state.p)
}
