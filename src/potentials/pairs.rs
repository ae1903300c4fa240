//! Potentials between every two bodies, of their distance r.

use crate::ready_made::pair_potential;

pair_potential! {
    /// Coulomb's potential between like charges: repels for `strength` > 0, attracts for `strength` < 0.
    ///
    /// `strength` is an energy times a length, k q² for bodies of charge q. Bodies of different charges have
    /// [`charges`](crate::potentials::charges), bodies of different masses
    /// [`gravitation`](crate::potentials::gravitation).
    ///
    /// ```
    /// use rattle::potentials::Coulomb;
    /// use rattle::prelude::*;
    ///
    /// assert_eq!(Coulomb { strength: 3.0 }.value(2.0), 1.5);
    /// ```
    #[doc(alias = "electrostatic")]
    pub struct Coulomb { strength }
    |r| strength / r
}

pair_potential! {
    /// The Lennard-Jones potential (1931): repels at short distance, attracts beyond 2^(1/6) `sigma`.
    ///
    /// `sigma` is the distance of U = 0, and `epsilon` the depth of the well, an energy: U = −ε at r = 2^(1/6) σ, where
    /// the force is zero. There is no cut-off; `.within(radius)` adds one.
    ///
    /// ```
    /// use rattle::potentials::LennardJones;
    /// use rattle::prelude::*;
    ///
    /// let pair = LennardJones { epsilon: 3.0, sigma: 2.0 };
    /// let bottom = 2.0 * 2_f64.powf(1.0 / 6.0);
    /// assert!((pair.value(bottom) + 3.0).abs() < 1e-14);
    /// assert_eq!(pair.value(2.0), 0.0);
    /// ```
    #[doc(alias = "LJ")]
    #[doc(alias = "van der Waals")]
    pub struct LennardJones { epsilon, sigma }
    |r| 4 * epsilon * ((sigma / r)^12 - (sigma / r)^6)
}

pair_potential! {
    /// The repulsive part of the Lennard-Jones potential, of Weeks, Chandler and Andersen (1971).
    ///
    /// The Lennard-Jones potential up to its minimum at 2^(1/6) `sigma`, lifted by `epsilon`; zero beyond. With s =
    /// (σ/r)⁶ the sum 4ε (s² − s) + ε is ε (2s − 1)²: value and force vanish at the cut-off without cancellation.
    ///
    /// ```
    /// use rattle::potentials::{LennardJones, Wca};
    /// use rattle::prelude::*;
    ///
    /// let (core, whole) = (Wca { epsilon: 3.0, sigma: 2.0 }, LennardJones { epsilon: 3.0, sigma: 2.0 });
    /// assert!((core.value(2.1) - (whole.value(2.1) + 3.0)).abs() < 1e-14);
    /// assert_eq!(core.value(2.3), 0.0);
    /// ```
    pub struct Wca { epsilon, sigma }
    |r| {
        let s = (sigma / r)^6;
        if s > 1/2 { epsilon * (2 * s - 1)^2 } else { 0 }
    }
}

pair_potential! {
    /// Morse's potential of a chemical bond (1929): repels within `length`, attracts beyond, fades to zero far away.
    ///
    /// `depth` is an energy: U = −depth at r = `length`. `alpha` is one over a length: the stiffness at the bottom is 2
    /// depth α².
    ///
    /// ```
    /// use rattle::potentials::Morse;
    /// use rattle::prelude::*;
    ///
    /// let bond = Morse { depth: 4.0, alpha: 2.0, length: 1.5 };
    /// assert_eq!(bond.value(1.5), -4.0);
    /// assert_eq!(bond.slope_over_distance(1.5), 0.0);
    /// ```
    pub struct Morse { depth, alpha, length }
    |r| {
        let fade = exp(-alpha * (r - length));
        depth * (fade^2 - 2 * fade)
    }
}

pair_potential! {
    /// Yukawa's screened Coulomb potential (1935), with the screening length 1/`kappa`: repels for `strength` > 0,
    /// attracts for `strength` < 0.
    ///
    /// `strength` is an energy times a length.
    ///
    /// ```
    /// use rattle::potentials::Yukawa;
    /// use rattle::prelude::*;
    ///
    /// assert_eq!(Yukawa { strength: 3.0, kappa: 0.5 }.value(2.0), 1.5 * (-1_f64).exp());
    /// ```
    pub struct Yukawa { strength, kappa }
    |r| strength * exp(-kappa * r) / r
}

pair_potential! {
    /// Ricker's wavelet as a function of the distance: repels within `radius`, attracts beyond, fades to zero, and is
    /// finite everywhere.
    ///
    /// U = depth (w − 1) e^w, with w = 3/2 (1 − r²/radius²). `depth` is an energy: U = −depth at r = `radius`. At
    /// contact U = depth e^(3/2) / 2. U is even in r, so bodies may pass through each other.
    ///
    /// ```
    /// use rattle::potentials::Ricker;
    /// use rattle::prelude::*;
    ///
    /// let pair = Ricker { depth: 0.5, radius: 2.0 };
    /// assert_eq!(pair.value(2.0), -0.5);
    /// assert!(pair.slope_over_distance(1.0) < 0.0 && pair.slope_over_distance(3.0) > 0.0);
    /// ```
    pub struct Ricker { depth, radius }
    |r| {
        let w = 3/2 - 3/2 * (r / radius)^2;
        depth * (w * exp(w) - exp(w)) // its derivative has one term
    }
}

pair_potential! {
    /// A Gaussian core, of Stillinger (1976): repels for `height` > 0, attracts for `height` < 0, and is finite
    /// everywhere.
    ///
    /// `height` is an energy: U at contact. U = height/e at r = `width`, which is √2 times the standard deviation.
    ///
    /// ```
    /// use rattle::potentials::Gaussian;
    /// use rattle::prelude::*;
    ///
    /// let bump = Gaussian { height: 2.0, width: 0.5 };
    /// assert_eq!(bump.value(0.0), 2.0);
    /// assert_eq!(bump.value(0.5), 2.0 * (-1_f64).exp());
    /// ```
    pub struct Gaussian { height, width }
    |r| height * exp(-(r / width)^2)
}

pair_potential! {
    /// A spring between every two bodies. For chosen pairs use [`Spring`](crate::potentials::Spring).
    ///
    /// `stiffness` is a force over a length. Pushes within `length`, pulls beyond.
    ///
    /// ```
    /// use rattle::potentials::HarmonicPair;
    /// use rattle::prelude::*;
    ///
    /// assert_eq!(HarmonicPair { stiffness: 4.0, length: 1.0 }.value(1.5), 0.5);
    /// ```
    pub struct HarmonicPair { stiffness, length }
    |r| stiffness / 2 * (r - length)^2
}

pair_potential! {
    /// Spheres that touch at the distance `diameter` and resist like a spring where they overlap; zero beyond.
    ///
    /// `stiffness` is a force over a length. The force is continuous, its slope is not.
    ///
    /// ```
    /// use rattle::potentials::SoftSphere;
    /// use rattle::prelude::*;
    ///
    /// let grains = SoftSphere { stiffness: 4.0, diameter: 1.0 };
    /// assert_eq!((grains.value(0.5), grains.value(1.5)), (0.5, 0.0));
    /// ```
    pub struct SoftSphere { stiffness, diameter }
    |r| if r < diameter { stiffness / 2 * (diameter - r)^2 } else { 0 }
}
