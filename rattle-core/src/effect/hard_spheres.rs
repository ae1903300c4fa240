//! Balls that cannot overlap: contacts between every two bodies, by the distance of their centres.

use crate::effect::contact::{Contacts, Gradient, check_restitution};
use crate::error::Error;
use crate::number::vector::{add_scaled, dot, scaled};

/// All bodies as balls of one diameter d that collide: disks in the plane, beads on a surface. Distances are straight
/// lines through space.
///
/// ```text
/// gap = (|qᵢ − qⱼ|² − d²) / 2d        a length, near contact the distance of the surfaces
/// ```
///
/// ```
/// use rattle::{effect::HardSpheres, prelude::*};
///
/// let start = State::of([[0.0], [1.0], [2.0]]).with_momenta([[1.0], [0.0], [0.0]]);
/// let simulation = Scene::points(3).simulate(start, Rattle::new(0.1))?;
/// let mut cradle = simulation.collide(HardSpheres::new(0.5))?;
/// cradle.run(20)?;
/// assert_eq!(cradle.momenta().map(|p| p.x).collect::<Vec<_>>(), [0.0, 0.0, 1.0]);
/// assert_eq!(cradle.events(), 2);
/// # Ok::<(), rattle::Error>(())
/// ```
#[doc(alias = "contact")]
#[doc(alias = "collision")]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HardSpheres {
    diameter: f64,
    restitution: f64,
}

impl HardSpheres {
    /// Balls of this diameter, elastic.
    #[must_use]
    pub fn new(diameter: f64) -> Self {
        Self { diameter, restitution: 1.0 }
    }

    /// The same with this coefficient of restitution, 0 to 1.
    #[must_use]
    pub fn restitution(self, restitution: f64) -> Self {
        Self { restitution, ..self }
    }
}

/// A pair (i, j) of n bodies has the number i n + j.
impl<const D: usize> Contacts<D> for HardSpheres {
    fn name(&self) -> &'static str {
        "HardSpheres"
    }
    fn restitution(&self) -> f64 {
        self.restitution
    }
    fn parameters(&self) -> Vec<f64> {
        vec![self.diameter]
    }
    fn check(&self, _: usize) -> Result<(), Error> {
        let positive = self.diameter > 0.0 && self.diameter.is_finite();
        if positive { check_restitution(self.restitution) } else { Err(Error::Diameter(self.diameter)) }
    }

    /// By sweeping along the first coordinate: bodies in its order meet those that follow within reach.
    fn near(&self, q: &[[f64; D]], way: f64, order: &mut Vec<usize>, found: &mut Vec<usize>) {
        if order.len() != q.len() {
            order.clear();
            order.extend(0..q.len());
        }
        order.sort_unstable_by(|&a, &b| q[a][0].total_cmp(&q[b][0]).then(a.cmp(&b)));
        let reach = self.diameter + 2.0 * way;
        for (rank, &a) in order.iter().enumerate() {
            for &b in order[rank + 1..].iter().take_while(|&&b| q[b][0] - q[a][0] <= reach) {
                let apart = add_scaled(&q[a], -1.0, &q[b]);
                if dot(&apart, &apart) <= reach * reach {
                    found.push(a.min(b) * q.len() + a.max(b));
                }
            }
        }
        found.sort_unstable();
    }

    fn gap(&self, contact: usize, q: &[[f64; D]], gradient: &mut Gradient<D>) -> f64 {
        let (i, j) = (contact / q.len(), contact % q.len());
        let apart = add_scaled(&q[i], -1.0, &q[j]);
        gradient.push((i, scaled(1.0 / self.diameter, &apart)));
        gradient.push((j, scaled(-1.0 / self.diameter, &apart)));
        let distance = dot(&apart, &apart).sqrt();
        (distance - self.diameter) * (distance + self.diameter) / (2.0 * self.diameter)
    }
}
