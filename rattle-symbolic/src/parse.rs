//! Tokens to syntax: the item around the expression.
//!
//! ```text
//! item       attributes visibility `struct` Name `{` parameters `}` `|` variables `|` expression
//! parameter  attributes visibility name (`:` shape)?
//! variable   name (`:` shape)?
//! shape      `f64` or `[` shape `;` length `]`
//! ```

use crate::parse_expression::Parser;
use crate::problems::Problems;
use crate::syntax::{Item, Parameter, Shape, Variable};
use proc_macro2::{Ident, TokenStream};
use quote::ToTokens;
use syn::parse::{ParseStream, Parser as _, Result};
use syn::{Attribute, LitInt, Token, Visibility, braced, bracketed, token};

/// The item, as far as it could be read.
pub(crate) fn parse(tokens: TokenStream, problems: &mut Problems) -> Option<Item> {
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

/// Takes the rest, so that `syn` does not report it on top of our own message.
pub(crate) fn drain(input: ParseStream) {
    let _ = input.step(|cursor| {
        let mut rest = *cursor;
        while let Some((_, next)) = rest.token_tree() {
            rest = next;
        }
        Ok(((), rest))
    });
}

fn item(input: ParseStream, problems: &mut Problems) -> Result<Item> {
    let attributes = attributes(input)?;
    let visibility: Visibility = input.parse()?;
    if !input.peek(Token![struct]) {
        return Err(input.error("expected `pub struct Name { parameters }` before the expression"));
    }
    input.parse::<Token![struct]>()?;
    let name: Ident = input.parse()?;
    if !input.peek(token::Brace) {
        return Err(input.error(format!(
            "expected the parameters of `{name}` in braces; write `{name} {{}}` if there are none"
        )));
    }
    let fields;
    braced!(fields in input);
    let parameters = parameters(&fields).unwrap_or_else(|error| {
        problems.note_syntax(error);
        drain(&fields);
        vec![]
    });
    if input.peek(Token![;]) {
        input.parse::<Token![;]>()?; // a slip that no one should have to think about
    }
    let mut item = Item {
        attributes,
        visibility: visibility.into_token_stream(),
        name,
        parameters,
        variables: vec![],
        body: None,
    };
    match variables(input) {
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

fn attributes(input: ParseStream) -> Result<TokenStream> {
    Ok(input
        .call(Attribute::parse_outer)?
        .into_iter()
        .map(|attribute| attribute.into_token_stream())
        .collect())
}

fn parameters(fields: ParseStream) -> Result<Vec<Parameter>> {
    let mut list = Vec::new();
    while !fields.is_empty() {
        let attributes = attributes(fields)?;
        let visibility: Visibility = fields.parse()?;
        let visibility = match visibility {
            Visibility::Inherited => quote::quote!(pub),
            given => given.into_token_stream(),
        };
        let name: Ident = fields.parse()?;
        let shape = optional_shape(fields)?;
        list.push(Parameter { attributes, visibility, name, shape });
        if !fields.is_empty() {
            if !fields.peek(Token![,]) {
                return Err(fields.error("expected `,` between parameters"));
            }
            fields.parse::<Token![,]>()?;
        }
    }
    Ok(list)
}

fn variables(input: ParseStream) -> Result<Vec<Variable>> {
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
        let name: Ident = input.parse()?;
        let shape = optional_shape(input)?;
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

fn optional_shape(input: ParseStream) -> Result<Shape> {
    let mut shape = Shape::new();
    if input.peek(Token![:]) {
        input.parse::<Token![:]>()?;
        read_shape(input, &mut shape)?;
    }
    Ok(shape)
}

/// More components than any one body has.
const LARGEST: usize = 4096;

fn read_shape(input: ParseStream, shape: &mut Shape) -> Result<()> {
    if !input.peek(token::Bracket) {
        let scalar: Option<Ident> = input.parse().ok();
        return match scalar {
            Some(scalar) if scalar == "f64" => Ok(()),
            Some(other) => Err(syn::Error::new_spanned(&other, format!("expected `f64`, found `{other}`"))),
            None => Err(input.error("expected `f64` or an array of it, as in `[f64; 3]`")),
        };
    }
    let inside;
    bracketed!(inside in input);
    let place = shape.len();
    shape.push(0);
    if shape.len() > 8 {
        return Err(inside.error("arrays nest at most 8 deep"));
    }
    read_shape(&inside, shape)?;
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
        let message = format!("expected a length from 1 up to {LARGEST} components in all, found `{length}`");
        return Err(syn::Error::new_spanned(length, message));
    }
    if !inside.is_empty() {
        return Err(inside.error("expected `]` after the length"));
    }
    Ok(())
}
