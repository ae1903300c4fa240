//! Names: unknown, taken, unused.
use rattle::{nalgebra, prelude::*};

constraint! {
    pub struct Unknown { radius }
    |x, y, z| x^2 + y^2 + zz^2 - raduis^2 + q * sin
}
constraint! {
    pub struct Unused { a, r }
    |x, y, z| { let f = x^2; let _g = 1; x + y - r }
}
constraint! {
    pub struct Taken { x, e }
    |x, y| { let y = x; let pi = 3; x + y - e + pi }
}
constraint! {
    pub struct Functions { a }
    |x, y| log(x) + arctan(y) + sine(x) + quux(y) + a(x) + powi(x, 2)
}
constraint! {
    pub struct Arity {}
    |x, y| sin(x, y) + atan2(x) + min(x) + y.hypot() + exp()
}
constraint! {
    pub struct Keywords { type, r#fn, self }
    |x| x + r#fn
}
constraint! {
    pub struct Nameless {}
    |x, _| { let in = x; x + in }
}
potential! {
    pub struct Timed {}
    |x| x * sin(t)
}
constraint! {
    pub struct Moved {}
    |x, y| x - y * time
}
potential! {
    pub struct Foreign {}
    |x| x * include_str!("factor.txt") + concat![1, 2] + u
}

fn main() {
    // The stubs stand in, so that these lines are not reported as well.
    let q = nalgebra::vector![0.0, 0.0, 0.0];
    Unknown { radius: 1.0 }.value(&q);
    Unused { a: 1.0, r: 1.0 }.jacobian(&q);
    let _ = (Taken { x: 1.0, e: 1.0 }, Functions { a: 1.0 }, Arity {});
}
