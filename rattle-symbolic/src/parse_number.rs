//! Numbers of the language.

use crate::parse_expression::Parser;
use crate::problems::shortened;
use crate::syntax::{Expr, Kind, Operator};
use proc_macro2::Ident;
use syn::Lit;
use syn::parse::{ParseStream, Result};

impl Parser<'_> {
    /// A number, where one comes next. A name that is written onto it, as in `2x`, is reported and read as a factor.
    pub(crate) fn number(&mut self, input: ParseStream) -> Result<Expr> {
        let literal: Lit = input.parse()?;
        let (digits, suffix) = match &literal {
            Lit::Int(int) => (int.base10_digits().to_owned(), int.suffix().to_owned()),
            Lit::Float(float) => (float.base10_digits().to_owned(), float.suffix().to_owned()),
            _ => {
                let message = "expected a number; other literals have no meaning in a formula";
                return Err(syn::Error::new_spanned(&literal, message));
            }
        };
        let at = self.problems.extent(literal.span());
        let value = digits.parse::<f64>().unwrap_or(f64::INFINITY);
        let zero = || {
            digits.split(['e', 'E']).next().is_some_and(|digits| digits.trim_matches(['0', '.']).is_empty())
        };
        let beyond = match value {
            0.0 if !zero() => Some("small for `f64`; the smallest is about 5e-324"),
            _ if value.is_finite() => None,
            _ => Some("large for `f64`; the largest is about 1.8e308"),
        };
        if let Some(beyond) = beyond {
            self.problems.note(at, format!("`{}` is too {beyond}", shortened(&digits)));
            return Ok(self.make(Kind::Wrong, at));
        }
        let number = self.make(Kind::Number(value, digits.clone()), at);
        if suffix.is_empty() {
            return Ok(number);
        }
        if is_type(&suffix) {
            self.problems
                .note(at, format!("found the type `{suffix}` at a number; all are real, write `{digits}`"));
            return Ok(number);
        }
        let product = format!("{digits} * {suffix}");
        self.problems.note(at, format!("found `{digits}{suffix}`, expected an operator; write `{product}`"));
        let Ok(name) = syn::parse_str::<Ident>(&suffix) else { return Ok(number) };
        let name = self.make(Kind::Name(Ident::new(&name.to_string(), literal.span())), at);
        Ok(self.make(Kind::Chain(Box::new(number), vec![(Operator::Mul, name)]), at))
    }
}

fn is_type(suffix: &str) -> bool {
    ["f32", "f64", "i8", "i16", "i32", "i64", "i128", "isize", "u8", "u16", "u32", "u64", "u128", "usize"]
        .contains(&suffix)
}
