//! Coefficients of compositions: their order conditions in exact arithmetic, and what is stored of them.

use crate::common::*;
use num_bigint::BigInt;
use rattle::Error;
use rattle::composition::{ALL, Coefficients};
use rattle::prelude::*;
use std::collections::BTreeMap;

/// Decimals kept: more than any coefficient has.
const DECIMALS: usize = 50;

/// γ₁ … γₛ times 10⁵⁰, and the first half as text.
struct Exact {
    gammas: Vec<BigInt>,
    first_half: Vec<String>,
}

/// The 40 digits of every composition, by name of its constant.
fn exact() -> BTreeMap<String, (u32, Exact)> {
    let path = format!("{}/tests/data/composition_coefficients.json", env!("CARGO_MANIFEST_DIR"));
    let table: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    let rows = table.as_object().unwrap().iter().map(|(name, row)| {
        let digits = row["first_half"].as_array().unwrap();
        let first_half: Vec<String> = digits.iter().map(|text| text.as_str().unwrap().to_owned()).collect();
        let numbers: Vec<BigInt> = first_half.iter().map(|text| scaled(text)).collect();
        let gammas = numbers.iter().chain(numbers.iter().rev().skip(1)).cloned().collect::<Vec<_>>();
        assert_eq!(gammas.len() as u64, row["stages"].as_u64().unwrap());
        (name.clone(), (row["order"].as_u64().unwrap() as u32, Exact { gammas, first_half }))
    });
    rows.collect()
}

/// A decimal number times 10⁵⁰.
fn scaled(text: &str) -> BigInt {
    let (whole, decimals) = text.split_once('.').unwrap();
    assert!(decimals.len() <= DECIMALS);
    format!("{whole}{decimals:0<DECIMALS$}").parse().unwrap()
}

/// A word Y_a Y_b ⋯ by its letters, all odd.
type Word = Vec<u32>;

/// All words whose letters add up to at most `weight`.
fn words(weight: u32) -> Vec<Word> {
    let mut found = vec![vec![]];
    for letter in (1..=weight).step_by(2) {
        let longer = words(weight - letter).into_iter().map(|mut word| {
            word.insert(0, letter);
            word
        });
        found.extend(longer);
    }
    found
}

fn weight(word: &[u32]) -> u32 {
    word.iter().sum()
}

fn factorial(n: usize) -> BigInt {
    (1..=n).fold(BigInt::from(1), |product, k| product * k)
}

/// Coefficients of the words in Πᵢ exp(Σₖ γᵢᵏYₖ), each times 10^(50·weight) and the factorial of its length: integers.
fn product(gammas: &[BigInt], order: u32) -> BTreeMap<Word, BigInt> {
    let words = words(order);
    let mut whole: BTreeMap<Word, BigInt> =
        words.iter().map(|word| (word.clone(), BigInt::from(u32::from(word.is_empty())))).collect();
    for gamma in gammas {
        let powers: Vec<BigInt> = (0..=order).map(|k| gamma.pow(k)).collect();
        let times = |word: &Word| {
            let splits = (0..=word.len()).map(|at| {
                let (before, by) = word.split_at(at);
                let ways = factorial(word.len()) / (factorial(at) * factorial(word.len() - at));
                &whole[before] * &powers[weight(by) as usize] * ways
            });
            (word.clone(), splits.sum())
        };
        whole = words.iter().map(times).collect();
    }
    whole
}

/// The largest coefficient of a word that should vanish, rounded up to a power of ten, with Σγ = 1 among them.
fn defect(gammas: &[BigInt], order: u32) -> i32 {
    let one = BigInt::from(10).pow(DECIMALS as u32);
    let sum: BigInt = gammas.iter().sum();
    let mut exponent = digits(&(sum - one)) - DECIMALS as i32;
    for (word, coefficient) in product(gammas, order) {
        if word.iter().any(|&letter| letter > 1) {
            let size =
                digits(&(coefficient / factorial(word.len()))) - (DECIMALS as u32 * weight(&word)) as i32;
            exponent = exponent.max(size);
        }
    }
    exponent
}

/// How many decimal digits an integer has: 10^digits is larger.
fn digits(number: &BigInt) -> i32 {
    let text = number.magnitude().to_string();
    if text == "0" { -1000 } else { text.len() as i32 }
}

#[test]
fn coefficients_satisfy_their_order_conditions_and_no_more() {
    let table = exact();
    assert_eq!(table.len(), ALL.len());
    assert_eq!(words(10).len(), 144, "Fibonacci: 1 + 1 + 1 + 2 + 3 + 5 + … + 55");
    for (name, (order, Exact { gammas, .. })) in table {
        let reached = defect(&gammas, order);
        assert!(reached <= -37, "{name}: a condition of order {order} is off by up to 1e{reached}");
        let next = defect(&gammas, order + 1);
        assert!(next >= -9, "{name}: conditions of order {} hold to 1e{next}, and should not", order + 1);
    }
}

#[test]
fn a_wrong_digit_is_seen() {
    let (order, Exact { mut gammas, .. }) = exact().remove("SOFRONIOU_SPALETTA_2005_ORDER_10").unwrap();
    let tiny = BigInt::from(10).pow(DECIMALS as u32 - 30);
    let last = gammas.len() - 1;
    gammas[0] += &tiny;
    gammas[last] += &tiny;
    gammas[last / 2] -= 2 * tiny;
    assert!(defect(&gammas, order) >= -33);
}

#[test]
fn constants_are_the_nearest_doubles() {
    for (name, (order, Exact { gammas, first_half })) in exact() {
        let Coefficients { order: stored, gammas: doubles, .. } = constant(&name);
        assert_eq!((stored, doubles.len()), (order, gammas.len()), "{name}");
        assert!(doubles.iter().eq(doubles.iter().rev()), "{name}");
        for (text, double) in first_half.iter().zip(doubles) {
            // `parse` rounds once, and to nearest.
            assert_eq!(double.to_bits(), text.parse::<f64>().unwrap().to_bits(), "{name}: {text}");
        }
    }
    assert_eq!(constant("SUZUKI_1990_ORDER_4"), SUZUKI_1990_ORDER_4);
}

#[test]
fn only_symmetric_methods_are_composed() {
    let scene = Scene::on(SURFACE);
    for error in [
        scene.simulate(billiard_45(), Composition::of(SUZUKI_1990_ORDER_4, SymplecticEuler::new(0.01))).err(),
        scene.simulate(billiard_45(), Composition::of(SUZUKI_1990_ORDER_4, Shake::new(0.01))).err(),
    ] {
        assert!(matches!(error, Some(Error::NeedsSymmetricMethod { .. })), "{error:?}");
    }
    let nested = Composition::of(SUZUKI_1990_ORDER_4, Composition::new(SUZUKI_1990_ORDER_4, 0.01));
    assert_eq!((nested.order(), nested.step_size()), (4, 0.01));
    scene.simulate(billiard_45(), nested).unwrap().step().unwrap();
    for coefficients in ALL {
        scene.simulate(billiard_45(), Composition::new(coefficients, 0.01)).unwrap().step().unwrap();
    }
}
