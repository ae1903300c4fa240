//! Shapes, indices, loops and branches.
use rattle::prelude::*;

constraint! {
    pub struct Index {}
    |a: [f64; 3], s, n| a[3] + a[s] + a[1.5] + s[0] + a[-1] + n * a[2]
}
constraint! {
    pub struct Shapes { c }
    |a: [f64; 3], b: [f64; 2], m: [[f64; 2]; 2]| [a + b, a * a, a^2 + c, sin(a), 1 / b, dot(a, b), m + b, -m * c, c + a]
}
potential! {
    pub struct Whole {}
    |a: [f64; 3]| 2 * a
}
potential! {
    pub struct Several {}
    |a: [f64; 3]| for i in 0..3 { a[i] }
}
constraint! {
    pub struct Loops {}
    |a: [f64; 3]| sum(k in 0..3, a[0]) + sum(3, a[1]) + product(i in 0..a[2], a[i]) + sum(i in 0..2, for j in 0..2 { a[j] })
}
constraint! {
    pub struct Nothing {}
    |a: [f64; 3]| [a[0] - 1, 2, [], a[1]]
}
constraint! {
    pub struct Branches { c }
    |a: [f64; 3], x| if x { a[0] } else if a < a { c } else { a }
}
pair_potential! {
    pub struct TwoDistances { k }
    |r, s| k * r * s
}
constraint! {
    pub struct Sides {}
    |x| delta(x, 1) * x + if x != 1 { x } else { 2 }
}
hamiltonian! {
    pub struct Uneven { g }
    |q: [f64; 2], p: [f64; 3]| dot(p, p) / 2 + g * q[1]
}
phase_constraint! {
    pub struct Alone {}
    |q: [f64; 2]| dot(q, q) - 1
}
hamiltonian! {
    pub struct Crowded {}
    |q, p, t| p^2 / 2 + q * t
}
hamiltonian! {
    pub struct Turns {}
    |x, px, y, py| (px^2 + py^2) / 2 + x * y
}
hamiltonian! {
    pub struct Unnamed {}
    |x, y, u, v| (u^2 + v^2) / 2 + x * y
}
hamiltonian! {
    pub struct Swapped {}
    |r, phi, pphi, pr| (pr^2 + (pphi / r)^2) / 2
}
hamiltonian! {
    pub struct Mixed {}
    |theta, ptheta, phi, pphi| (ptheta^2 + pphi^2) / 2 + theta * phi
}
hamiltonian! {
    pub struct Numbered {}
    |q2, q1, p1, p2| (p1^2 + p2^2) / 2 + q1 * q2^2
}
hamiltonian! {
    pub struct Doubled {}
    |s: [f64; 2], q, p, ps: [f64; 2]| (dot(ps, ps) + p^2) / 2 + q * s[0]
}
hamiltonian! {
    pub struct Reversed {}
    |ptheta, theta| ptheta^2 / 2 - cos(theta)
}
hamiltonian! {
    pub struct Backwards {}
    |p, phi| p^2 / 2 - cos(phi)
}
hamiltonian! {
    pub struct Halfless {}
    |z, px, py, pz| (px^2 + py^2 + pz^2) / 2 + z
}
phase_constraint! {
    pub struct Shaped {}
    |p: [f64; 2], q: [f64; 2]| dot(q, p)
}

fn main() {}
