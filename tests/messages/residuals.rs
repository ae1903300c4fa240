//! Elements of meshes: every mistake by itself, though the kernels are used.
use rattle_macros::{constraint, residual};

residual! {
    pub struct Other { epsilon }
    |h: [f64; 2], p|
    given |c: [f64; 2]|
    eliminate(q)
    [h - c, p * epsilon]
}
residual! {
    pub struct Halves { epsilon }
    |h: [f64; 2], p|
    given |c: [f64; 2]|
    eliminate(p)
    { let s = p * epsilon; [h - c, s] linearise [s] }
}
residual! {
    pub struct Bars { epsilon }
    |h: [f64; 2], p|
    given c
    eliminate(p)
    [h - c, p * epsilon]
}
residual! {
    pub struct Part { epsilon }
    |h, p: [f64; 2]|
    given |c|
    eliminate(p[0])
    [h - c, p * epsilon]
}
residual! {
    pub struct Unread { epsilon }
    |h: [f64; 2], p|
    given |c: [f64; 2]|
    eliminate(p)
    { let s = p ** 2; [h - c, s * epsilon] linearize [h - c, s + k] }
}
residual! {
    pub struct Swapped { epsilon }
    |h, p|
    eliminate(p)
    [p - epsilon * h, h - 1]
}

residual! {
    pub struct Nothing {}
    |h: [f64; 3]|
    { let n = 1; for i in 1..n { h[i] - h[i - 1] } }
}
constraint! {
    pub struct NoRounds {}
    |x, _y| { let n = 1; for i in 1..n { x * i - _y } }
}
constraint! {
    pub struct Empty {}
    |x, y| { let a = []; x * y + dot(a, a) }
}

fn main() {
    let (u, c) = ([1.0, 2.0, 3.0], [4.0, 5.0]);
    let other = Other { epsilon: 1.0 }.kernel::<f64>();
    let ([_, _, _], [_, _, _]): ([f64; 3], [[f64; 3]; 3]) = other.residual_and_jacobian(&u, &c);
    let halves: HalvesKernel<f64> = Halves { epsilon: 1.0 }.kernel();
    let step: [f64; 1] = halves.recovered(&u, &c, &[0.0; Halves::KEPT]);
    let _ = (step, halves.condensed(&u, &c).1[1][1], halves.condensed_residual(&u, &c)[1]);
    let bars: [f64; 3] = Bars { epsilon: 1.0 }.kernel().residual(&u, &c);
    let part: [f64; 3] = Part { epsilon: 1.0 }.kernel().residual(&u, &[bars[0]]);
    let unread: [f64; 3] = Unread { epsilon: 1.0 }.kernel().residual(&u, &[part[0]; Unread::GIVEN]);
    let swapped: [f64; 1] = Swapped { epsilon: 1.0 }.kernel().condensed_residual(&[unread[0], 1.0], &[]);
    assert!(swapped[0] > 0.0);
}
