//! What is wrong with the struct.
use rattle::{nalgebra, prelude::*};

constraint! {
    #[derive(Default, PartialOrd)]
    pub struct Generic<'a, const N: usize, T: Copy> { r }
    |x, y| x^2 + y^2 - r^2
}
constraint! {
    pub struct Twice { x, x, r }
    |y, z, y| y + z - x - r
}
constraint! {
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct Single { r: f32, list: Vec<f64, f32>, n: [i32; 2], c: &'static [f64], last }
    |x, y: f32, z: Vec3| x - r + list[1] - n[0] + y + c + z[1] + last + oops
}
constraint! {
    pub struct Still { r, s }
    |x, y, z| r^2 - 1
}
constraint! {
    pub struct Unused { r }
    |x, y, z| { let f = x; [1, r, y] }
}
constraint! {
    pub struct Conditional { #[cfg(unix)] r, #[cfg_attr(unix, cfg(unix))] s }
    |x| x - r - s
}
constraint! {
    pub struct Given { r = 1, s: f64 = 2.0 }
    |x| x - r - s
}

fn main() {
    let _ = Single { r: 1.0, list: Default::default(), n: [1.0; 2], c: Default::default(), last: 1.0 } .clone();
    let _ = Twice { x: 1.0, r: 2.0 } == Twice { x: 1.0, r: 2.0 };
    let _ = Generic { r: 1.0 }.value(&nalgebra::vector![1.0, 2.0]);
}
