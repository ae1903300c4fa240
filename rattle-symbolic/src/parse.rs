//! Tokens to syntax: the item around the expression.
//!
//! ```text
//! item       attributes visibility `struct` Name `{` parameters `}` `|` variables `|` expression
//! parameter  attributes visibility name (`:` shape)?
//! variable   name (`:` shape)?
//! shape      `f64` or `[` shape `;` length `]`
//! ```

use crate::parse_expression::Parser;
use crate::problems::{Problems, shortened};
use crate::syntax::{Item, Parameter, Shape, UNKNOWN, Variable};
use crate::tokens::{DEEPEST, drain, name, too_deep};
use proc_macro2::{Ident, TokenStream, TokenTree};
use quote::{ToTokens, quote};
use syn::parse::{ParseStream, Parser as _, Result};
use syn::punctuated::Punctuated;
use syn::{Attribute, LitInt, Meta, Path, Token, Visibility, braced, bracketed, token};

/// The item, as far as it could be read.
pub(crate) fn parse(tokens: TokenStream, problems: &mut Problems) -> Option<Item> {
    if let Some(span) = too_deep(&tokens) {
        let message =
            format!("brackets nest more than {DEEPEST} deep here; give the inner part a name with `let`");
        problems.note_syntax(syn::Error::new(span, message));
        return None;
    }
    let mut found = None;
    let parsed = (|input: ParseStream| {
        let result = item(input, problems);
        drain(input);
        result.map(|item| found = Some(item))
    })
    .parse2(tokens);
    if let Err(error) = parsed
        && !problems.any()
    {
        problems.note_syntax(error); // what is left of a group is no news where the group was wrong
    }
    found
}

fn item(input: ParseStream, problems: &mut Problems) -> Result<Item> {
    let attributes = input.call(Attribute::parse_outer)?;
    let conditions = attributes.iter().filter_map(condition).collect();
    let attributes = attributes.into_iter().filter_map(underived).collect();
    let visibility: Visibility = input.parse()?;
    if !input.peek(Token![struct]) {
        return Err(input.error("expected `pub struct Name { parameters }` before the expression"));
    }
    input.parse::<Token![struct]>()?;
    let name = name(input)?;
    if input.peek(Token![<]) {
        problems
            .note_syntax(input.error("generics are not supported; the parameters of a formula are `f64`"));
        while !input.is_empty() && !input.peek(token::Brace) && !input.peek(Token![|]) {
            input.parse::<TokenTree>()?;
        }
    }
    if !input.peek(token::Brace) {
        return Err(input.error(format!(
            "expected the parameters of `{name}` in braces; write `{name} {{}}` if there are none"
        )));
    }
    let fields;
    braced!(fields in input);
    let parameters = parameters(&fields, &name, problems);
    if input.peek(Token![;]) {
        input.parse::<Token![;]>()?; // a slip that no one should have to think about
    }
    let mut item = Item {
        attributes,
        conditions,
        visibility: visibility.into_token_stream(),
        name,
        parameters,
        variables: vec![],
        body: None,
    };
    match variables(input, problems) {
        Ok(variables) => item.variables = variables,
        Err(error) => {
            problems.note_syntax(error);
            return Ok(item);
        }
    }
    if input.is_empty() {
        let message = "the expression is missing; write it after the variables, as in `|x, y| x^2 + y^2 - 1`";
        problems.note_syntax(syn::Error::new(item.name.span(), message));
    } else {
        item.body = Parser::new(problems).whole(input);
    }
    Ok(item)
}

/// What of the attribute decides whether the struct is there.
fn condition(attribute: &Attribute) -> Option<TokenStream> {
    if attribute.path().is_ident("cfg") {
        return Some(attribute.to_token_stream());
    }
    let list = attribute
        .path()
        .is_ident("cfg_attr")
        .then(|| attribute.parse_args_with(Punctuated::<Meta, Token![,]>::parse_terminated).ok())??;
    let predicate = list.first()?;
    let conditions: Vec<&Meta> = list.iter().skip(1).filter(|meta| meta.path().is_ident("cfg")).collect();
    (!conditions.is_empty()).then(|| quote!(#[cfg_attr(#predicate, #(#conditions),*)]))
}

/// What every struct derives anyway.
const DERIVED: [&str; 4] = ["Clone", "Copy", "Debug", "PartialEq"];

/// The attribute without the derives that would be made twice, also where a condition stands before them.
fn underived(attribute: Attribute) -> Option<TokenStream> {
    let whole = attribute.to_token_stream();
    let read = Punctuated::<Meta, Token![,]>::parse_terminated;
    if attribute.path().is_ident("derive") {
        return others_derived(&attribute.meta).map(|meta| quote!(#[#meta]));
    }
    let (true, Ok(list)) = (attribute.path().is_ident("cfg_attr"), attribute.parse_args_with(read)) else {
        return Some(whole);
    };
    let (Some(predicate), true) = (list.first(), list.iter().any(|meta| meta.path().is_ident("derive")))
    else {
        return Some(whole);
    };
    let rest: Vec<TokenStream> = list.iter().skip(1).filter_map(others_derived).collect();
    (!rest.is_empty()).then(|| quote!(#[cfg_attr(#predicate, #(#rest),*)]))
}

/// An attribute without what every struct derives, if anything is left.
fn others_derived(meta: &Meta) -> Option<TokenStream> {
    let whole = meta.to_token_stream();
    let Meta::List(derive) = meta else { return Some(whole) };
    let list = derive.parse_args_with(Punctuated::<Path, Token![,]>::parse_terminated);
    let (true, Ok(list)) = (derive.path.is_ident("derive"), list) else { return Some(whole) };
    let others: Vec<Path> = list.into_iter().filter(|path| !is_derived(path)).collect();
    (!others.is_empty()).then(|| quote!(derive(#(#others),*)))
}

/// Whether this is a derive of the standard library that every struct has: `Clone`, `core::clone::Clone`, not that of
/// another crate by the same name.
fn is_derived(path: &Path) -> bool {
    let (first, last) = (path.segments.first(), path.segments.last());
    let standard = first.is_some_and(|first| first.ident == "core" || first.ident == "std");
    (path.segments.len() == 1 || standard)
        && last.is_some_and(|last| DERIVED.iter().any(|derived| last.ident == derived))
}

/// The parameters; what is wrong with one is noted, and the rest is read.
fn parameters(fields: ParseStream, owner: &Ident, problems: &mut Problems) -> Vec<Parameter> {
    let mut list: Vec<Parameter> = Vec::new();
    while !fields.is_empty() {
        match parameter(fields, problems) {
            Ok(parameter) => list.push(parameter),
            Err(error) => {
                problems.note_syntax(error);
                while !fields.is_empty() && !fields.peek(Token![,]) {
                    let _ = fields.parse::<TokenTree>();
                }
            }
        }
        if fields.peek(Token![=]) {
            let message = format!("parameters have no defaults; values are given where `{owner}` is made");
            problems.note_syntax(fields.error(message));
            while !fields.is_empty() && !fields.peek(Token![,]) {
                let _ = fields.parse::<TokenTree>();
            }
        }
        if fields.is_empty() {
            break;
        }
        if fields.parse::<Token![,]>().is_err() {
            problems.note_syntax(fields.error("expected `,` between parameters"));
            if !fields.peek(syn::Ident) {
                drain(fields);
            }
        }
    }
    list
}

fn parameter(fields: ParseStream, problems: &mut Problems) -> Result<Parameter> {
    let attributes = fields.call(Attribute::parse_outer)?;
    if let Some(attribute) = attributes.iter().find(|attribute| condition(attribute).is_some()) {
        let message = "a formula has all of its parameters; put `cfg` before the struct, \
                       and write it once for each case";
        problems.note_syntax(syn::Error::new_spanned(attribute, message));
    }
    let attributes = attributes.into_iter().filter(|attribute| condition(attribute).is_none());
    let attributes = attributes.map(ToTokens::into_token_stream).collect();
    let visibility = match fields.parse()? {
        Visibility::Inherited => quote!(pub),
        given => given.into_token_stream(),
    };
    Ok(Parameter { attributes, visibility, name: name(fields)?, shape: optional_shape(fields, problems) })
}

fn variables(input: ParseStream, problems: &mut Problems) -> Result<Vec<Variable>> {
    if input.peek(Token![||]) {
        return Err(
            input.error("there are no variables; write their names between the bars, as in `|x, y, z|`")
        );
    }
    if !input.peek(Token![|]) {
        return Err(input.error("expected the variables between bars, as in `|x, y, z|`"));
    }
    input.parse::<Token![|]>()?;
    let mut list = Vec::new();
    while !input.peek(Token![|]) {
        let pattern = input.peek(token::Paren) || input.peek(token::Bracket) || input.peek(Token![&]);
        if pattern || input.peek(Token![mut]) || input.peek(Token![ref]) {
            return Err(input.error("variables are names alone, as in `|x, y|` or `|q: [f64; 3]|`"));
        }
        let name = name(input)?;
        let shape = optional_shape(input, problems);
        list.push(Variable { name, shape });
        if input.peek(Token![,]) {
            input.parse::<Token![,]>()?;
        } else if !input.peek(Token![|]) {
            return Err(input.error("expected `,` or `|` after a variable"));
        }
    }
    let bar: Token![|] = input.parse()?;
    if list.is_empty() {
        let message = "there are no variables; write their names between the bars, as in `|x, y, z|`";
        return Err(syn::Error::new_spanned(bar, message));
    }
    Ok(list)
}

/// The shape after a colon. One that is wrong is noted, and [`UNKNOWN`].
fn optional_shape(input: ParseStream, problems: &mut Problems) -> Shape {
    let mut shape = Shape::new();
    if input.parse::<Token![:]>().is_ok()
        && let Err(error) = read_shape(input, &mut shape, problems)
    {
        problems.note_syntax(error);
        let mut brackets = 0; // of `Vec<f64, A>`
        while !input.is_empty() && (brackets > 0 || !(input.peek(Token![,]) || input.peek(Token![|]))) {
            brackets += i32::from(input.peek(Token![<])) - i32::from(input.peek(Token![>]));
            let _ = input.parse::<TokenTree>();
        }
        return UNKNOWN.to_vec();
    }
    shape
}

/// More components than any one body has.
const LARGEST: usize = 4096;

fn read_shape(input: ParseStream, shape: &mut Shape, problems: &mut Problems) -> Result<()> {
    if !input.peek(token::Bracket) {
        let expected = "expected `f64` or an array of it, as in `[f64; 3]`";
        let Ok(scalar) = input.parse::<Ident>() else { return Err(input.error(expected)) };
        if scalar == "f64" {
            return Ok(());
        }
        let error = syn::Error::new_spanned(&scalar, format!("{expected}, found `{scalar}`"));
        if !["f32", "i32", "i64", "u32", "u64", "usize"].iter().any(|number| scalar == number) {
            return Err(error);
        }
        problems.note_syntax(error); // some number: read on as if it were the right one
        return Ok(());
    }
    let inside;
    bracketed!(inside in input);
    let place = shape.len();
    shape.push(0);
    if shape.len() > 8 {
        return Err(inside.error("arrays nest at most 8 deep"));
    }
    read_shape(&inside, shape, problems)?;
    if !inside.peek(Token![;]) {
        return Err(inside.error("expected `;` and the length of the array, as in `[f64; 3]`"));
    }
    inside.parse::<Token![;]>()?;
    let length: LitInt = match inside.parse() {
        Ok(length) => length,
        Err(error) => {
            return Err(syn::Error::new(error.span(), "expected the length of the array, a whole number"));
        }
    };
    shape[place] = length.base10_parse().unwrap_or(0);
    let size = shape[place..].iter().try_fold(1_usize, |size, &n| size.checked_mul(n)).unwrap_or(usize::MAX);
    if size == 0 || size > LARGEST {
        let found = shortened(&length.to_string());
        let message = format!("expected a length from 1 up to {LARGEST} components in all, found `{found}`");
        return Err(syn::Error::new_spanned(length, message));
    }
    if !inside.is_empty() {
        return Err(inside.error("expected `]` after the length"));
    }
    Ok(())
}
