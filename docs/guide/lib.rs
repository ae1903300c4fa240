//! The guide, as a crate: `cargo test -p guide` compiles and runs the programs of its pages, and follows their links.

/// A page, and what its tests are called.
macro_rules! pages {
    ($($page:ident $file:literal)*) => {
        $(
            #[cfg(doctest)]
            #[doc = include_str!($file)]
            mod $page {}
        )*
    };
}

pages! {
    first_steps "first-steps.md"
    constraints "constraints.md"
    methods "methods.md"
    effects "effects.md"
    links "links.md"
    ensembles "ensembles.md"
    phase_space "phase-space.md"
    long_runs "long-runs.md"
    failures "failures.md"
    inside "inside.md"
    from_scipy "from-scipy.md"
    from_dae "from-dae.md"
    from_lammps "from-lammps.md"
    from_mici "from-mici.md"
    from_game_engines "from-game-engines.md"
}
