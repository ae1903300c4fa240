//! Habits of other languages.
use rattle::prelude::*;

constraint! {
    pub struct Python { r }
    |x, y| x**2 + y**2 - r**2
}
constraint! {
    pub struct Paper { r }
    |x, y| 2x + 3.5y = r
}
constraint! {
    pub struct Rust { r }
    |x, y| f64::sin(x) + y - r
}
constraint! {
    pub struct Typed { r }
    |x, y| x + 2.0f64 * y == r
}
constraint! {
    pub struct Compared { r }
    |x, y| (x < y) + r
}
constraint! {
    pub struct Chained { r }
    |x, y| if 0 < x < y { x } else { y - r }
}
constraint! {
    pub struct NoElse { r }
    |x, y| y + if x < r { x }
}
constraint! {
    pub struct Field { r }
    |x, y| x.length + y - r
}
constraint! {
    pub struct Juxtaposed { r }
    |x, y| x y - r
}
constraint! {
    pub struct Bare { r }
    |x, y| sqrt x + sin 2 * y + exp (x) - cos abs y + r
}
constraint! {
    pub struct Remainder { r }
    |x, y| { let z = x % 2; z + y - r }
}
constraint! {
    pub struct Words { r }
    |x, y| { let z = r as f64; x + y + return z }
}
constraint! {
    pub struct Ends { r }
    |x, y| (x^) + (y - ) - r
}
constraint! {
    pub struct Backwards { r }
    |q: [f64; 3]| sum(i in 3..0, q[i]) + q[1.0] - r
}
constraint! {
    pub struct Far { r }
    |q: [f64; 3]| sum(i in 0..50, q[i] + sin(q[0], i)) - foo(r)
}
constraint! {
    pub struct Infinite { r }
    |x, y| 1e300 * 1e300 * x + 1e200^2 * y + 1e-400 - r
}
constraint! {
    pub struct Bases { r }
    |x, y| (-2)^x + 0^y - r
}
constraint! {
    pub struct Squared { r }
    |q: [f64; 2], sign| sin^2(q[0]) + r * sign^2
}
constraint! {
    pub struct Summed { r }
    |q: [f64; 2]| q.sum() - r
}
constraint! {
    pub struct Many { r }
    |x, y| min(x, y, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15) - r + norm()
}
constraint! {
    pub struct Unlike { r, n }
    |x, y| if x != y { x - r } else { y } + sum(i in 0..n, x * i)
}
hamiltonian! {
    pub struct Turned {}
    |p, q| p^2 / 2 + q
}
constraint! {
    pub struct Vanishing { r }
    |x, y| 10^-320 * x + 1e-200 * 1e-200 * y - r
}
constraint! {
    pub struct Place { r: [f64; 2] }
    |x, y| x + y - r.0
}
potential! {
    pub struct Unsaid { r }
    |x, y| { f = x; g = 2 * f; f + r * g + y }
}
constraint! {
    pub struct Crossed { r }
    |a: [f64; 3], b: [f64; 3]| norm(cross(a, b)) - r
}
potential! {
    pub struct Equation { a }
    |x, y| a * x = y
}

constraint! {
    pub struct Bars { r }
    |x, y| |x| + y - r
}
constraint! {
    pub struct Together { r }
    |m: [[f64; 2]; 2]| m[0, 1] + m[1][0] - r
}
constraint! {
    pub struct Point { r }
    |x, y| .5 * x + y - r
}
constraint! {
    pub struct SetTwice { r }
    |x, y| { let f = x; f += y; f - r }
}
constraint! {
    pub struct Lengths { r }
    |q: [f64; 2]| q[0] * q.len() - r
}
constraint! {
    pub struct Ternary { r }
    |x, y| x < y ? x - r : y
}
constraint! {
    pub struct Elif { r }
    |x, y| if x < r { x } elif y < r { y } else { x + y }
}
constraint! {
    pub struct And { r }
    |x, y| if x < r and y < r { x } else { y }
}
constraint! {
    pub struct Patterns { r }
    |(x, y)| x * y - r
}
constraint! {
    pub struct Root { r }
    |x, y| x^1/2 + y - r
}
constraint! {
    pub struct Minus { r }
    |x, y| x + sin -1 * y - r
}

fn main() {}
