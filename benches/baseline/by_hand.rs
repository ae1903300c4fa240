//! RATTLE on the lemniscate surface as one would write it by hand for one trajectory, in plain Rust: `scalar.c` again.

use crate::conversation::{H, Run, TOLERANCE, start};

/// Where the first guess of the multiplier comes from, and what the corrections are.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Kind {
    /// The last multiplier, then Newton's method.
    Previous,
    /// Extrapolated from the last three, then corrections with the slope of the first.
    QuadraticChord,
}

/// One trajectory: q, p, and the last three displacements per ∇g/2.
struct Body {
    q: [f64; 3],
    p: [f64; 3],
    s: [f64; 3],
}

/// Trajectories, moved one after the other.
pub(crate) struct ByHand {
    kind: Kind,
    bodies: Vec<Body>,
    evaluations: u64,
}

impl ByHand {
    /// So many trajectories in all directions.
    pub(crate) fn new(kind: Kind, n: usize) -> Self {
        let body = |i| {
            let (q, p) = start(i, n);
            Body { q, p, s: [-3.0 * H * H; 3] }
        };
        Self { kind, bodies: (0..n).map(body).collect(), evaluations: 0 }
    }
}

impl Run for ByHand {
    fn advance(&mut self, steps: u64) {
        for body in &mut self.bodies {
            self.evaluations += match self.kind {
                Kind::Previous => advance::<false>(body, steps),
                Kind::QuadraticChord => advance::<true>(body, steps),
            };
        }
    }

    fn body(&self, i: usize) -> ([f64; 3], [f64; 3]) {
        (self.bodies[i].q, self.bodies[i].p)
    }

    fn evaluations(&self) -> [u64; 2] {
        [self.evaluations; 2]
    }
}

/// g and m = ∇g/2.
#[inline(always)]
fn value_and_half_gradient([x, y, z]: [f64; 3]) -> (f64, [f64; 3]) {
    let (x2, y2) = (x * x, y * y);
    let t = x2 + y2;
    let f = t * t - (x2 - y2);
    let f4 = 4.0 * f;
    (f * f + (z * z - 1.0 / 36.0), [f4 * x * (t - 0.5), f4 * y * (t + 0.5), z])
}

fn advance<const CHORD: bool>(body: &mut Body, steps: u64) -> u64 {
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let along = |a: [f64; 3], s: f64, b: [f64; 3]| [a[0] - s * b[0], a[1] - s * b[1], a[2] - s * b[2]];
    let (mut q, mut p, [mut s, mut s1, mut s2]) = (body.q, body.p, body.s);
    let (_, mut n) = value_and_half_gradient(q);
    let mut evaluations = 0;
    for _ in 0..steps {
        let guess = if CHORD { 3.0 * (s - s1) + s2 } else { s };
        (s2, s1, s) = (s1, s, guess);
        let free = [q[0] + H * p[0], q[1] + H * p[1], q[2] + H * p[2] - 0.5 * H * H];
        q = along(free, s, n);
        let (mut g, mut m) = value_and_half_gradient(q);
        evaluations += 1;
        let chord = 0.5 / dot(m, n);
        let mut tries = 0;
        while g.abs().partial_cmp(&TOLERANCE).is_none_or(|order| order.is_gt()) && tries < 50 {
            s += g * if CHORD { chord } else { 0.5 / dot(m, n) };
            q = along(free, s, n);
            (g, m) = value_and_half_gradient(q);
            evaluations += 1;
            tries += 1;
        }
        p = along(p, s / H, n);
        p[2] -= H;
        p = along(p, dot(m, p) / dot(m, m), m);
        n = m;
    }
    (body.q, body.p, body.s) = (q, p, [s, s1, s2]);
    evaluations
}
