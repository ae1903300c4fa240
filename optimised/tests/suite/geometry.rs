//! Thin, sharp, pinched, pointed and many-layered surfaces.

use crate::common::{billiard, distance};
use crate::suite::case::{Case, Kind, Measured};
use crate::suite::scenes::*;
use rand::{RngExt, SeedableRng, rngs::StdRng};
use rattle::Error;
use rattle::error::{StartFailure, StepFailure};
use rattle::nalgebra::Vector3;
use rattle::prelude::*;

constraint! {
    /// A sphere that touches z = 0 at the origin.
    #[derive(Clone, Copy, Debug)]
    struct Bowl { radius }
    |x, y, z| z - (x^2 + y^2 + z^2) / (2 * radius)
}

pub fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    let thin = Kind {
        why: "the radius of the tube drowns in the rounding of coordinates of size one",
        expect: "the distance from the core stays the radius",
        reason: "two coordinates near 1, each rounded by ε/2, and the root of their squares",
    };
    for r in [1e-1, 1e-2, 1e-4, 1e-6, 1e-8, 1e-10] {
        cases.push(
            thin.case(format!("torus by distances, tube of {r:e}"), 4.0 * E, move || thin_by_distance(r)),
        );
    }
    let polynomial = Kind {
        why: "g of degree four loses the tube to cancellation: its terms are of size one, its slope is r",
        expect: "the distance from the core stays the radius, as far as g can tell",
        reason: "g is rounded by a few ε and its slope is 8 r: ε/r, where a step may end 12 roundings off",
    };
    for r in [1e-1, 1e-2, 1e-3, 1e-4] {
        let bound = 8.0 * E / r;
        cases.push(
            polynomial
                .case(format!("torus as a polynomial, tube of {r:e}"), bound, move || thin_by_polynomial(r)),
        );
    }
    let forms = Kind {
        why: "a solver that looks at the size of g moves differently for another g of the same surface",
        expect: "both formulas of the torus give one motion",
        reason: "500 roundings of ε/r at random, 22, twice",
    };
    for (r, bound) in [(0.3, 120.0 * E), (0.01, 4000.0 * E)] {
        cases.push(forms.case(format!("torus, two formulas, tube of {r}"), bound, move || two_forms(r)));
    }
    let clairaut = Kind {
        why: "methods without symmetry lose the angular momentum about the axis",
        expect: "Clairaut's integral x p_y − y p_x stays over 10⁵ steps",
        reason: "compensated sums lose nothing: the products of the reading, and the solve, some ε each",
    };
    cases.push(clairaut.case("torus, Clairaut's integral", 16.0 * E, clairaut_integral));
    let tube = Kind {
        why: "g ~ r²: an absolute tolerance on g ends the solve at once, or never",
        expect: "|g|/r² stays at the rounding of g",
        reason: "coordinates of size one rounded by ε/2 on a surface of curvature 1/r: 20 ε/2r",
    };
    for r in [1e-2, 1e-4, 1e-6, 1e-8] {
        let start = move || at([1.0, 0.0, r], [0.7_f64.cos(), 0.7_f64.sin(), 0.0]);
        cases.push(tube.case(format!("lemniscate of tube {r:e}"), 10.0 * E / r, move || {
            let simulation = on(Lemniscate { a: 1.0, r }, 0.0, start(), Rattle::new(0.05 * r))?;
            largest(simulation, 20_000, |now| now.constraint_residual() / (r * r))
        }));
    }
    let neck = Kind {
        why: "just before two handles meet the normal nearly vanishes, and Newton's method leaps",
        expect: "the energy stays while the motion passes the neck",
        reason: "(h·κ·|v|)²/8, with steps that make h·κ·|v| 0.1 at the neck, 0.02 next to the pinch",
    };
    for k in [1e-2_f64, 1e-4, 1e-6, 1e-8] {
        cases.push(
            neck.case(format!("hyperboloid, neck of {:e}", k.sqrt()), 1.3e-3, move || through_a_neck(k)),
        );
    }
    for gap in [1e-3, 1e-6] {
        cases.push(neck.case(format!("lemniscate, {gap:e} from its pinch"), 5e-5, move || near_a_pinch(gap)));
    }
    let singular = Kind {
        why: "without a normal there is no constraint force: divisions by zero, or a leap to the other half",
        expect: "an error that says that the normal vanishes",
        reason: "every attempt is refused",
    };
    cases.push(singular.case("start at the pinch of the lemniscate", 0.0, || {
        let pinch = State::at([std::f64::consts::FRAC_1_SQRT_2, 0.0, 0.0]);
        Ok(unless(on(Lemniscate { a: 1.0, r: 0.25 }, 1.0, pinch, Rattle::new(1e-4)), no_normal))
    }));
    cases.push(singular.case("start at the apex of a cone", 0.0, || {
        Ok(unless(on(hyperboloid(0.0), 1.0, State::at([0.0; 3]), Rattle::new(1e-4)), no_normal))
    }));
    cases.push(singular.case("start where a horn torus meets its axis", 0.0, || {
        let horn = TorusByDistance { major: 1.0, minor: 1.0 };
        Ok(unless(on(horn, 1.0, State::at([0.0; 3]), Rattle::new(0.01)), no_normal))
    }));
    for h in [0.1, 0.01] {
        cases.push(singular.case(format!("straight to the apex of a cone, h = {h}"), 0.0, move || {
            let start = at([1.0, 0.0, 1.0], [-1.0, 0.0, -1.0]);
            let ended = onto(hyperboloid(0.0), 0.0, start, Taylor::new(8, h)).and_then(|now| ends(now, 1000));
            Ok(unless(ended, |error| {
                matches!(error, Error::Step { cause: StepFailure::NoNormal { .. }, .. })
            }))
        }));
    }
    let blurred = Kind {
        why: "rounding leaves the normal fewer than five digits, or a tube no thinner than what g can tell",
        expect: "an error, at the start or in a step: no motion that only looks right",
        reason: "each is refused",
    };
    cases.push(blurred.case("torus by distances, tube of 1e-12", 0.0, || {
        Ok(unless(thin_by_distance(1e-12), |error| matches!(error, Error::Start { .. })))
    }));
    cases.push(blurred.case("torus as a polynomial, tube of 1e-5", 0.0, || {
        Ok(unless(thin_by_polynomial(1e-5), |error| {
            matches!(error, Error::Start { .. } | Error::Step { .. })
        }))
    }));
    cases.push(blurred.case("sphere of radius 1, 1e12 from the origin", 0.0, || {
        let surface = Quadric { centre: [1e12, 0.0, 0.0], ..sphere(1.0) };
        Ok(unless(on(surface, 0.0, State::at([1e12 + 1.0, 0.0, 0.0]), Rattle::new(0.01)), no_normal))
    }));
    let bowed = Kind {
        why: "tolerances that grow with the radius of a surface take a start that lies beside a flat one",
        expect: "the start 0.001 off is refused, the one that is on the surface is not",
        reason: "each is",
    };
    for radius in [1e8, 1e12, 1e100] {
        cases.push(bowed.case(format!("start beside a bowl of radius {radius:e}"), 0.0, move || {
            let bowl = Bowl { radius };
            let (beside, link) = (State::at([1.0, 0.5, 1e-3]), Scene::points::<3>(1).link(bowl, [[0]]));
            Scene::on(bowl).simulate(Scene::on(bowl).project(&beside)?, Rattle::new(0.01))?;
            link.simulate(link.project(&beside)?, Rattle::new(0.01))?;
            Ok(unless(on(bowl, 0.0, beside.clone(), Rattle::new(0.01)), |error| {
                matches!(error, Error::Start { cause: StartFailure::OffSurface { .. }, .. })
            }) + unless(link.simulate(beside, Rattle::new(0.01)), |error| {
                matches!(error, Error::Start { cause: StartFailure::OffConstraint { .. }, .. })
            }))
        }));
    }
    let ridge = Kind {
        why: "stages on both sides of a ridge that is rounded to much less than a step know nothing of the force there",
        expect: "the energy of what goes on, over that before or the other way round; or an error",
        reason: "a step is refused where more than a fifth of the energy is amiss: a factor of 1.5, of at most two steps",
    };
    for s in [1e-2, 1e-3, 1e-5, 1e-7] {
        cases.push(
            ridge.case(format!("ridge of radius {s:e}, RATTLE"), 2.25, move || over(s, Rattle::new(0.03))),
        );
        cases.push(
            ridge.case(format!("ridge of radius {s:e}, DOP853"), 2.25, move || over(s, Dop853::new(0.03))),
        );
        cases.push(
            ridge.case(format!("ridge of radius {s:e}, Taylor"), 2.25, move || over(s, Taylor::new(8, 0.03))),
        );
        cases.push(
            ridge.case(format!("ridge of radius {s:e}, Lobatto"), 2.25, move || {
                over(s, Lobatto::<3>::new(0.03))
            }),
        );
    }
    let flat = Kind {
        why: "curvatures of 10⁶ one way and 1 the other make matrices and steps ill-conditioned",
        expect: "the circle at constant speed, at the angle that the method's own formula gives",
        reason: "1000 roundings of a step's angle of 0.1, twice",
    };
    for e in [1e-3, 1e-6, 1e3, 1e6] {
        let what = if e > 1.0 { "disk" } else { "needle" };
        cases.push(
            flat.case(format!("around a {what}, half axis {:e}", 1.0 / e), 200.0 * E, move || equator(e)),
        );
    }
    let planar = Kind {
        why: "the second fundamental form is zero there: a formula that divides by it has no multiplier",
        expect: "λ = 1/(2r) = 3, that of the weight alone",
        reason: "some roundings of 3",
    };
    cases.push(planar.case("start at a planar point", 1e-14, || {
        let simulation = on(SURFACE, 1.0, billiard(0.7), Rattle::new(0.01))?;
        Ok((simulation.multipliers()[0] - 3.0).abs())
    }));
    let plane = Kind {
        why: "the symmetry plane is a saddle: what rounding moves off it grows e-fold by e-fold",
        expect: "the coordinate across and its momentum stay zero",
        reason: "bit for bit: the formulas are even",
    };
    for (name, momentum, still) in [("long", [1.0, 0.0, 0.0], 1), ("short", [0.0, 1.0, 0.0], 0)] {
        cases.push(plane.case(format!("the {name} symmetry plane of genus two"), 0.0, move || {
            let simulation = on(SURFACE, 1.0, at([0.0, 0.0, SURFACE.r], momentum), Rattle::new(0.01))?;
            largest(simulation, 20_000, |now| place(now)[still].abs() + momentum_of(now, still))
        }));
    }
    let shells = Kind {
        why: "all equations hold on each sheet: nothing tells that a step ended on another",
        expect: "of 2000 random motions none leaves its shell; where it could, the step is refused",
        reason: "none",
    };
    for k in [3e2, 1e3, 1e4] {
        let case = shells.case(format!("shells π/{k:e} apart"), 0.0, move || Ok(leave_their_shell(k)));
        cases.push(Case { long: k > 3e2, ..case });
    }
    let edge = Kind {
        why: "the normal jumps at an edge: a step across gives energy, threefold speed was seen",
        expect: "the step across an edge is an error",
        reason: "each of 20 directions is refused",
    };
    cases.push(edge.case("edges of an octahedron", 0.0, across_edges));
    cases
}

fn momentum_of(now: &BoxedSimulation<3>, i: usize) -> f64 {
    momentum(now)[i].abs()
}

fn no_normal(error: &Error) -> bool {
    let Error::Start { cause, .. } = error else { return false };
    matches!(cause, StartFailure::SingularPoint { .. } | StartFailure::ConstraintNotFinite { .. })
}

/// Of the circle of radius 1 in the plane z = 0, less the radius of the tube.
fn off_tube(now: &BoxedSimulation<3>, r: f64) -> f64 {
    let q = place(now);
    ((q.x.hypot(q.y) - 1.0).hypot(q.z) - r).abs()
}

fn thin_by_distance(r: f64) -> Measured {
    let torus = TorusByDistance { major: 1.0, minor: r };
    let simulation = onto(torus, 0.0, at([1.0 + r, 0.0, 0.0], [0.0, 0.3, 0.4]), Rattle::new(0.05 * r))?;
    largest(simulation, 5000, |now| off_tube(now, r))
}

fn thin_by_polynomial(r: f64) -> Measured {
    let torus = Torus { major: 1.0, minor: r };
    let simulation = onto(torus, 0.0, at([1.0 + r, 0.0, 0.0], [0.0, 0.3, 0.4]), Rattle::new(0.05 * r))?;
    largest(simulation, 5000, |now| off_tube(now, r))
}

fn two_forms(r: f64) -> Measured {
    let start = || at([1.0 + r, 0.0, 0.0], [0.0, 0.6, 0.8]);
    let method = Rattle::new(0.03 * r);
    let one = place_after(onto(Torus { major: 1.0, minor: r }, 0.0, start(), method)?, 500)?;
    let other = place_after(onto(TorusByDistance { major: 1.0, minor: r }, 0.0, start(), method)?, 500)?;
    assert!((one - start().positions().next().unwrap()).norm() > r);
    Ok(distance(one, other))
}

fn clairaut_integral() -> Measured {
    let simulation =
        on(Torus { major: 1.0, minor: 0.3 }, 0.0, at([1.3, 0.0, 0.0], [0.0, 0.6, 0.8]), Rattle::new(0.01))?;
    largest(simulation, 100_000, |now| {
        let (q, p) = (place(now), momentum(now));
        (q.x * p.y - q.y * p.x - 1.3 * 0.6).abs()
    })
}

/// From above down a meridian, through the neck of radius √k, and on.
fn through_a_neck(k: f64) -> Measured {
    let (neck, z) = (k.sqrt(), 20.0 * k.sqrt());
    let start = at([(k + z * z).sqrt(), 0.0, z], [-1.0, 0.0, -1.0]);
    let simulation = onto(hyperboloid(k), 0.0, start, Rattle::new(0.1 * neck / 2.0_f64.sqrt()))?;
    let mut after = simulation.clone();
    after.run(1000)?;
    assert!(place(&after).z < 0.0, "through the neck");
    relative_energy(simulation, 1000)
}

fn near_a_pinch(gap: f64) -> Measured {
    let x = std::f64::consts::FRAC_1_SQRT_2;
    let start = at([x + gap, 0.0, gap], [0.0, 1.0, 0.0]);
    let simulation = onto(Lemniscate { a: 1.0, r: 0.25 }, 0.0, start, Rattle::new(0.02 * gap))?;
    relative_energy(simulation, 2000)
}

/// The circle of radius 1 about the z axis, on the ellipsoid x² + y² + (e z)² = 1.
fn equator(e: f64) -> Measured {
    let surface = Quadric { c: 1.0, centre: [0.0; 3], axes: [1.0, 1.0, e * e], k: 1.0 };
    let simulation = on(surface, 0.0, at([1.0, 0.0, 0.0], [0.0, 1.0, 0.0]), Rattle::new(0.1))?;
    largest(simulation, 1000, |now| {
        let (sin, cos) = (now.steps() as f64 * 0.1_f64.asin()).sin_cos();
        distance(place(now), [cos, sin, 0.0])
    })
}

constraint! {
    /// Spheres, of radii 1 + πj/k.
    struct Shells { k }
    |x, y, z| sin(k * (sqrt(x^2 + y^2 + z^2) - 1))
}

fn leave_their_shell(k: f64) -> f64 {
    let mut random = StdRng::seed_from_u64(1);
    let mut wrong = 0;
    let mut steps = 0;
    for _ in 0..2000 {
        let h = 10_f64.powf(random.random_range(-1.7..-0.4));
        let mut vector = || Vector3::from_fn(|_, _| random.random_range(-1.0..1.0));
        let q = vector().normalize();
        let p = vector().cross(&q);
        let mut simulation = on(Shells { k }, 1.0, State::at(q).moving(p), Rattle::new(h)).unwrap();
        while simulation.steps() < 60 && simulation.step().is_ok() {}
        steps += simulation.steps();
        wrong += u32::from((place(&simulation).norm() - 1.0).abs() > 1e-9);
    }
    assert!(steps > 10_000, "most move: {steps} steps");
    f64::from(wrong)
}

constraint! {
    /// The octahedron.
    struct Octahedron { r }
    |x, y, z| abs(x) + abs(y) + abs(z) - r
}

fn across_edges() -> Measured {
    let mut crossed = 0.0;
    for i in 0..20 {
        let (sin, cos) = (0.1 + 0.3 * f64::from(i)).sin_cos();
        let start = at([0.4, 0.3, 0.3], [cos, sin, -cos - sin]);
        let ended =
            onto(Octahedron { r: 1.0 }, 0.0, start, Rattle::new(0.013)).and_then(|now| ends(now, 1000));
        crossed +=
            unless(ended, |error| matches!(error, Error::Step { cause: StepFailure::Kink { .. }, .. }));
    }
    Ok(crossed)
}

/// By what factor the energy changes, one way or the other, of 40 bodies thrown over a ridge; 1 of those that are
/// stopped.
fn over<S: Method + 'static>(s: f64, method: S) -> Measured {
    let mut draw = StdRng::seed_from_u64(5);
    let mut worst = 1.0_f64;
    for _ in 0..40 {
        let (x, v) = (draw.random_range(-0.3..-0.2), draw.random_range(0.5..1.5));
        let mut run =
            onto(Ridge { s }, 0.0, at([x, 0.0, x], [v, draw.random_range(-0.5..0.5), v]), method.clone())?;
        let before = run.energy();
        if run.run(20).is_ok() {
            worst = worst.max(run.energy() / before).max(before / run.energy());
        }
    }
    Ok(worst)
}
