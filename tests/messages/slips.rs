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

fn main() {}
