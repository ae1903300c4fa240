//! Forces, and potentials that change with time.
use rattle::prelude::*;

potential! {
    pub struct Early {}
    |t, x| x * sin(t)
}
potential! {
    pub struct Vector {}
    |x, t: [f64; 2]| x * t[0]
}
potential! {
    pub struct Alone { a }
    |t| a * t
}
pair_potential! {
    pub struct Pair { a }
    |r, t| a * sin(t) / r
}
force! {
    pub struct Short { k }
    |q: [f64; 3], v: [f64; 3], t| [-k * q[0], -v[1] * t]
}
force! {
    pub struct Long { k }
    |x, y| [-k * x, y, 1]
}
force! {
    pub struct Middle { k }
    |x, t, v| -k * x - v * t
}
force! {
    pub struct Missing { k }
    |x, v| -k * x - c * v + time
}
force! {
    pub struct Unused { k, c }
    |x, v| -k * x - mod(v, 0)
}
constraint! {
    pub struct Rounded {}
    |x, y| ceil(x) + y % 2
}
force! {
    pub struct Still { c }
    |q: [f64; 1], v: [f64; 1], _t| [-c * v[0] + 0 * q[0]]
}
force! {
    pub struct Drag { c }
    |v: [f64; 2]| -c * v
}
force! {
    pub struct Reversed { c }
    |v, q| -c * v - q
}
constraint! {
    pub struct Crank { w }
    |t, x, y| x * sin(w * t) - y * cos(w * t)
}

force! {
    pub struct Interleaved { k }
    |x, vx, y, vy| [-k * x - vx, -k * y - vy]
}
hamiltonian! {
    pub struct MomentaFirst {}
    |p: [f64; 2], x: [f64; 2]| dot(p, p) / 2 + dot(x, x)
}

fn main() {
    // The stubs stand in, so that these lines are not reported as well.
    let _ = (Early {}, Vector {}, Alone { a: 1.0 }, Short { k: 1.0 }, Missing { k: 1.0 });
    let scene = Scene::point::<1>().with(Unused { k: 1.0, c: 1.0 });
    let _ = scene.simulate(State::at([1.0]), Rattle::new(0.1));
}
