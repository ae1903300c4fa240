//! What cannot be read.
use rattle::{nalgebra, prelude::*};

constraint! {
    pub struct NoBody { a }
    |x, y|
}
constraint! {
    pub struct NoBars { a }
    x + y
}
constraint! {
    pub struct Empty {}
    || 1
}
constraint! {
    pub struct NoBraces
    |x| x
}
constraint! {
    |x| x
}
constraint! {
    pub struct Trailing {}
    |x, y| x + y; x
}
constraint! {
    pub struct Holes {}
    |x, y| (x + ) * (y - ) + ()
}
constraint! {
    pub struct Lets {}
    |x, y| { let a = x + ; let = 3; let mut b = 2; let c: f64 = x; a + y + b + c }
}
constraint! {
    pub struct NoValue {}
    |x, y| { let a = x + y; }
}
constraint! {
    pub struct Unclosed { a b }
    |x, y| x + y
}
constraint! {
    pub struct Types { a: f32 }
    |x: f64, y: [f64; 0], z: [i32; 2]| x
}

fn main() {
    let _ = (NoBody { a: 1.0 }, NoBars { a: 1.0 }, Lets {});
    let _ = Holes {}.value(&nalgebra::vector![1.0, 2.0]);
}
