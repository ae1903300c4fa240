//! Solutions in closed form, and what is measured against them.

use rattle_flow::{Mesh, Resistance, Simulation};

pub(crate) const UNIT: Resistance = Resistance::DarcyWeisbach { gravity: 1.0 };

/// A strip of squares of side dx, each of two triangles, from 0 to `length` along x.
pub(crate) fn strip(cells: usize, length: f64) -> Mesh {
    let dx = length / cells as f64;
    let points = (0..=cells).flat_map(|i| [[i as f64 * dx, 0.0], [i as f64 * dx, dx]]).collect();
    let triangles = (0..cells as u32).flat_map(|i| {
        let [a, b, c, d] = [2 * i, 2 * i + 2, 2 * i + 3, 2 * i + 1];
        [[a, b, c], [a, c, d]]
    });
    Mesh::new(points, triangles.collect()).unwrap()
}

/// Σ M |h − exact| / Σ M exact.
pub(crate) fn error(
    simulation: &Simulation<impl rattle_flow::Method>,
    exact: impl Fn([f64; 2]) -> f64,
) -> f64 {
    let mesh = simulation.flow().mesh();
    let exact = mesh.at_vertices(exact);
    let difference: Vec<f64> = simulation.depth().iter().zip(&exact).map(|(h, e)| (h - e).abs()).collect();
    mesh.volume(&difference).unwrap() / mesh.volume(&exact).unwrap()
}

/// Depth of the spreading drop of Barenblatt in N dimensions, hᵅ √|∇h| with α = power, c = 1; ξ₀ = 0.4.
///
/// h = t^(−Nβ) f(r t^−β), β f ξ = f^α √|f′|, so f^(2α−2) f′ = −β² ξ²: f = ((2α−1) β² (ξ₀³ − ξ³)/3)^(1/(2α−1)).
pub(crate) fn barenblatt(dimensions: f64, power: f64, r: f64, t: f64) -> f64 {
    let n = 2.0 * power - 1.0;
    let beta = 1.0 / (dimensions * (power - 0.5) + 1.5);
    let xi = r * t.powf(-beta);
    t.powf(-dimensions * beta)
        * (n * beta * beta * (0.4_f64.powi(3) - xi.powi(3)).max(0.0) / 3.0).powf(1.0 / n)
}

/// On a plane of slope S a front moves on with c = √(h∞ S); behind it h = h∞ u with −u − ln(1 − u) = S (ct − x)/h∞.
pub(crate) fn wave(x: f64, t: f64) -> f64 {
    let (deep, slope) = (1.0, 1.0_f64);
    let z = slope * ((deep * slope).sqrt() * t - x) / deep;
    if z <= 0.0 {
        return 0.0;
    }
    // The function of u is increasing and convex; Newton's method from above.
    let mut u = 1.0 - (-z - 1.0_f64).exp();
    for _ in 0..60 {
        u -= (-u - (1.0 - u).ln() - z) * (1.0 - u) / u;
    }
    deep * u
}
