//! Links of bodies in the plane, and two that move.
//!
//! | bodies | which |
//! |---|---|
//! | one | [`Pendulum`], [`Slider`]; by `.link_moving`: [`Crank`], [`TurningLine`] |
//! | two | [`Rod`], [`Coincident`] |
//! | three | [`Between`], [`Collinear`], [`Angle`] |
//!
//! A slider-crank, driven: body 0 is the crank's end, body 1 the slider.
//!
//! ```
//! use rattle::links::planar::{Crank, Rod, Slider};
//! use rattle::prelude::*;
//!
//! let scene = Scene::points(2)
//!     .link_moving(Crank { centre: [0.0; 2], radius: 1.0, omega: 2.0, phase: 0.0 }, [[0]])
//!     .link(Rod { length: 3.0 }, [[0, 1]])
//!     .link(Slider { point: [0.0; 2], direction: [1.0, 0.0] }, [[1]]);
//! let start = scene.project(&State::of([[1.0, 0.0], [4.0, 0.0]]))?;
//! let mut simulation = scene.simulate(start, Rattle::new(0.01))?;
//! simulation.run(50)?;
//! let (sin, cos) = 1.0_f64.sin_cos();
//! let slider = simulation.positions().nth(1).unwrap();
//! assert!((slider.x - (cos + (9.0 - sin * sin).sqrt())).abs() < 1e-12);
//! # Ok::<(), rattle::Error>(())
//! ```

use crate::ready_made::constraint;

constraint! {
    /// Two bodies at a distance.
    ///
    /// g has the unit of a squared length. A rod bears tension and compression: the tension is −2 λ `length`.
    ///
    /// ```
    /// use rattle::links::planar::Rod;
    /// use rattle::prelude::*;
    ///
    /// assert_eq!(Rod { length: 5.0 }.value(&[0.0, 0.0, 3.0, 4.0].into())[0], 0.0);
    /// ```
    #[doc(alias = "joint")]
    #[doc(alias = "bond")]
    #[doc(alias = "pendulum")]
    pub struct Rod { length }
    |a: [f64; 2], b: [f64; 2]| sum(i in 0..2, (a[i] - b[i])^2) - length^2
}

constraint! {
    /// A body at a distance from a fixed point: a pendulum.
    ///
    /// g has the unit of a squared length. The tension is −2 λ `length`.
    ///
    /// ```
    /// use rattle::links::planar::Pendulum;
    /// use rattle::prelude::*;
    ///
    /// assert_eq!(Pendulum { length: 2.0, pivot: [0.0, 5.0] }.value(&[0.0, 3.0].into())[0], 0.0);
    /// ```
    pub struct Pendulum { length, pivot: [f64; 2] }
    |q: [f64; 2]| sum(i in 0..2, (q[i] - pivot[i])^2) - length^2
}

constraint! {
    /// Two bodies at one place: a hinge between the parts of a mechanism to which the bodies belong.
    ///
    /// Two equations, each a length. The multipliers are the force of `b` on `a`.
    ///
    /// ```
    /// use rattle::links::planar::Coincident;
    /// use rattle::prelude::*;
    ///
    /// assert_eq!(Coincident {}.value(&[1.0, 2.0, 1.0, 1.5].into()).as_slice(), [0.0, 0.5]);
    /// ```
    #[doc(alias = "joint")]
    #[doc(alias = "hinge")]
    pub struct Coincident {}
    |a: [f64; 2], b: [f64; 2]| for i in 0..2 { a[i] - b[i] }
}

constraint! {
    /// Body c on the line from body a to body b, at `fraction` of the way: a point of a rigid bar, with 1/2 its middle.
    ///
    /// Two equations, each a length. Fractions below 0 and above 1 lie on the extension of the bar.
    ///
    /// ```
    /// use rattle::links::planar::Between;
    /// use rattle::prelude::*;
    ///
    /// assert_eq!(Between { fraction: 0.25 }.value(&[0.0, 0.0, 4.0, 8.0, 1.0, 2.0].into()).as_slice(), [0.0; 2]);
    /// ```
    pub struct Between { fraction }
    |a: [f64; 2], b: [f64; 2], c: [f64; 2]| for i in 0..2 { c[i] - ((1 - fraction) * a[i] + fraction * b[i]) }
}

constraint! {
    /// Body c anywhere on the straight line through bodies a and b: a pin in the slot of a bar.
    ///
    /// g is the distance of c from the line, a length, positive to the left of the direction from a to b. The
    /// multiplier is the force of the slot on c. Bodies a and b must not meet.
    ///
    /// ```
    /// use rattle::links::planar::Collinear;
    /// use rattle::prelude::*;
    ///
    /// assert_eq!(Collinear {}.value(&[0.0, 0.0, 2.0, 0.0, 7.0, 3.0].into())[0], 3.0);
    /// ```
    #[doc(alias = "slot")]
    #[doc(alias = "pin")]
    pub struct Collinear {}
    |a: [f64; 2], b: [f64; 2], c: [f64; 2]| {
        let u = b - a;
        let w = c - a;
        (u[0] * w[1] - u[1] * w[0]) / norm(u)
    }
}

constraint! {
    /// The angle at body b from the direction to a, counterclockwise, to the direction to c.
    ///
    /// `angle` is in radians, of any size. g is the present angle relative to `angle`, between −π and π; the multiplier
    /// is the torque that opens the angle. Angles of 0 and π are allowed in the plane.
    ///
    /// ```
    /// use rattle::links::planar::Angle;
    /// use rattle::prelude::*;
    /// use std::f64::consts::{FRAC_PI_2, PI};
    ///
    /// let corner = [2.0, 0.0, 0.0, 0.0, 0.0, 3.0]; // a, b, c
    /// assert!(Angle { angle: FRAC_PI_2 }.value(&corner.into())[0].abs() < 1e-15);
    /// assert!((Angle { angle: PI }.value(&corner.into())[0] + FRAC_PI_2).abs() < 1e-15);
    /// ```
    pub struct Angle { angle }
    |a: [f64; 2], b: [f64; 2], c: [f64; 2]| {
        let u = a - b;
        let w = c - b;
        let y = u[0] * w[1] - u[1] * w[0];
        let x = dot(u, w);
        atan2(cos(angle) * y - sin(angle) * x, cos(angle) * x + sin(angle) * y)
    }
}

constraint! {
    /// A body on a fixed straight line through `point` along `direction`: a slider in its guide.
    ///
    /// g is the distance from the line, a length, positive to the left of the direction, which may have any length but
    /// zero. The multiplier is the force of the guide.
    ///
    /// ```
    /// use rattle::links::planar::Slider;
    /// use rattle::prelude::*;
    ///
    /// let guide = Slider { point: [0.0, 1.0], direction: [2.0, 0.0] };
    /// assert_eq!(guide.value(&[7.0, 4.0].into())[0], 3.0);
    /// ```
    #[doc(alias = "joint")]
    #[doc(alias = "prismatic")]
    pub struct Slider { point: [f64; 2], direction: [f64; 2] }
    |x, y| (direction[0] * (y - point[1]) - direction[1] * (x - point[0])) / norm(direction)
}

constraint! {
    /// A body carried around a circle at a constant rate: the end of a driven crank. A moving constraint:
    /// `.link_moving(Crank { … }, [[0]])`.
    ///
    /// Two equations, each a length. `omega` is the angular velocity in radians per time, counterclockwise; at t = 0
    /// the crank points at the angle `phase`, in radians.
    ///
    /// ```
    /// use rattle::links::planar::Crank;
    /// use rattle::prelude::*;
    ///
    /// let crank = Crank { centre: [1.0, 0.0], radius: 2.0, omega: 3.0, phase: 0.5 };
    /// let t = 0.1_f64;
    /// let angle = 3.0 * t + 0.5;
    /// assert!(crank.value(&[1.0 + 2.0 * angle.cos(), 2.0 * angle.sin(), t].into()).amax() < 1e-15);
    /// ```
    #[doc(alias = "motor")]
    pub struct Crank { centre: [f64; 2], radius, omega, phase }
    |x, y, t| {
        let angle = omega * t + phase;
        [x - (centre[0] + radius * cos(angle)), y - (centre[1] + radius * sin(angle))]
    }
}

constraint! {
    /// A body on a straight line through the origin that turns at a constant rate: a bead on a rotating rod. A moving
    /// constraint: `.link_moving(TurningLine { … }, [[0]])`.
    ///
    /// g is the distance from the line, a length. `omega` is the angular velocity in radians per time,
    /// counterclockwise; at t = 0 the line is the x axis.
    ///
    /// ```
    /// use rattle::links::planar::TurningLine;
    /// use rattle::prelude::*;
    ///
    /// let line = TurningLine { omega: 2.0 };
    /// let start = State::at([1.0, 0.0]).moving([0.0, 2.0]); // thrown out, as 1/2 (e^(2t) + e^(−2t))
    /// let mut simulation = Scene::point().link_moving(line, [[0]]).simulate(start, Rattle::new(0.001))?;
    /// simulation.run(500)?;
    /// assert!((simulation.position().norm() - 1_f64.cosh()).abs() < 1e-5);
    /// # Ok::<(), rattle::Error>(())
    /// ```
    pub struct TurningLine { omega }
    |x, y, t| y * cos(omega * t) - x * sin(omega * t)
}
