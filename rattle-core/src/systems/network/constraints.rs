//! Networks: any number of constraints between any bodies, with masses, pins and constraints that move.
//!
//! A **kernel**, written by `constraint!`, is a function of few bodies. A **topology** says which bodies each copy of
//! the kernel links. From these the components, which share no body, are found; each is solved by itself, with suitable
//! linear algebra.
//!
//! ```text
//! M q̈ = f(q) + G(q, t)ᵀ λ,    g(q, t) = 0,    one block of M for each body
//! ```

pub(crate) use crate::systems::network::algebra::LinearAlgebra;
pub(crate) use crate::systems::network::mass::Mass;
use crate::systems::network::shape::{Component, Shape};

use crate::systems::network::alike::{Alike, alone};
pub(crate) use crate::systems::network::group::LinkGroup;
pub(crate) use crate::systems::network::mass::Root;
use crate::systems::network::orthogonal::MOST_EQUATIONS;
use crate::systems::network::rows::Rows;
pub(crate) use crate::systems::network::rows::components;
pub(crate) use crate::systems::network::solver::Solver;

use crate::error::{Error, NetworkMistake};
use std::sync::Arc;

/// Constraints between bodies, and their masses; made by the methods of [`Scene`](crate::scene::Scene).
#[derive(Debug, Clone)]
pub struct Network<const D: usize> {
    pub(crate) groups: Vec<Arc<dyn LinkGroup<D>>>,
    pub(crate) masses: Masses<D>,
    pub(crate) pins: Vec<(usize, [f64; D])>,
    pub(crate) algebra: LinearAlgebra,
    /// Of how many bodies the last link, pin or mass was said.
    pub(crate) bodies: usize,
    /// What could not be copied when their number was changed.
    pub(crate) not_copied: Option<NetworkMistake>,
}

/// Whose masses.
#[derive(Debug, Clone)]
pub(crate) enum Masses<const D: usize> {
    /// The same for every body.
    Each(Mass<D>),
    /// Those of the bodies in turn.
    Listed(Vec<Mass<D>>),
}

impl<const D: usize> Default for Network<D> {
    fn default() -> Self {
        Self {
            groups: Vec::new(),
            masses: Masses::Each(Mass::Unit),
            pins: Vec::new(),
            algebra: LinearAlgebra::Automatic,
            bodies: 1,
            not_copied: None,
        }
    }
}

/// Up to so many equations both are kept: elimination, and an orthonormal basis for where they are nearly dependent.
pub(crate) const FEW: usize = 6;

impl<const D: usize> Network<D> {
    pub(crate) fn with(mut self, links: impl LinkGroup<D> + 'static) -> Self {
        self.groups.push(Arc::new(links));
        self
    }

    /// For so many bodies.
    #[inline(never)]
    pub(crate) fn shape(&self, bodies: usize) -> Result<Shape<D>, Error> {
        let mistake = |what| Err(Error::Network(what));
        if let Some(what) = &self.not_copied {
            return mistake(what.clone());
        }
        let mut roots = Vec::with_capacity(bodies);
        match &self.masses {
            Masses::Listed(list) if list.len() != bodies => {
                return mistake(NetworkMistake::MassCount { masses: list.len(), bodies });
            }
            masses => {
                for body in 0..bodies {
                    let mass = match masses {
                        Masses::Each(mass) => mass,
                        Masses::Listed(list) => &list[body],
                    };
                    let Some(root) = Root::new(mass) else {
                        return mistake(NetworkMistake::Mass { body });
                    };
                    roots.push(root);
                }
            }
        }
        for (pin, &(body, place)) in self.pins.iter().enumerate() {
            if body >= bodies {
                return mistake(NetworkMistake::NoSuchBody { what: "pin", member: pin, body, bodies });
            }
            if !place.iter().all(|x| x.is_finite()) {
                return mistake(NetworkMistake::PinNotFinite { body, place: place.to_vec() });
            }
            if matches!(roots[body], Root::Pinned)
                && let Some((_, other)) =
                    self.pins[..pin].iter().find(|&&(before, other)| before == body && other != place)
            {
                let (first, second) = (other.to_vec(), place.to_vec());
                return mistake(NetworkMistake::PinnedTwice { body, first, second });
            }
            roots[body] = Root::Pinned;
        }
        for group in &self.groups {
            let (touched, arity) = group.bodies();
            for (member, ends) in touched.chunks_exact(arity).enumerate() {
                if let Some(&body) = ends.iter().find(|&&body| body >= bodies) {
                    return mistake(NetworkMistake::NoSuchBody { what: group.name(), member, body, bodies });
                }
                if let Some(&body) =
                    ends.iter().enumerate().find_map(|(i, b)| ends[..i].contains(b).then_some(b))
                {
                    return mistake(NetworkMistake::Repeated { what: group.name(), member, body });
                }
                if group.acting().is_some() && ends.iter().any(|&body| !roots[body].is_diagonal()) {
                    return mistake(NetworkMistake::ActingNeedsDiagonalMass { what: group.name() });
                }
            }
        }
        let (mut rows_so_far, mut blocks_so_far, mut widest) = (0, 0, (0, 0));
        let (components, fixed) = components(&self.groups, &roots);
        if let (LinearAlgebra::Orthogonal, Some(largest)) =
            (self.algebra, components.iter().map(Rows::equations).max())
            && largest > MOST_EQUATIONS
        {
            return mistake(NetworkMistake::TooManyForBasis { equations: largest, most: MOST_EQUATIONS });
        }
        let pins = self.pins.iter().copied().collect();
        let components: Vec<_> = components
            .into_iter()
            .map(|rows| {
                let first = (rows_so_far, blocks_so_far);
                let (equations, blocks) = (rows.equations(), rows.blocks());
                rows_so_far += equations;
                blocks_so_far += blocks;
                widest = (widest.0.max(equations), widest.1.max(blocks));
                let few = equations <= FEW;
                let solver = match self.algebra {
                    LinearAlgebra::Orthogonal => Solver::orthogonal(&rows),
                    LinearAlgebra::Automatic if few => Solver::few(&rows, &roots, &self.groups, &pins),
                    #[cfg(feature = "faer")]
                    LinearAlgebra::Supernodal => Solver::supernodal(&rows, &roots),
                    LinearAlgebra::Automatic | LinearAlgebra::Elimination => {
                        Solver::elimination(&rows, &roots)
                    }
                };
                Component { rows, solver, first }
            })
            .collect();
        let mut held = vec![false; bodies];
        components.iter().flat_map(|component| &component.rows.bodies).for_each(|&body| held[body] = true);
        self.pins.iter().for_each(|&(body, _)| held[body] = true);
        let loose = (0..bodies).filter(|&body| !held[body]).collect();
        let each: Vec<_> = components.iter().map(|component| (&component.rows, component.first)).collect();
        // Of few equations that are eliminated in full.
        let alike = match self.algebra {
            LinearAlgebra::Automatic => Alike::of(&each, &self.groups, &roots),
            _ => Vec::new(),
        };
        Ok(Shape {
            alone: alone(components.len(), &alike),
            alike,
            groups: self.groups.clone(),
            kinked: (0..self.groups.len()).filter(|&group| self.groups[group].has_kinks()).collect(),
            moving: components.iter().any(|component| component.rows.moving),
            over_masses: roots.iter().map(Root::over_masses).collect(),
            roots,
            pins: self.pins.clone(),
            components,
            loose,
            fixed,
            equations: self
                .groups
                .iter()
                .map(|group| group.bodies().0.len() / group.bodies().1 * group.equations())
                .sum(),
            blocks: blocks_so_far,
            widest,
        })
    }
}
