//! Random and mutated texts through the macros: tokens or mistakes come out, never a panic, and never much of them.

use proc_macro2::{Delimiter, Spacing, TokenStream, TokenTree};
use rand::{RngExt, SeedableRng, rngs::StdRng};
use rattle_symbolic::{Macro, expand};
use std::panic::{AssertUnwindSafe, catch_unwind};

const MACROS: [Macro; 6] = [
    Macro::Constraint,
    Macro::Potential,
    Macro::Force,
    Macro::PairPotential,
    Macro::Hamiltonian,
    Macro::PhaseConstraint,
];

/// What inputs are made of, with two spaces between.
const PIECES: &str = "x  y  a  b  n  q  p  r  t  i  k  _  _z  r#type  type  self  Self  pi  e  0  1  2  3  0.5  1e-3  \
    1e308  1e309  1e400  5e-324  4096  1024  1025  4294967296  18446744073709551616  0x1F  1_000  2x  \
    2f64  1u8  'c'  \"text\"  b\"b\"  true  +  -  *  /  ^  **  <  <=  >  >=  ==  !=  !  =  &&  ||  &  \
    |  .  ..  ..=  ,  ;  :  ::  #  ?  @  $  ~  ->  =>  (  )  [  ]  {  }  let  mut  if  else  for  in  \
    sum  product  delta  dot  norm  min  mod  floor  atan2  pow  sqrt  sin  exp  struct A {}  |x, y|  'a  \
    #[cfg(any())]  [f64; 3]  f32  pub";

/// What they begin as.
const SEEDS: [&str; 12] = [
    "/// Doc.\n pub struct A { a, n: [f64; 3] } |x, y, z| { let f = (x^2 + y^2)^2 - a^2 * n[0]; f^2 + z^2 - n[1] }",
    "struct A {} |m: [[f64; 3]; 3]| for i in 0..3, j in i..3 { sum(k in 0..3, m[k][i] * m[k][j]) - delta(i, j) }",
    "struct A { c } |x, y| [if x < 0 && y > c || x >= 1 { sqrt(-x) } else if y <= 2 { x } else { y^3 }, min(x, y, c)]",
    "pub(crate) struct A { #[doc = \"d\"] pub a, } |x, y| x.sin().abs() * y^-2 + pow(x, 3/2) - 2^(1/3) * hypot(x, a)",
    "struct A {} |q: [f64; 2], p: [f64; 2]| dot(p, p) / 2 + norm(q) - product(i in 0..=1, q[i])",
    "struct A { k } |r| -k / r + exp(-r^2) * r^2.5",
    "struct A {} |x| x^2^x - 1e300 * x / 1e-300 + x^1024 - x^0 + 0^0 + 0 * x",
    "struct A { k: [[f64; 2]; 2] } |a: [f64; 2], b: [f64; 2]| k[0][1] * dot(a - b, 2 * a) + norm(a, b) - 1",
    "#[cfg(all())] #[derive(Debug, Default)] struct A {} |x: f64, _y| ln(x) + log10(x) - erf(x) * tan(x) + cbrt(x)",
    "struct A {} |x, y| { let g = { let h = x; h * y }; let n = 3; sum(i in 0..n, j in i..=n, g^i * j) }",
    "struct A {} |x, y| x * - - -y ^ -x ^ (y - 1) / 3 / x - (x, y)",
    "struct A {} |x, y| max(x, 1e999, 0.1) + 2x + f64::sin(x) + x ** 2 = y",
];

fn pieces(text: &str) -> Vec<String> {
    fn into(stream: TokenStream, list: &mut Vec<String>) {
        let mut joint = String::new(); // the first half of `..=`
        for token in stream {
            match token {
                TokenTree::Group(group) => {
                    let (open, close) = match group.delimiter() {
                        Delimiter::Parenthesis => ("(", ")"),
                        Delimiter::Brace => ("{", "}"),
                        Delimiter::Bracket => ("[", "]"),
                        Delimiter::None => ("", ""),
                    };
                    list.push(open.to_owned());
                    into(group.stream(), list);
                    list.push(close.to_owned());
                }
                other => {
                    let text = std::mem::take(&mut joint) + &other.to_string();
                    match other {
                        TokenTree::Punct(punct) if punct.spacing() == Spacing::Joint => joint = text,
                        _ => list.push(text),
                    }
                }
            }
        }
    }
    let mut list = Vec::new();
    into(text.parse().expect("a seed"), &mut list);
    list
}

/// Brackets that stand alone are dropped or closed, as else there are no tokens at all.
fn balanced(pieces: &[String]) -> String {
    let mut open = Vec::new();
    let mut text = String::new();
    for piece in pieces {
        match piece.as_str() {
            "(" => open.push(")"),
            "[" => open.push("]"),
            "{" => open.push("}"),
            ")" | "]" | "}" => match open.pop() {
                Some(close) => {
                    text.push_str(close);
                    text.push(' ');
                    continue;
                }
                None => continue,
            },
            _ => {}
        }
        text.push_str(piece);
        text.push(' ');
    }
    open.into_iter().rev().for_each(|close| text.push_str(close));
    text
}

fn input(random: &mut StdRng, seeds: &[Vec<String>]) -> String {
    let list: Vec<&str> = PIECES.split("  ").collect();
    let any = |random: &mut StdRng| list[random.random_range(0..list.len())].to_owned();
    let seed = &seeds[random.random_range(0..seeds.len())];
    if random.random_range(0..8) == 0 {
        let tail = (0..random.random_range(1..40)).map(|_| any(random)).collect::<Vec<_>>();
        let head = ["", "struct A { a } |x, y|", "struct A {} |q: [f64; 2], p: [f64; 2]| q[0] +"];
        return format!("{} {}", head[random.random_range(0..3)], balanced(&tail));
    }
    let mut list = seed.clone();
    for _ in 0..random.random_range(0..5) {
        let at = random.random_range(0..list.len());
        match random.random_range(0..6) {
            0 => drop(list.remove(at)),
            1 => list.insert(at, any(random)),
            2 => list[at] = any(random),
            3 => {
                let other = random.random_range(0..list.len());
                list.swap(at, other);
            }
            4 => {
                let other = &seeds[random.random_range(0..seeds.len())];
                let from = random.random_range(0..other.len());
                let to = random.random_range(from..=other.len().min(from + 12));
                list.splice(at..at, other[from..to].iter().cloned());
            }
            _ => {
                let to = random.random_range(at..=list.len().min(at + 8));
                let again = list[at..to].to_vec();
                list.splice(at..at, again);
            }
        }
        if list.is_empty() {
            list.push(any(random));
        }
    }
    balanced(&list)
}

/// What comes of so many inputs: how many were accepted.
fn survive(first: u64, count: u64) -> usize {
    let seeds: Vec<Vec<String>> = SEEDS.iter().map(|seed| pieces(seed)).collect();
    let mut accepted = 0;
    for seed in first..first + count {
        let random = &mut StdRng::seed_from_u64(seed);
        let text = input(random, &seeds);
        let which = MACROS[random.random_range(0_usize..8).saturating_sub(3)]; // half are constraints
        let Ok(tokens) = text.parse::<TokenStream>() else { continue };
        let result = catch_unwind(AssertUnwindSafe(|| expand(which, tokens).to_string()));
        let output = result.unwrap_or_else(|_| panic!("input {seed}, {which:?}: {text}"));
        assert!(
            output.len() < 10_000_000,
            "input {seed}, {which:?}: {} characters from {text}",
            output.len()
        );
        let fails = output.contains("compile_error");
        accepted += usize::from(!fails);
        assert!(fails || output.contains("__q") || output.contains("__s"), "input {seed}, {which:?}: {text}");
        let rust = syn::parse_str::<syn::File>(&output);
        assert!(rust.is_ok(), "input {seed}, {which:?}: {:?} in what comes of {text}", rust.err());
    }
    accepted
}

#[test]
fn nothing_panics() {
    let accepted = survive(0, 1500);
    assert!(accepted > 75, "some are formulas: {accepted}");
}

/// Ten million; some hours.
#[test]
#[ignore = "hours"]
fn nothing_panics_ten_million_times() {
    println!("{} accepted", survive(1 << 32, 10_000_000));
}
