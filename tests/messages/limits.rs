//! What is too much.
use rattle::{nalgebra, prelude::*};

constraint! {
    pub struct Endless {}
    |x| sum(i in 0..100000, j in 0..100000, x * i * j)
}
constraint! {
    pub struct Idle {}
    |x| x + sum(i in 0..3000, j in 0..3000, 0 * i * j)
}
constraint! {
    pub struct Long { a }
    |x, y| sum(i in 1..3000, sin(i * x) * cos(i * y) / i) - a
}

fn main() {
    // The stub stands in.
    let _ = Long { a: 1.0 }.value(&nalgebra::vector![1.0, 2.0]);
}
