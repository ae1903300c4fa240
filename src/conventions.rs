//! Signs, scales and units, in one place.
//!
//! ```text
//! M q̈ = −∇U(q) + G(q, t)ᵀ λ,   g(q, t) = 0,   G = ∂g/∂q             H′ = pᵀM⁻¹p/2 + U(q) − λ·g(q, t)
//! ```
//!
//! * **Masses** are 1 unless a scene names them; a [`State`](crate::State) holds momenta p = M v, not velocities.
//!   Potentials do not know masses: the weight of a body with mass m is a potential with parameter m·g, see
//!   [`weights`](crate::potentials::weights).
//! * **Forces** are −∇U. Between two bodies, Fᵢ = −(U′(r)/r)(qᵢ − qⱼ): repulsive where U falls with r.
//! * **Multipliers.** λ is positive where the constraint pushes along ∇g. The position multiplier λₙ₊₁ and the momentum
//!   multiplier μₙ₊₁ of a RATTLE step are both on the scale of the equation above, each with a factor h/2 in its half
//!   of the step. Each alone is first order, λₙ₊₁ = λ(tₙ) + O(h), μₙ = λ(tₙ) + O(h) with opposite errors; (μₙ + λₙ₊₁)/2
//!   = λ(tₙ) + O(h²). A method that consists of several RATTLE steps (a composition, `Geodesic`) reports to an observer
//!   the multipliers of its inner steps: each is an impulse divided by h/2 of the inner step, hence only a share of the
//!   whole step's force. `simulation.multipliers()` is λ of the present state, from g̈ = 0, whatever the method,
//!   without what constraints answer to flows. The unit of λ is that of U over that of g, so Gᵀλ is a force; see
//!   [`constraint_forces`](crate::Simulation::constraint_forces). Where equations depend on each other, λ is not
//!   unique; then the λ of least norm is given, with every equation scaled to a gradient of length 1 (in the metric of
//!   M⁻¹).
//! * **Curvature** κ along v is positive where the surface bends away from ∇g: λ|∇g| = −(κ|v|² + n·f), with n = ∇g/|∇g|
//!   and f = −∇U; see [`curvature`](crate::curvature).
//! * **Moving constraints** g(q, t) = 0 require velocities with G v = −∂g/∂t. They do the work W = −∫ λ·∂g/∂t dt, so
//!   that H − W is conserved.
//! * **Phase space**: q̇ = ∂H/∂p − (∂g/∂p)ᵀλ, ṗ = −∂H/∂q + (∂g/∂q)ᵀλ; {a, b} = ∂a/∂q·∂b/∂p − ∂a/∂p·∂b/∂q. A step moves
//!   along the fibre (the flow with g as its Hamiltonian) by h/2 λ at its start and by h/2 μ at its end; see
//!   [`phase`](crate::phase).
//! * **Rigid bodies**: the rotation Q takes coordinates in the body's frame to coordinates in space. Angular momentum
//!   is given in the body's frame.
//! * **Residuals** are |g(q, t)|, in the unit of g, and |G v + ∂g/∂t| with v = M⁻¹p (in phase space |{g, H}|), in that
//!   unit over time. Error messages give distances, |g|/|∇g|.
//! * **Units** are any that fit together. Results depend neither on their sizes nor on a constant factor of g, as long
//!   as |∇g|, |p| and |q| stay within 1e±75, so that products of four are numbers. If g is multiplied by a power of
//!   two, a simulation stays the same, bit for bit.
//!
//! | elsewhere | there | here |
//! |---|---|---|
//! | Hairer–Lubich–Wanner, Leimkuhler–Reich, Mici | q̈ = −∇U − ∇g λ | −λ |
//! | McLachlan–Modin–Verdier–Wilkins | ż = X_H + X_g λ, X_g = (∂g/∂p, −∂g/∂q) | −λ |
//! | the notebook “Billiards on surfaces”, text | q̈ = −∇U + ∇g λ | λ |
//! | the same, text: position of leapfrog | qₙ₊₁ = qₙ − h M⁻¹p | qₙ + h M⁻¹p |
//! | the same, its code: pair force | +∇U, which keeps K − U | −∇U |
//! | the same, its code: position | q̈ = −∇U − ∇g λ | −λ |
//! | the same, its code: momentum, without h/2 | p = p̂ − ∇g μ | −(2/h) μ |
//! | slides on Geometric RATTLE, pendulum with g = \|q\|² − 1 | ṗ = −∂H/∂q − λq | −λ/2 |
//! | the same, along its fibre | p + λq | λ/h |
//! | pyoomph's pendulum, Lagrange's equations | ∂L/∂x − d/dt ∂L/∂ẋ + λ ∂g/∂x = 0 | λ |
//! | the same, equations of motion and code | m ẍ = −λ x/r | −λ |
