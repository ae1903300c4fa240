//! Ready-made surfaces g(x, y, z) = 0: those of the MANIFOLD package of LAMMPS and of HOOMD-blue, and classical ones.
//!
//! Each is a plain [`constraint!`](crate::constraint); its page shows a picture with geodesics, the formula, the
//! gradient and the number of operations. To vary one, copy its line into a macro of your own.
//!
//! ```
//! use rattle::prelude::*;
//! use rattle::surfaces::Torus;
//!
//! let torus = Torus { major: 1.5, minor: 0.5 };
//! assert_eq!(torus.value(&[2.0, 0.0, 0.0].into())[0], 0.0);
//! ```

use crate::ready_made::constraint;

constraint! {
    /// A sphere (HOOMD-blue; LAMMPS `sphere`).
    ///
    #[doc = include_str!("surfaces/sphere.html")]
    pub struct Sphere { r }
    |x, y, z| x^2 + y^2 + z^2 - r^2
}
constraint! {
    /// An ellipsoid (HOOMD-blue; LAMMPS `ellipsoid`).
    ///
    #[doc = include_str!("surfaces/ellipsoid.html")]
    pub struct Ellipsoid { a, b, c }
    |x, y, z| (x / a)^2 + (y / b)^2 + (z / c)^2 - 1
}
constraint! {
    /// A cylinder along z (HOOMD-blue; LAMMPS `cylinder`).
    ///
    #[doc = include_str!("surfaces/cylinder.html")]
    pub struct Cylinder { r }
    |x, y, _z| x^2 + y^2 - r^2
}
constraint! {
    /// A cylinder with a dent of length 2l and depth a (LAMMPS `cylinder_dent`, whose program takes half of that
    /// length: its l is 2l here).
    ///
    #[doc = include_str!("surfaces/dented_cylinder.html")]
    pub struct DentedCylinder { r, l, a }
    |x, y, z| {
        let radius = if abs(z) > l { r } else { r - a * (1 + cos(pi * z / l)) / 2 };
        x^2 + y^2 - radius^2
    }
}
constraint! {
    /// The plane a x + b y + c z = d (HOOMD-blue; LAMMPS `plane`).
    ///
    #[doc = include_str!("surfaces/plane.html")]
    pub struct Plane { a, b, c, d }
    |x, y, z| a * x + b * y + c * z - d
}
constraint! {
    /// A plane with waves along x (LAMMPS `plane_wiggle`).
    ///
    #[doc = include_str!("surfaces/wiggly_plane.html")]
    pub struct WigglyPlane { a, w }
    |x, _y, z| z - a * sin(w * x)
}
constraint! {
    /// A plane with a Gaussian bump, brought to zero between two radii, inner < outer, by a cubic in the distance, as
    /// the manual of LAMMPS has it (`gaussian_bump`; its program draws another curve unless outer − inner is 1).
    ///
    #[doc = include_str!("surfaces/gaussian_bump.html")]
    pub struct GaussianBump { a, l, inner, outer }
    |x, y, z| {
        let rho = norm(x, y);
        let edge = a * exp(-inner^2 / (2 * l^2));
        let slope = -edge * inner / l^2;
        let w = outer - inner;
        let t = (rho - inner) / w;
        let cubic = edge * (1 + 2 * t) * (1 - t)^2 + slope * w * t * (1 - t)^2;
        let height = if rho < inner { a * exp(-(x^2 + y^2) / (2 * l^2)) } else if rho < outer { cubic } else { 0 };
        z - height
    }
}
constraint! {
    /// A dumbbell (LAMMPS `dumbbell`, with k for A).
    ///
    #[doc = include_str!("surfaces/dumbbell.html")]
    pub struct Dumbbell { a, k, b, c }
    |x, y, z| -(x^2 + y^2) + (a^2 - z^2 / c^2) * (1 + (k * sin(b * z^2))^4)
}
constraint! {
    /// A dendritic spine (LAMMPS `spine`).
    ///
    #[doc = include_str!("surfaces/spine.html")]
    pub struct Spine { a, k, b, b2, c }
    |x, y, z| {
        let f = if z > 0 { c } else { 1 };
        let g = if z > 0 { b } else { b2 };
        -(x^2 + y^2) + (a^2 - z^2 / f^2) * (1 + (k * sin(g * z^2))^4)
    }
}
constraint! {
    /// A dendritic spine with a softer neck (LAMMPS `spine_two`).
    ///
    #[doc = include_str!("surfaces/spine_two.html")]
    pub struct SpineTwo { a, k, b, b2, c }
    |x, y, z| {
        let f = if z > 0 { c } else { 1 };
        let g = if z > 0 { b } else { b2 };
        -(x^2 + y^2) + (a^2 - z^2 / f^2) * (1 + (k * sin(g * z^2))^2)
    }
}
constraint! {
    /// Two stacks of a thylakoid joined by a bridge along x (LAMMPS `thylakoid`, with width, length and
    /// flare for wB, LB and lB).
    ///
    /// The bridge is a cylinder; quarters of a torus flare it into the stacks. A stack is a rounded square in x and y,
    /// and infinite along z. As in LAMMPS, its flat sides are 15 wide, its edges have radius 3, and width + 2 flare
    /// must not exceed 15. The surface is that of LAMMPS, but g differs: here g is the distance in every part, so that
    /// ∇g is continuous where parts meet. In LAMMPS g is a squared distance at the edges, and ∇g jumps.
    ///
    #[doc = include_str!("surfaces/thylakoid.html")]
    pub struct Thylakoid { width, length, flare }
    |x, y, z| {
        let side = 15;
        let edge = 3;
        let u = abs(x);
        let rho = norm(y, z);
        let face = length / 2 + flare;
        let across = abs(u - (face + edge + side / 2)) - side / 2;
        let along = abs(y) - side / 2;
        let stack = if across > 0 && along > 0 { norm(across, along) - edge } else { max(across, along) - edge };
        let mouth = flare - norm(u - length / 2, rho - width / 2 - flare);
        let lumen = max(mouth, u - (face + 2 * edge + side), along - edge);
        if u < length / 2 { min(rho - width / 2, stack) } else if rho < width / 2 + flare { lumen } else { stack }
    }
}
constraint! {
    /// |x|^q + |y|^q + |z|^q = r^q (LAMMPS `supersphere`).
    ///
    #[doc = include_str!("surfaces/supersphere.html")]
    pub struct Supersphere { r, q }
    |x, y, z| abs(x)^q + abs(y)^q + abs(z)^q - r^q
}
constraint! {
    /// A superquadric with exponents n around z and m towards the poles.
    ///
    #[doc = include_str!("surfaces/superellipsoid.html")]
    pub struct Superellipsoid { a, b, c, n, m }
    |x, y, z| (abs(x / a)^n + abs(y / b)^n)^(m / n) + abs(z / c)^m - 1
}
constraint! {
    /// A torus by the distance from its circle (LAMMPS `torus`); g is not smooth on the axis.
    ///
    #[doc = include_str!("surfaces/torus_by_distance.html")]
    pub struct TorusByDistance { major, minor }
    |x, y, z| (norm(x, y) - major)^2 + z^2 - minor^2
}
constraint! {
    /// A torus as a polynomial of degree four, smooth everywhere.
    ///
    #[doc = include_str!("surfaces/torus.html")]
    pub struct Torus { major, minor }
    |x, y, z| (x^2 + y^2 + z^2 + major^2 - minor^2)^2 - 4 * major^2 * (x^2 + y^2)
}
constraint! {
    /// Schoen's gyroid (HOOMD-blue).
    ///
    #[doc = include_str!("surfaces/gyroid.html")]
    pub struct Gyroid { k, epsilon }
    |x, y, z| sin(k * x) * cos(k * y) + sin(k * y) * cos(k * z) + sin(k * z) * cos(k * x) - epsilon
}
constraint! {
    /// Schwarz' primitive surface (HOOMD-blue).
    ///
    #[doc = include_str!("surfaces/primitive.html")]
    pub struct Primitive { k, epsilon }
    |x, y, z| cos(k * x) + cos(k * y) + cos(k * z) - epsilon
}
constraint! {
    /// Schwarz' diamond surface (HOOMD-blue).
    ///
    #[doc = include_str!("surfaces/diamond.html")]
    pub struct Diamond { k, epsilon }
    |x, y, z| cos(k * x) * cos(k * y) * cos(k * z) - sin(k * x) * sin(k * y) * sin(k * z) - epsilon
}
constraint! {
    /// Neovius' surface.
    ///
    #[doc = include_str!("surfaces/neovius.html")]
    pub struct Neovius { k }
    |x, y, z| 3 * (cos(k * x) + cos(k * y) + cos(k * z)) + 4 * cos(k * x) * cos(k * y) * cos(k * z)
}
constraint! {
    /// Schoen's I-WP surface.
    ///
    #[doc = include_str!("surfaces/i_wrapped_package.html")]
    pub struct IWrappedPackage { k }
    |x, y, z| {
        let a = cos(k * x);
        let b = cos(k * y);
        let c = cos(k * z);
        2 * (a * b + b * c + c * a) - (cos(2 * k * x) + cos(2 * k * y) + cos(2 * k * z))
    }
}
constraint! {
    /// Lidin's surface; epsilon = 0.3 is the usual one.
    ///
    #[doc = include_str!("surfaces/lidinoid.html")]
    pub struct Lidinoid { k, epsilon }
    |x, y, z| {
        let a = 2 * k * x;
        let b = 2 * k * y;
        let c = 2 * k * z;
        sin(a) * cos(k * y) * sin(k * z) + sin(b) * cos(k * z) * sin(k * x) + sin(c) * cos(k * x) * sin(k * y) - cos(a) * cos(b) - cos(b) * cos(c) - cos(c) * cos(a) + epsilon
    }
}
constraint! {
    /// The Bernoulli lemniscate, inflated: genus two for r < a⁴/4.
    ///
    #[doc = include_str!("surfaces/lemniscate.html")]
    pub struct Lemniscate { a, r }
    |x, y, z| {
        let f = (x^2 + y^2)^2 - a^2 * (x^2 - y^2);
        f^2 + z^2 - r^2
    }
}
constraint! {
    /// A lemniscate of three foci, inflated: of Klein's type, genus three.
    ///
    #[doc = include_str!("surfaces/three_foci.html")]
    pub struct ThreeFoci { a, c, r }
    |x, y, z| {
        let p = (x^2 + y^2)^3 - 2 * a^3 * (x^3 - 3 * x * y^2) + a^6;
        (p - c)^2 + z^2 - r^2
    }
}
constraint! {
    /// Clebsch's diagonal cubic: 27 real lines.
    ///
    #[doc = include_str!("surfaces/clebsch.html")]
    pub struct Clebsch {}
    |x, y, z| 81 * (x^3 + y^3 + z^3) - 189 * (x^2 * (y + z) + y^2 * (x + z) + z^2 * (x + y)) + 54 * x * y * z + 126 * (x * y + x * z + y * z) - 9 * (x^2 + y^2 + z^2) - 9 * (x + y + z) + 1
}
constraint! {
    /// Cayley's cubic: four nodes.
    ///
    #[doc = include_str!("surfaces/cayley.html")]
    pub struct Cayley {}
    |x, y, z| 4 * (x^2 + y^2 + z^2) + 16 * x * y * z - 1
}
constraint! {
    /// Barth's sextic: 65 nodes, 15 of them at infinity.
    ///
    #[doc = include_str!("surfaces/barth_sextic.html")]
    pub struct BarthSextic { w }
    |x, y, z| {
        let phi = (1 + sqrt(5)) / 2;
        let a = (phi * x)^2 - y^2;
        let b = (phi * y)^2 - z^2;
        let c = (phi * z)^2 - x^2;
        4 * a * b * c - (1 + 2 * phi) * w^2 * (x^2 + y^2 + z^2 - w^2)^2
    }
}
constraint! {
    /// Kummer's quartic: for μ² > 1 it has sixteen real nodes, at μ² = 1 it is Steiner's Roman surface, and for μ² < 1
    /// four of its nodes are real. At μ² = 3, where it would be four planes, the formula has no value.
    ///
    #[doc = include_str!("surfaces/kummer.html")]
    pub struct Kummer { mu }
    |x, y, z| {
        let lambda = (3 * mu^2 - 1) / (3 - mu^2);
        let s = sqrt(2);
        (x^2 + y^2 + z^2 - mu^2)^2 - lambda * (1 - z - s * x) * (1 - z + s * x) * (1 + z + s * y) * (1 + z - s * y)
    }
}
constraint! {
    /// Goursat's tangle cube.
    ///
    #[doc = include_str!("surfaces/tanglecube.html")]
    pub struct Tanglecube { c }
    |x, y, z| x^4 - 5 * x^2 + y^4 - 5 * y^2 + z^4 - 5 * z^2 + c
}
constraint! {
    /// Chmutov's quartic of Chebyshev polynomials.
    ///
    #[doc = include_str!("surfaces/chmutov.html")]
    pub struct Chmutov {}
    |x, y, z| 8 * (x^4 + y^4 + z^4) - 8 * (x^2 + y^2 + z^2) + 3
}
constraint! {
    /// Six rings, two around each axis of a cube: genus thirteen for c near 1 and small b.
    ///
    #[doc = include_str!("surfaces/decocube.html")]
    pub struct Decocube { b, c }
    |x, y, z| ((x^2 + y^2 - c^2)^2 + (z^2 - 1)^2) * ((y^2 + z^2 - c^2)^2 + (x^2 - 1)^2) * ((z^2 + x^2 - c^2)^2 + (y^2 - 1)^2) - b
}
constraint! {
    /// Taubin's heart.
    ///
    #[doc = include_str!("surfaces/heart.html")]
    pub struct Heart {}
    |x, y, z| (x^2 + 9/4 * y^2 + z^2 - 1)^3 - x^2 * z^3 - 9/80 * y^2 * z^3
}
constraint! {
    /// Dupin's cyclide, for a ≥ |b|.
    ///
    #[doc = include_str!("surfaces/dupin_cyclide.html")]
    pub struct DupinCyclide { a, b, d }
    |x, y, z| {
        let c2 = a^2 - b^2;
        (x^2 + y^2 + z^2 + b^2 - d^2)^2 - 4 * (a * x - sqrt(c2) * d)^2 - 4 * b^2 * y^2
    }
}
constraint! {
    /// Two metaballs at ±c on the x axis.
    ///
    #[doc = include_str!("surfaces/metaballs.html")]
    pub struct Metaballs { c, level }
    |x, y, z| 1 / ((x - c)^2 + y^2 + z^2) + 1 / ((x + c)^2 + y^2 + z^2) - level
}
constraint! {
    /// A hyperboloid of one sheet.
    ///
    #[doc = include_str!("surfaces/hyperboloid.html")]
    pub struct Hyperboloid { a, c }
    |x, y, z| (x / a)^2 + (y / a)^2 - (z / c)^2 - 1
}
constraint! {
    /// An elliptic paraboloid.
    ///
    #[doc = include_str!("surfaces/paraboloid.html")]
    pub struct Paraboloid { a, b }
    |x, y, z| (x / a)^2 + (y / b)^2 - z
}
constraint! {
    /// A hyperbolic paraboloid.
    ///
    #[doc = include_str!("surfaces/saddle.html")]
    pub struct Saddle { a, b }
    |x, y, z| (x / a)^2 - (y / b)^2 - z
}
constraint! {
    /// The monkey saddle.
    ///
    #[doc = include_str!("surfaces/monkey_saddle.html")]
    pub struct MonkeySaddle {}
    |x, y, z| x^3 - 3 * x * y^2 - z
}
constraint! {
    /// The catenoid, a minimal surface.
    ///
    #[doc = include_str!("surfaces/catenoid.html")]
    pub struct Catenoid { a }
    |x, y, z| x^2 + y^2 - a^2 * cosh(z / a)^2
}
constraint! {
    /// The helicoid, a minimal surface.
    ///
    #[doc = include_str!("surfaces/helicoid.html")]
    pub struct Helicoid { c }
    |x, y, z| x * sin(z / c) - y * cos(z / c)
}
constraint! {
    /// Scherk's first surface, minimal and doubly periodic.
    ///
    #[doc = include_str!("surfaces/scherk.html")]
    pub struct Scherk {}
    |x, y, z| exp(z) * cos(y) - cos(x)
}
