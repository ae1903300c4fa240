//! Coefficients of symmetric compositions, each number the double nearest to 40 digits that satisfy the order
//! conditions.
//!
//! The number of stages determines the cost of a composition, the largest |γ| how long a step may be, and Σ|γ| roughly
//! the size of the error.

/// Coefficients of a symmetric composition.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coefficients {
    /// Author, year, order.
    pub name: &'static str,
    /// The order of the composition of a method of order 2.
    pub order: u32,
    /// γ₁ … γₛ.
    pub gammas: &'static [f64],
}

/// γ₁ … γₛ from its first half and the middle one.
const fn mirrored<const HALF: usize, const S: usize>(half: [f64; HALF]) -> [f64; S] {
    assert!(S == 2 * HALF - 1);
    let mut gammas = [0.0; S];
    let mut i = 0;
    while i < S {
        gammas[i] = half[if i < HALF { i } else { S - 1 - i }];
        i += 1;
    }
    gammas
}

/// H. Yoshida, Phys. Lett. A 150 (1990) 262, the triple jump: γ₁ = γ₃ = 1/(2 − ∛2); three stages, |γ| ≤ 1.70, Σ|γ| =
/// 4.4.
pub const YOSHIDA_1990_ORDER_4: Coefficients = Coefficients {
    name: "Yoshida 1990, order 4",
    order: 4,
    gammas: &mirrored::<2, 3>([1.3512071919596575, -1.7024143839193153]),
};

/// M. Suzuki, Phys. Lett. A 146 (1990) 319: γ₁ = γ₂ = γ₄ = γ₅ = 1/(4 − ∛4), γ₃ = −∛4 γ₁; five stages, |γ| ≤ 0.66, Σ|γ|
/// = 2.3.
pub const SUZUKI_1990_ORDER_4: Coefficients = Coefficients {
    name: "Suzuki 1990, order 4",
    order: 4,
    gammas: &mirrored::<3, 5>([0.4144907717943757, 0.4144907717943757, -0.657963087177503]),
};

/// R. I. McLachlan, SIAM J. Sci. Comput. 16 (1995) 151, from γ₁ = 0.28; five stages, |γ| ≤ 0.81, Σ|γ| = 2.6.
pub const MCLACHLAN_1995_ORDER_4: Coefficients = Coefficients {
    name: "McLachlan 1995, order 4",
    order: 4,
    gammas: &mirrored::<3, 5>([0.28, 0.6254664284676701, -0.8109328569353401]),
};

/// W. Kahan, R.-C. Li, Math. Comp. 66 (1997) 1089: γ₁, γ₂ = (3 ∓ √3)/6, γ₃ = −1; five stages, |γ| ≤ 1.00, Σ|γ| = 3.0.
pub const KAHAN_LI_1997_ORDER_4: Coefficients = Coefficients {
    name: "Kahan–Li 1997, order 4",
    order: 4,
    gammas: &mirrored::<3, 5>([0.2113248654051871, 0.7886751345948129, -1.0]),
};

/// H. Yoshida, Phys. Lett. A 150 (1990) 262, solution A; seven stages, |γ| ≤ 1.32, Σ|γ| = 5.7.
pub const YOSHIDA_1990_ORDER_6: Coefficients = Coefficients {
    name: "Yoshida 1990, order 6",
    order: 6,
    gammas: &mirrored::<4, 7>([
        0.7845136104775573, 0.23557321335935813, -1.177679984178871, 1.3151863206839112,
    ]),
};

/// W. Kahan, R.-C. Li, Math. Comp. 66 (1997) 1089; nine stages, |γ| ≤ 0.80, Σ|γ| = 3.8.
pub const KAHAN_LI_1997_ORDER_6: Coefficients = Coefficients {
    name: "Kahan–Li 1997, order 6",
    order: 6,
    gammas: &mirrored::<5, 9>([
        0.3921614440073141, 0.33259913678935943, -0.7062461725576393, 0.0822135962935508, 0.79854399093483,
    ]),
};

/// R. I. McLachlan, SIAM J. Sci. Comput. 16 (1995) 151, from γ₁ = 0.1867; nine stages, |γ| ≤ 0.94, Σ|γ| = 4.4.
pub const MCLACHLAN_1995_ORDER_6: Coefficients = Coefficients {
    name: "McLachlan 1995, order 6",
    order: 6,
    gammas: &mirrored::<5, 9>([
        0.1867, 0.5554970237124784, 0.12946694891347535, -0.8432656233877346, 0.9432033015235617,
    ]),
};

/// M. Suzuki, K. Umeno, Springer Proc. Phys. 76 (1993) 74; 15 stages, |γ| ≤ 0.80, Σ|γ| = 6.5.
pub const SUZUKI_UMENO_1993_ORDER_8: Coefficients = Coefficients {
    name: "Suzuki–Umeno 1993, order 8",
    order: 8,
    gammas: &mirrored::<8, 15>([
        0.741670364350613, -0.4091008258000316, 0.1907547102962384, -0.5738624711160822, 0.2990641813036559,
        0.33462491824529816, 0.3152930923967666, -0.7968879393529164,
    ]),
};

/// W. Kahan, R.-C. Li, Math. Comp. 66 (1997) 1089; 17 stages, |γ| ≤ 0.61, Σ|γ| = 5.4.
pub const KAHAN_LI_1997_ORDER_8: Coefficients = Coefficients {
    name: "Kahan–Li 1997, order 8",
    order: 8,
    gammas: &mirrored::<9, 17>([
        0.13020248308889007, 0.5611629817751084, -0.38947496264484727, 0.1588419065551556,
        -0.39590389413323757, 0.1845396409783157, 0.25837438768632204, 0.2950117236093103,
        -0.6055085338300346,
    ]),
};

/// R. I. McLachlan, SIAM J. Sci. Comput. 16 (1995) 151; 17 stages, |γ| ≤ 0.63, Σ|γ| = 5.5.
pub const MCLACHLAN_1995_ORDER_8: Coefficients = Coefficients {
    name: "McLachlan 1995, order 8",
    order: 8,
    gammas: &mirrored::<9, 17>([
        0.12886597938144329, 0.581514087105251, -0.4101753714698501, 0.18514693571658775,
        -0.4095523434208514, 0.14440594108001203, 0.27833550039367966, 0.31495668391629483,
        -0.626994825405134,
    ]),
};

/// W. Kahan, R.-C. Li, Math. Comp. 66 (1997) 1089; 31 stages, |γ| ≤ 0.91, Σ|γ| = 13.9.
pub const KAHAN_LI_1997_ORDER_10: Coefficients = Coefficients {
    name: "Kahan–Li 1997, order 10",
    order: 10,
    gammas: &mirrored::<16, 31>([
        -0.48159895600253005, 0.0036303931544595927, 0.5018031755872314, 0.2829840262450625,
        0.8070296789537222, -0.026090580538592204, -0.8728659014631807, -0.5237356806251058,
        0.4452184429995279, 0.18612289547097907, 0.23137327866438362, -0.5219103659041863,
        0.7486611371449929, 0.06673651189060406, -0.8036032437567083, 0.9124903763586799,
    ]),
};

/// M. Sofroniou, G. Spaletta, Optim. Methods Softw. 20 (2005) 597; 35 stages, |γ| ≤ 0.41, Σ|γ| = 6.2.
pub const SOFRONIOU_SPALETTA_2005_ORDER_10: Coefficients = Coefficients {
    name: "Sofroniou–Spaletta 2005, order 10",
    order: 10,
    gammas: &mirrored::<18, 35>([
        0.07879572252168641, 0.3130961034151085, 0.027918383235078066, -0.22959284159390708,
        0.13096206107716488, -0.2697334056545107, 0.07497334315589144, 0.1119934239998102,
        0.36613344954622673, -0.3991056301360359, 0.10308739852747108, 0.41143087395589023,
        -0.0048663605831352616, -0.3920333537086399, 0.05194250296244965, 0.050665090759924494,
        0.049674370639729876, 0.049317735759594535,
    ]),
};

/// All coefficients, by increasing order.
pub const ALL: [Coefficients; 12] = [
    YOSHIDA_1990_ORDER_4,
    SUZUKI_1990_ORDER_4,
    MCLACHLAN_1995_ORDER_4,
    KAHAN_LI_1997_ORDER_4,
    YOSHIDA_1990_ORDER_6,
    KAHAN_LI_1997_ORDER_6,
    MCLACHLAN_1995_ORDER_6,
    SUZUKI_UMENO_1993_ORDER_8,
    KAHAN_LI_1997_ORDER_8,
    MCLACHLAN_1995_ORDER_8,
    KAHAN_LI_1997_ORDER_10,
    SOFRONIOU_SPALETTA_2005_ORDER_10,
];
