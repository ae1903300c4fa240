//! Effects: everything that acts on the bodies besides constraints. Effects that a scene does not name cost nothing. To
//! the user an effect is a value given to `Scene::with`; the rest of this page is for writing effects of your own. Each
//! trait exists for all effects of a scene and for one of them:
//!
//! | | of a scene | one of them |
//! |---|---|---|
//! | as users name them | [`Effects`]: `()`, [`With`] | [`Effect`], of a kind: [`OnEach`], [`BetweenPairs`], [`BetweenNear`], [`BetweenNearKinds`], [`BetweenKinds`], [`AlongSurface`], [`ByGeodesics`], [`Among`], [`Driven`], [`Flowing`], [`ByForce`], [`Propelled`] |
//! | over a scalar | [`Forces`]: `()`, [`Superposed`] | [`Acting`]: [`ActsOnEach`], [`ActsBetweenPairs`], [`ActsBetweenNear`], [`ActsBetweenKinds`], [`ActsAlong`], [`ActsByGeodesics`], [`ActsAmong`], [`ActsDriven`], [`ActsByFlow`], [`ActsByForce`], [`ActsBySelf`] |
//! | in lanes of a sweep | [`Swept`] | [`Swept`] |
//!
//! The force on one body is a [`Force`]. Effects that depend on momenta are [`Flow`]s. Collisions are [`Contacts`],
//! which are given to a simulation, not to a scene.

pub mod along;
pub mod along_geodesics;
pub mod among;
pub mod andersen;
pub mod between_kinds;
pub mod between_near;
pub mod between_pairs;
pub mod by_force;
mod cells;
pub mod contact;
pub mod drag;
pub mod driven;
pub mod dry_friction;
pub mod flow;
pub mod force;
pub mod hard_spheres;
pub mod interval;
pub mod langevin;
pub mod laws;
pub mod list;
pub mod magnetic;
pub mod moment;
mod near;
pub mod neighbours;
pub mod noise;
pub mod on_each;
pub mod one;
pub mod ornstein_uhlenbeck;
pub mod rescaling;
pub mod self_propulsion;
pub mod stop;
pub mod swept;
mod tiles;

pub use crate::kernel::kinds::Kinds;
pub use crate::kernel::over::Over;
pub use crate::kernel::within::{Along, AlongGeodesics, Within};
pub use along::{ActsAlong, AlongSurface};
pub use along_geodesics::{ActsByGeodesics, ByGeodesics};
pub use among::{ActsAmong, Among};
pub use andersen::Andersen;
pub use between_kinds::{ActsBetweenKinds, BetweenKinds};
pub use between_near::{ActsBetweenNear, BetweenNear, BetweenNearKinds};
pub use between_pairs::{ActsBetweenPairs, BetweenPairs};
pub use by_force::{ActsByForce, ByForce, ByForceAmong};
pub use contact::{Contacts, Gradient};
pub use drag::{LinearDrag, QuadraticDrag};
pub use driven::{ActsDriven, Driven, DrivenAmong};
pub use dry_friction::DryFriction;
pub use flow::{ActsByFlow, Flow, Flowing};
pub use force::{Absent, Force};
pub use hard_spheres::HardSpheres;
pub use interval::{Inertia, Interval, Manner, Normals, Rule};
pub use langevin::Langevin;
pub use list::{Effects, Forces, Superposed, With};
pub use magnetic::MagneticField;
pub use moment::Moment;
pub use noise::Noise;
pub use on_each::{ActsOnEach, OnEach, SweptOnEach};
pub use one::{Acting, Effect};
pub use ornstein_uhlenbeck::OrnsteinUhlenbeck;
pub use rescaling::VelocityRescaling;
pub use self_propulsion::{ActsBySelf, Propelled, SelfPropulsion};
pub use stop::Stop;
pub use swept::{OfLanes, Swept};
