//! Shapes besides bodies: rods, discs, walls, boxes that turn, axes, and charts beside the motion.

use super::error::PageError;
use super::mesh::{cross, dot};
use super::parts::{Disc, End, Moved, Strip};
use super::scene::{Scene3, TIMES};

impl Scene3 {
    /// Rods between bodies, or from bodies to fixed places.
    ///
    /// ```
    /// # use rattle::view::{Page, Scene3};
    /// let swing = [[[0.0, 0.0, -1.0], [0.6, 0.0, -0.8]], [[0.0, 0.0, -2.0], [1.2, 0.0, -1.6]]];
    /// let scene = Scene3::new("two").bodies(&[0.0, 1.0], &swing).rods([(0, 1)]).rods([(0, [0.0; 3])]);
    /// assert!(Page::new("Double pendulum").scene(scene).to_html().is_ok());
    /// ```
    pub fn rods<A: Into<End>, B: Into<End>>(mut self, ends: impl IntoIterator<Item = (A, B)>) -> Self {
        self.rods.extend(ends.into_iter().map(|(a, b)| [a.into(), b.into()]));
        self
    }

    /// Rods from each body of a row to the next.
    ///
    /// ```
    /// # use rattle::view::{Page, Scene3};
    /// let row: Vec<_> = (0..9).map(|i| [[f64::from(i), 0.0, 0.0]; 2]).collect();
    /// let scene = Scene3::new("chain").bodies(&[0.0, 1.0], &row).chain(0..9);
    /// assert!(Page::new("Chain").scene(scene).to_html().is_ok());
    /// ```
    pub fn chain(self, bodies: impl IntoIterator<Item = usize>) -> Self {
        let bodies: Vec<usize> = bodies.into_iter().collect();
        self.rods(bodies.windows(2).map(|pair| (pair[0], pair[1])))
    }

    /// A [chain](Scene3::chain) whose last body is joined to the first.
    ///
    /// ```
    /// # use rattle::view::{Page, PageError, Scene3};
    /// let row: Vec<_> = (0..9).map(|i| [[f64::from(i), 0.0, 0.0]; 2]).collect();
    /// let scene = Scene3::new("ring").bodies(&[0.0, 1.0], &row).ring(1..10);
    /// assert!(matches!(Page::new("").scene(scene).to_html(), Err(PageError::NoBody { body: 9, .. })));
    /// ```
    pub fn ring(self, bodies: impl IntoIterator<Item = usize>) -> Self {
        let bodies: Vec<usize> = bodies.into_iter().collect();
        let ends = bodies.last().copied().zip(bodies.first().copied());
        self.chain(bodies).rods(ends)
    }

    /// A flat disc about an axis, at a fixed place or carried by a body.
    ///
    /// ```
    /// # use rattle::view::{Page, Scene3};
    /// let scene = Scene3::new("wheel").bodies(&[0.0, 1.0], &[[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]]);
    /// let scene = scene.disc([0.0; 3], [0.0, 0.0, 1.0], 1.0);
    /// assert!(Page::new("Wheel").scene(scene).to_html().is_ok());
    /// ```
    pub fn disc(mut self, centre: impl Into<End>, axis: [f64; 3], radius: f64) -> Self {
        self.discs.push(Disc { centre: centre.into(), axis, radius });
        self
    }

    /// A wall, drawn as glass: a corner, and the two sides that begin there, as vectors.
    ///
    /// ```
    /// # use rattle::view::{Page, Scene3};
    /// let scene = Scene3::new("fall").bodies(&[0.0, 1.0], &[[[0.0, 0.0, 1.0], [0.0; 3]]]);
    /// let scene = scene.wall([-1.0, -1.0, 0.0], [[2.0, 0.0, 0.0], [0.0, 2.0, 0.0]]);
    /// assert!(Page::new("Floor").scene(scene).to_html().is_ok());
    /// ```
    pub fn wall(mut self, corner: [f64; 3], sides: [[f64; 3]; 2]) -> Self {
        self.walls.push([corner, sides[0], sides[1]]);
        self
    }

    /// A moving box, with its axes (red, green, blue). Given are the lengths of its sides, and, for each time or once,
    /// its centre and its attitude: three unit vectors in space, the columns of a rotation (nalgebra's `Matrix3`, or
    /// arrays).
    ///
    /// ```
    /// use rattle::nalgebra::{Rotation3, Vector3};
    /// # use rattle::view::{Page, Scene3};
    /// let times: Vec<f64> = (0..=20).map(|i| 0.1 * f64::from(i)).collect();
    /// let turns: Vec<_> = times.iter().map(|&t| Rotation3::new(Vector3::z() * t).into_inner()).collect();
    /// let scene = Scene3::new("top").times(&times).turning_box([0.2, 0.4, 0.6], &[[0.0; 3]], &turns);
    /// assert!(Page::new("Box").scene(scene).to_html().is_ok());
    /// ```
    pub fn turning_box<Q: Copy + Into<[f64; 3]>, A: Copy + Into<[[f64; 3]; 3]>>(
        mut self,
        sides: [f64; 3],
        centres: &[Q],
        axes: &[A],
    ) -> Self {
        let centres = centres.iter().map(|&centre| centre.into()).collect();
        self.boxes.push(Moved { sides, centres, axes: axes.iter().map(|&axes| axes.into()).collect() });
        self
    }

    /// Axes with numbers around the scene, and their labels.
    ///
    /// ```
    /// # use rattle::view::{Page, Scene3};
    /// let scene = Scene3::new("flight").bodies(&[0.0, 1.0], &[[[0.0; 3], [1.0; 3]]]).axes(["x / m", "y / m", "z / m"]);
    /// assert!(Page::new("Flight").scene(scene).to_html()?.contains("z / m"));
    /// # Ok::<(), rattle::view::PageError>(())
    /// ```
    pub fn axes(mut self, labels: [impl Into<String>; 3]) -> Self {
        self.axes = Some(labels.map(Into::into));
        self
    }

    /// A chart beside the motion that follows its time: curves with a number for each time.
    ///
    /// ```
    /// # use rattle::view::{Page, Scene3};
    /// let scene = Scene3::new("fall").bodies(&[0.0, 1.0], &[[[0.0, 0.0, 1.0], [0.0; 3]]]);
    /// let scene = scene.chart("Energy", [("kinetic", [0.0, 1.0]), ("potential", [1.0, 0.0])]);
    /// assert!(Page::new("Fall").scene(scene).to_html()?.contains("kinetic"));
    /// # Ok::<(), rattle::view::PageError>(())
    /// ```
    pub fn chart<L: Into<String>, V: AsRef<[f64]>>(
        mut self,
        title: impl Into<String>,
        curves: impl IntoIterator<Item = (L, V)>,
    ) -> Self {
        let curves = curves.into_iter().map(|(label, values)| (label.into(), values.as_ref().to_vec()));
        self.charts.push(Strip { title: title.into(), curves: curves.collect() });
        self
    }

    pub(super) fn check_shapes(&self) -> Result<(), PageError> {
        let bodies = self.positions.len();
        let end = |what: &'static str, end: &End| match end {
            End::Body(body) if *body >= bodies => {
                Err(PageError::NoBody { scene: self.title.clone(), what, body: *body, bodies })
            }
            End::Body(_) => Ok(()),
            End::Place(place) => self.numbers("coordinate", place, false),
        };
        self.rods.iter().flatten().try_for_each(|place| end("a rod", place))?;
        for Disc { centre, axis, radius } in &self.discs {
            end("a disc", centre)?;
            self.numbers("radius of a disc", [radius], true)?;
            self.numbers("length of a disc's axis", [&axis.iter().map(|x| x * x).sum::<f64>().sqrt()], true)?;
        }
        self.numbers("coordinate of a wall", self.walls.iter().flatten().flatten(), false)?;
        for (number, Moved { sides, centres, axes }) in self.boxes.iter().enumerate() {
            self.numbers("side of a box", sides, true)?;
            self.numbers("coordinate of a box", centres.iter().flatten(), false)?;
            for (what, found) in [("centres of a box", centres.len()), ("attitudes of a box", axes.len())] {
                let wanted = if found == 1 { 1 } else { self.times.len() };
                self.count(what, wanted, found, TIMES)?;
            }
            if let Some(frame) = axes.iter().position(|axes| !is_rotation(axes)) {
                return Err(PageError::Attitude { scene: self.title.clone(), number, frame });
            }
        }
        let late =
            self.surfaces.windows(2).find(|pair| !matches!(pair, [a, b] if a.0 < b.0 && b.0.is_finite()));
        let error = |value| PageError::Number {
            scene: self.title.clone(),
            what: "a surface that does not come after the one before, at time".into(),
            value,
        };
        late.map_or(Ok(()), |pair| Err(error(pair[1].0)))
    }
}

/// Whether the columns are orthonormal, as well as a picture needs it, and right-handed.
fn is_rotation(&[a, b, c]: &[[f64; 3]; 3]) -> bool {
    let near = |value: f64, wanted: f64| (value - wanted).abs() < 1e-3;
    let third = cross(a, b);
    near(dot(a, a), 1.0)
        && near(dot(b, b), 1.0)
        && near(dot(a, b), 0.0)
        && (0..3).all(|i| near(third[i], c[i]))
}
