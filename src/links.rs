//! Ready-made constraints on and between bodies: the joints of mechanisms.
//!
//! Each is a plain [`constraint!`](crate::constraint); its page shows the formula, the gradient and the number of
//! operations. To vary one, copy its line into a macro of your own. A scene takes a link with a list of the bodies that
//! each copy of it joins: `.link(Rod { length: 1.0 }, [[0, 1], [1, 2]])`.
//!
//! | bodies | which |
//! |---|---|
//! | one | [`Pendulum`], [`Slider`], [`RotationMatrix`]; every surface: `.link(Plane { … }, [[3]])` |
//! | two | [`Rod`], [`Coincident`] |
//! | three | [`Between`], [`Angle`] |
//! | four | [`Torsion`] |
//!
//! These links are for bodies in space; [`planar`] has those for bodies in the plane, with the same names where both
//! exist. [`surfaces`](crate::surfaces) are links of one body in space.
//!
//! The multiplier of a link is a force or a torque, times the factor that its page gives; it is positive where the link
//! pushes along the gradient of g. `simulation.constraint_forces()` returns forces on bodies, whatever the formula, but
//! for what constraints answer to flows (`force!`, drag, fields).
//!
//! ```
//! use rattle::links::Rod;
//! use rattle::potentials::Gravity;
//! use rattle::prelude::*;
//!
//! let pendulum = Scene::points(2).link(Rod { length: 2.0 }, [[0, 1]]).pin(0, [0.0; 3]).with(Gravity { g: 9.81 });
//! let mut simulation = pendulum.simulate(State::of([[0.0; 3], [0.0, 0.0, -2.0]]), Rattle::new(0.01))?;
//! simulation.run(10)?;
//! let tension = -2.0 * 2.0 * simulation.multipliers()[0]; // −2 λ length
//! assert!((tension - 9.81).abs() < 1e-12);
//! # Ok::<(), rattle::Error>(())
//! ```

pub mod planar;

use crate::ready_made::constraint;

constraint! {
    /// Two bodies at a distance.
    ///
    /// g has the unit of a squared length. A rod bears tension and compression: the tension is −2 λ `length`.
    ///
    /// ```
    /// use rattle::links::Rod;
    /// use rattle::prelude::*;
    ///
    /// let rod = Rod { length: 3.0 };
    /// assert_eq!(rod.value(&[0.0, 0.0, 0.0, 1.0, 2.0, 2.0].into())[0], 0.0);
    /// ```
    #[doc(alias = "joint")]
    #[doc(alias = "bond")]
    #[doc(alias = "pendulum")]
    pub struct Rod { length }
    |a: [f64; 3], b: [f64; 3]| sum(i in 0..3, (a[i] - b[i])^2) - length^2
}

constraint! {
    /// A body at a distance from a fixed point: a spherical pendulum.
    ///
    /// g has the unit of a squared length. The tension is −2 λ `length`.
    ///
    /// ```
    /// use rattle::links::Pendulum;
    /// use rattle::prelude::*;
    ///
    /// let scene = Scene::on(Pendulum { length: 1.0, pivot: [0.0, 0.0, 5.0] });
    /// let mut simulation = scene.simulate(State::at([1.0, 0.0, 5.0]).moving([0.0, 1.0, 0.0]), Rattle::new(0.01))?;
    /// simulation.run(100)?;
    /// assert!((-2.0 * simulation.multipliers()[0] - 1.0).abs() < 1e-12); // m v²/length
    /// # Ok::<(), rattle::Error>(())
    /// ```
    pub struct Pendulum { length, pivot: [f64; 3] }
    |q: [f64; 3]| sum(i in 0..3, (q[i] - pivot[i])^2) - length^2
}

constraint! {
    /// Two bodies at one place: a ball joint between the parts of a mechanism to which the bodies belong.
    ///
    /// Three equations, each a length. The multipliers are the force of `b` on `a`.
    ///
    /// ```
    /// use rattle::links::Coincident;
    /// use rattle::prelude::*;
    ///
    /// assert_eq!(Coincident {}.value(&[1.0, 2.0, 3.0, 1.0, 2.0, 2.5].into()).as_slice(), [0.0, 0.0, 0.5]);
    /// ```
    #[doc(alias = "joint")]
    #[doc(alias = "hinge")]
    pub struct Coincident {}
    |a: [f64; 3], b: [f64; 3]| for i in 0..3 { a[i] - b[i] }
}

constraint! {
    /// Body c on the line from body a to body b, at `fraction` of the way: a point of a rigid bar, with 1/2 its middle.
    ///
    /// Three equations, each a length. Fractions below 0 and above 1 lie on the extension of the bar.
    ///
    /// ```
    /// use rattle::links::Between;
    /// use rattle::prelude::*;
    ///
    /// let bar = [0.0, 0.0, 0.0, 4.0, 8.0, 0.0, 1.0, 2.0, 0.0]; // a, b, c
    /// assert_eq!(Between { fraction: 0.25 }.value(&bar.into()).as_slice(), [0.0; 3]);
    /// ```
    pub struct Between { fraction }
    |a: [f64; 3], b: [f64; 3], c: [f64; 3]| for i in 0..3 { c[i] - ((1 - fraction) * a[i] + fraction * b[i]) }
}

constraint! {
    /// The angle at body b between the directions to bodies a and c.
    ///
    /// `angle` and g are in radians, 0 < angle < π; the multiplier is the torque that opens the angle. An angle of 0 or
    /// π has no gradient: use [`Between`] or [`Rod`] for these.
    ///
    /// ```
    /// use rattle::links::Angle;
    /// use rattle::prelude::*;
    /// use std::f64::consts::FRAC_PI_2;
    ///
    /// let corner = [2.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 3.0, 3.0]; // a, b, c
    /// assert_eq!(Angle { angle: FRAC_PI_2 }.value(&corner.into())[0], 0.0);
    /// ```
    #[doc(alias = "bend")]
    #[doc(alias = "hinge")]
    pub struct Angle { angle }
    |a: [f64; 3], b: [f64; 3], c: [f64; 3]| {
        let u = a - b;
        let w = c - b;
        let normal = [u[1] * w[2] - u[2] * w[1], u[2] * w[0] - u[0] * w[2], u[0] * w[1] - u[1] * w[0]];
        atan2(norm(normal), dot(u, w)) - angle
    }
}

constraint! {
    /// The torsion (dihedral angle) of four bodies: the angle about the axis b–c by which the bond c–d is turned
    /// relative to a–b.
    ///
    /// `angle` is in radians, positive if, seen from b to c, the nearer bond must be turned clockwise to cover the
    /// farther one; zero where a and d lie on the same side (IUPAC 1974). g is the present torsion relative to `angle`,
    /// between −π and π; the multiplier is the torque about the axis. Bodies a, b, c or b, c, d on a straight line have
    /// no torsion.
    ///
    /// ```
    /// use rattle::links::Torsion;
    /// use rattle::prelude::*;
    /// use std::f64::consts::FRAC_PI_2;
    ///
    /// let bonds = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 1.0]; // a, b, c, d
    /// assert!(Torsion { angle: FRAC_PI_2 }.value(&bonds.into())[0].abs() < 1e-15);
    /// ```
    #[doc(alias = "dihedral")]
    pub struct Torsion { angle }
    |a: [f64; 3], b: [f64; 3], c: [f64; 3], d: [f64; 3]| {
        let u = b - a;
        let v = c - b;
        let w = d - c;
        let m = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
        let n = [v[1] * w[2] - v[2] * w[1], v[2] * w[0] - v[0] * w[2], v[0] * w[1] - v[1] * w[0]];
        let y = norm(v) * dot(u, n);
        let x = dot(m, n);
        atan2(cos(angle) * y - sin(angle) * x, cos(angle) * x + sin(angle) * y)
    }
}

constraint! {
    /// A body on a fixed straight line through `point` along `direction`: a bead on a wire, a slider in its guide.
    ///
    /// Two equations: the distances from the line along two normals of it, by the formula of Duff and others (2017).
    /// The direction may have any length but zero.
    ///
    /// ```
    /// use rattle::links::Slider;
    /// use rattle::potentials::Gravity;
    /// use rattle::prelude::*;
    ///
    /// let slope = Slider { point: [0.0; 3], direction: [4.0, 0.0, -3.0] };
    /// let mut simulation =
    ///     Scene::on(slope).with(Gravity { g: 1.0 }).simulate(State::at([0.0; 3]), Rattle::new(0.01))?;
    /// simulation.run(100)?;
    /// let q = simulation.position();
    /// assert!((q.norm() - 0.5 * 0.6).abs() < 1e-12 && (q.x / q.z + 4.0 / 3.0).abs() < 1e-12);
    /// # Ok::<(), rattle::Error>(())
    /// ```
    #[doc(alias = "joint")]
    #[doc(alias = "prismatic")]
    pub struct Slider { point: [f64; 3], direction: [f64; 3] }
    |q: [f64; 3]| {
        let n = direction / norm(direction);
        let s = if n[2] < 0 { -1 } else { 1 };
        let a = -1 / (s + n[2]);
        let b = a * n[0] * n[1];
        let first = [1 + s * a * n[0]^2, s * b, -s * n[0]];
        let second = [b, s + a * n[1]^2, -n[1]];
        [dot(first, q - point), dot(second, q - point)]
    }
}

constraint! {
    /// A rigid body by its rotation matrix, QᵀQ = 1: one body of nine coordinates, six equations.
    ///
    /// The coordinates are those of Q row by row; Q takes coordinates in the body's frame to those in space. g has no
    /// unit. A body that only turns about its centre of mass is faster as [`Scene::rigid`](crate::Scene::rigid).
    ///
    /// ```
    /// use rattle::links::RotationMatrix;
    /// use rattle::prelude::*;
    ///
    /// let quarter = [0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0];
    /// assert_eq!(RotationMatrix {}.value(&quarter.into()).as_slice(), [0.0; 6]);
    /// ```
    #[doc(alias = "rigid body")]
    #[doc(alias = "orthogonal")]
    pub struct RotationMatrix {}
    |q: [[f64; 3]; 3]| for i in 0..3, j in i..3 { sum(k in 0..3, q[k][i] * q[k][j]) - delta(i, j) }
}
