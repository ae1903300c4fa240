//! Tokens that are read ahead: what comes next, and what is left.

use proc_macro2::{Delimiter, Ident, TokenStream, TokenTree};
use syn::ext::IdentExt;
use syn::parse::ParseStream;
use syn::{Lit, token};

/// Whether an operand may begin here.
pub(crate) fn starts_operand(input: ParseStream) -> bool {
    input.peek(Lit) || input.peek(Ident::peek_any) || input.peek(token::Paren)
}

/// A problem at the next token; `syn`'s own puts "unexpected end of input" before it.
pub(crate) fn error(input: ParseStream, message: impl std::fmt::Display) -> syn::Error {
    syn::Error::new(input.span(), message)
}

/// The next token, for a message.
pub(crate) fn found(input: ParseStream) -> String {
    match input.cursor().token_tree() {
        None => "nothing".to_owned(),
        Some((TokenTree::Group(group), _)) => match group.delimiter() {
            Delimiter::Parenthesis => "`(`".to_owned(),
            Delimiter::Brace => "`{`".to_owned(),
            Delimiter::Bracket => "`[`".to_owned(),
            Delimiter::None => "an expression".to_owned(),
        },
        Some((token, _)) => format!("`{token}`"),
    }
}

/// Whether a group without delimiters comes next: what a `macro_rules!` macro was given as an expression. `syn`
/// looks into such a
/// group when it is asked for the next token, so that of `-3` in a group only the sign would be seen.
pub(crate) fn is_invisible(input: ParseStream) -> bool {
    input.cursor().group(Delimiter::None).is_some()
}

/// The content of a group without delimiters, if one comes next.
pub(crate) fn invisible(input: ParseStream) -> Option<TokenStream> {
    let step = input.step(|cursor| match cursor.group(Delimiter::None) {
        Some((inside, _, rest)) => Ok((inside.token_stream(), rest)),
        None => Err(cursor.error("no group")),
    });
    step.ok()
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
