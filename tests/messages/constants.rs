//! What is wrong with a number.
use rattle::prelude::*;

constraint! {
    pub struct Still { r }
    |_x| r^2 - 1
}
constraint! {
    pub struct Numbers {}
    |x, y| x / 0 + sqrt(-1) * y + (-2)^(1/2) + ln(0) + x / (2 - 2) + 0^-1
}
constraint! {
    pub struct Steep {}
    |x, y| x^5000 + y^1e9 + 1e999
}
potential! {
    pub struct Nothing { g }
    |x, y, z| g
}
constraint! {
    pub struct Text {}
    |x| x + "two" - 'c'
}
constraint! {
    pub struct Huge {}
    |x: [f64; 3], y: [f64; 10000000000000000000000000000000000000000000]| x[1e200] + x[0]^1e200 + x[1]^1111111111111111111111111111111111111111111111111111111111111111111111111 + sum(_i in 0..100000000000000000000000000000, x[2])
}
constraint! {
    pub struct Digits {}
    |x| x + 1111111111111111111111111111111111111111111111111e300
}

fn main() {}
