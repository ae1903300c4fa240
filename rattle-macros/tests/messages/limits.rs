//! What is too much.
use rattle::prelude::*;

constraint! {
    pub struct Endless {}
    |x| sum(i in 0..100000, j in 0..100000, x * i * j)
}

fn main() {}
