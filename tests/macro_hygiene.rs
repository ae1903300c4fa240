//! The macros among definitions that take every name they might lean on, and under every lint.

#![deny(unused_qualifications, deprecated, clippy::pedantic, clippy::nursery)]
#![forbid(missing_docs, unused_variables, unreachable_pub, non_upper_case_globals, unsafe_code)]

mod rattle {}

/// Each name of the prelude means something else here, and so do the primitive types.
#[no_implicit_prelude]
mod hostile {
    #![allow(dead_code, non_camel_case_types, unused_macros, clippy::wrong_self_convention)]

    mod core {}
    mod std {}
    mod alloc {}
    mod rattle {}
    mod kernel {}
    struct Option;
    struct Some;
    struct None;
    struct Result;
    struct Ok;
    struct Err;
    struct Vec;
    struct Box;
    struct String;
    struct PhantomData;
    struct T;
    struct U;
    struct f64;
    struct f32;
    struct usize;
    struct u32;
    struct bool;
    struct str;
    trait Default {}
    trait Clone {}
    trait Copy {}
    trait Debug {}
    trait PartialEq {}
    trait From {}
    trait Into {}
    trait Fn {}
    trait Sized {}
    trait Real {}
    trait Constraint {}
    trait Add {}
    const FIRST: u32 = u32;
    const SCALAR: bool = bool;

    /// Methods of every type, by the names that kernels call.
    trait Meddling: ::core::marker::Sized {
        fn sin(self) {}
        fn sqrt(self) {}
        fn sin_cos(self) {}
        fn multiply_add(self) {}
        fn select(self) {}
        fn lt(self) {}
        fn from_f64(self) {}
        fn from_lanes(self) {}
        fn take(self) {}
        fn add(self) {}
        fn mul(self) {}
        fn len(self) {}
        fn copy_from_slice(self) {}
    }
    impl<X> Meddling for X {}

    macro_rules! hostile {
        ($($name:ident)*) => { $(
            macro_rules! $name { () => { ::core::compile_error!("a macro of the user's") } }
        )* };
    }
    hostile! { assert debug_assert panic vec matches unreachable concat compile_error }

    ::rattle::constraint! {
        /// Named like what the generated code has inside.
        #[derive(::core::default::Default)]
        pub(super) struct Surface { h, t, q, self_, value, gradient, x0, r#type, n: [f64; 2] }
        |r#fn, y, __q, order| {
            let kernel = sin(r#fn) * cos(r#fn) + sqrt(h + y^2) * q + t;
            let r#let = if y < self_ { kernel * value } else { abs(__q) + gradient };
            r#let + x0 * __q^3 + r#type * order + n[0] * y + n[1] - sum(r#in in 0..3, max(y, order) * r#in)
        }
    }
    ::rattle::constraint! {
        pub(super) struct Circle { r }
        |x, y| x^2 + y^2 - r^2
    }
    ::rattle::potential! { pub(super) struct Gravity { g } |_x, y| g * y }
    ::rattle::pair_potential! { pub(super) struct Spring { k } |r| k * (r - 1)^2 }
    ::rattle::hamiltonian! { pub(super) struct Motion {} |q: [f64; 1], p: [f64; 1]| p[0]^2 / 2 + q[0]^2 }
    ::rattle::phase_constraint! { pub(super) struct Both {} |q: [f64; 1], p: [f64; 1]| q[0] * abs(p[0]) - 1 }
    ::rattle::force! {
        pub(super) struct Wind { drag }
        |q: [f64; 2], v: [f64; 2], t| [-drag * v[0] + 0 * t, -drag * v[1] + 0 * abs(q[0])]
    }
    ::rattle::potential! { pub(super) struct Tide { w } |_x, y, t| sin(w * t) * y }
    ::rattle::constraint! { pub(super) struct Long {} |x, y| sum(k in 1..300, sin(k * x) * cos(k * y) / k) }
}

/// What is left out of a program leaves nothing behind, mistakes included.
#[no_implicit_prelude]
mod conditional {
    ::rattle::constraint! {
        #[cfg(any())]
        pub(super) struct Absent { r, Unknown: ::nowhere::Type }
        |x| x - undefined
    }
    ::rattle::potential! {
        #[cfg(any())]
        pub(super) struct Absent { g: [f64; 2] }
        |x, y| g[0] * x + g[1] * y
    }
    ::rattle::potential! {
        #[cfg(all())]
        #[cfg(not(any()))]
        #[cfg_attr(all(), derive(::core::default::Default))]
        #[must_use]
        #[allow(unused_qualifications)]
        pub(super) struct Present {
            /// Its strength.
            #[doc(alias = "strength")]
            pub(super) g,
        }
        |x| g * x
    }
    ::rattle::potential! {
        #[cfg_attr(all(), cfg(any()))]
        pub(super) struct Present { g }
        |x, _y| g * x
    }
    ::rattle::potential! {
        #[deprecated]
        pub(super) struct Old { #[deprecated] g }
        |x| g * x
    }
}

#[allow(clippy::pedantic, clippy::nursery, reason = "what is tested is what the macros write")]
mod law {
    use super::hostile::{Both, Circle, Gravity, Long, Motion, Spring, Surface, Tide, Wind};
    use ::rattle::prelude::*;
    use nalgebra::{matrix, vector};

    #[test]
    fn values_and_gradients_are_those_of_the_formula() {
        let surface = Surface {
            h: 1.0,
            t: 0.5,
            q: 2.0,
            self_: 0.25,
            value: 3.0,
            gradient: 4.0,
            x0: 5.0,
            r#type: 6.0,
            n: [7.0, 8.0],
        };
        let [a, y, b, c] = [0.3, 0.5, -2.0, 0.75_f64];
        let at = vector![a, y, b, c];
        let by_hand = b.abs() + 4.0 + 5.0 * (b * b * b) + 6.0 * c + 7.0 * y + 8.0 - 3.0 * c;
        assert!((surface.value(&at)[0] - by_hand).abs() < 1e-13);
        assert_eq!(surface.jacobian(&at), matrix![0.0, 7.0, -1.0 + 15.0 * b * b, 3.0]);
        assert_eq!(Surface::default().n, [0.0, 0.0]);
        assert_eq!(PairPotential::value(&Spring { k: 2.0 }, 3.0), 8.0);
        assert_eq!(Motion {}.gradients(&vector![1.0], &vector![2.0]), (vector![2.0], vector![2.0]));
        assert_eq!(Both {}.value(&vector![0.5], &vector![2.0])[0], 0.0);
        assert!(Long {}.value(&vector![0.1, 0.2])[0].is_finite());
    }

    #[test]
    fn what_is_kept_acts_and_what_is_left_out_is_not_there() {
        let present = super::conditional::Present::default();
        assert_eq!(present.g, 0.0);
        assert_eq!(Potential::value(&present, &vector![3.0]), 0.0);
        #[allow(deprecated)]
        let old = super::conditional::Old { g: 2.0 };
        assert_eq!(Potential::value(&old, &vector![3.0]), 6.0);
    }

    #[test]
    fn a_bead_moves_on_the_circle() {
        let scene = Scene::on(Circle { r: 1.0 })
            .with(Gravity { g: 1.0 })
            .with(Tide { w: 0.0 })
            .with(Wind { drag: 0.1 });
        let start = State::at([1.0, 0.0]);
        let mut simulation = scene.simulate(start, Rattle::new(0.01)).expect("a bead at rest on the circle");
        simulation.run(100).expect("a pendulum swings");
        let [x, y] = simulation.position().into();
        assert!(y < -0.3 && (x * x + y * y - 1.0).abs() < 1e-15, "{x} {y}");
    }

    /// In a function, beside names of its own.
    #[test]
    fn local_structs() {
        const X: f64 = 1.0;
        let q = 2.0;
        mod rattle {}
        ::rattle::constraint! { struct Local { q } |x, y| x * q - y }
        ::rattle::constraint! { struct Other { q } |x, y| x * q + y }
        let found = [Local { q }.value(&vector![X, X])[0], Other { q }.value(&vector![X, X])[0]];
        assert_eq!(found, [1.0, 3.0]);
    }
}

/// Functions of a residual that nobody calls are no news, also where lints cannot be allowed; and a name that is not
/// written as a type's is complained of once.
mod strict {
    #![forbid(dead_code, clippy::all)]

    ::rattle_macros::residual! {
        struct Slope { epsilon }
        |h: [f64; 2], p: [f64; 2]| given |c: [f64; 2]| eliminate(p)
        { let size = sqrt(dot(p, p) + epsilon^2); [h - c, size * p - h] }
    }

    #[test]
    fn a_residual_is_used() {
        assert_eq!(Slope { epsilon: 1.0 }.epsilon.to_bits(), 1.0_f64.to_bits());
    }
}
