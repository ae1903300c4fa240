//! The macros, as the library's own catalogues use them: with the feature `serde`, what they make serialises.

macro_rules! constraint {
    ($($item:tt)*) => {
        rattle_macros::constraint! {
            #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
            $($item)*
        }
    };
}

macro_rules! potential {
    ($($item:tt)*) => {
        rattle_macros::potential! {
            #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
            $($item)*
        }
    };
}

macro_rules! pair_potential {
    ($($item:tt)*) => {
        rattle_macros::pair_potential! {
            #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
            $($item)*
        }
    };
}

pub(crate) use {constraint, pair_potential, potential};
