//! Tokens that are read ahead: what comes next, and what is left.

use proc_macro2::{Delimiter, Ident, Span, TokenStream, TokenTree};
use syn::ext::IdentExt;
use syn::parse::ParseStream;
use syn::{Lit, LitInt, Token, token};

/// Brackets nest no deeper, since `syn` looks into them by recursion.
pub(crate) const DEEPEST: usize = 500;

/// A bracket that is nested too deeply.
pub(crate) fn too_deep(tokens: &TokenStream) -> Option<Span> {
    let mut open = vec![tokens.clone().into_iter()];
    while let Some(innermost) = open.last_mut() {
        match innermost.next() {
            Some(TokenTree::Group(group)) if open.len() > DEEPEST => return Some(group.span_open()),
            Some(TokenTree::Group(group)) => open.push(group.stream().into_iter()),
            Some(_) => {}
            None => drop(open.pop()),
        }
    }
    None
}

/// Whether an operand without a sign may begin here; `-1` is a literal to syn.
pub(crate) fn starts_operand(input: ParseStream) -> bool {
    (input.peek(Lit) && !input.peek(Token![-])) || input.peek(Ident::peek_any) || input.peek(token::Paren)
}

/// What is wrong with what comes next wherever it stands: a keyword of Rust, but for `mod`, which is a function here;
/// `%`, `?`, and bars.
pub(crate) fn meaningless(input: ParseStream) -> Option<String> {
    if input.peek(Token![%]) {
        return Some(
            "there is no `%`; what is left of a division is `mod(x, y)`, which has the sign of y".into(),
        );
    }
    if input.peek(Token![?]) {
        return Some("there is no `?`; a choice is written `if x < 1 { a } else { b }`".into());
    }
    if input.peek(Token![|]) {
        return Some(
            "there are no bars; an absolute value is written `abs(x)`, that of an array `norm(a)`".into(),
        );
    }
    let keyword = input.peek(Ident::peek_any) && !input.peek(syn::Ident) && !input.peek(Token![mod]);
    keyword.then(|| format!("{} is a keyword of Rust, and has no meaning in a formula", found(input)))
}

/// A word that stands where an operator belongs, and what is written here.
pub(crate) fn word_of_elsewhere(input: ParseStream) -> Option<String> {
    let word = input.fork().parse::<Ident>().ok()?.to_string();
    let written = match &word[..] {
        "and" => "&&",
        "or" => "||",
        "elif" | "elsif" | "elseif" => "else if",
        _ => return None,
    };
    Some(format!("`{word}` is written `{written}`"))
}

/// Indices between one pair of brackets as they are written here: `[0][1]` for `[0, 1]`.
pub(crate) fn separate_indices(input: ParseStream) -> Option<String> {
    let (mut rest, mut list) = (input.cursor(), vec![String::new()]);
    while let Some((token, next)) = rest.token_tree() {
        match token {
            TokenTree::Punct(punct) if punct.as_char() == ',' => list.push(String::new()),
            other => list.last_mut()?.push_str(&other.to_string()),
        }
        rest = next;
    }
    let several = list.len() > 1 && list.iter().all(|index| !index.is_empty());
    several.then(|| list.iter().map(|index| format!("[{index}]")).collect())
}

/// The number that what comes next divides by.
pub(crate) fn divisor(input: ParseStream) -> Option<LitInt> {
    let ahead = input.fork();
    ahead.parse::<Token![/]>().and_then(|_| ahead.parse()).ok()
}

/// What is said where an operand is missing before what comes next.
pub(crate) fn no_operand(input: ParseStream) -> String {
    let ahead = input.fork();
    if ahead.parse::<Token![.]>().is_ok()
        && let Ok(digits) = ahead.parse::<LitInt>()
    {
        return format!("a number begins with a digit; write `0.{digits}`");
    }
    match found(input).as_str() {
        "nothing" => "expected an expression, found the end".to_owned(),
        "`let`" => "`let` belongs into a block: `{ let a = …; … }`".to_owned(),
        "`!`" => "there is no `!`; turn the comparison around".to_owned(),
        other => format!("expected an expression, found {other}"),
    }
}

/// Whether the name before is meant as a function to a power, as in `sin^2(x)`.
pub(crate) fn power_of_function(input: ParseStream) -> bool {
    let ahead = input.fork();
    ahead.parse::<Token![^]>().is_ok() && ahead.parse::<Lit>().is_ok() && ahead.peek(token::Paren)
}

/// Whether a `let` comes next that lacks the word: `name = …;`.
pub(crate) fn lets(input: ParseStream) -> bool {
    let ahead = input.fork();
    if ahead.parse::<Ident>().is_err() || !ahead.peek(Token![=]) || ahead.peek(Token![==]) {
        return false;
    }
    let mut rest = ahead.cursor();
    while let Some((token, next)) = rest.token_tree() {
        if matches!(token, TokenTree::Punct(punct) if punct.as_char() == ';') {
            return true;
        }
        rest = next;
    }
    false
}

/// A name, where one must come next.
pub(crate) fn name(input: ParseStream) -> syn::Result<Ident> {
    if input.peek(Token![_]) {
        return Err(error(input, "`_` is no name; write `_z` for what nothing depends on"));
    }
    if input.peek(syn::Ident) || !input.peek(Ident::peek_any) {
        return input.parse();
    }
    let word = input.fork().call(Ident::parse_any)?;
    let raw = !["self", "Self", "super", "crate"].iter().any(|own| word == own);
    let advice =
        if raw { format!("write `r#{word}` or choose another name") } else { "choose another name".into() };
    Err(error(input, format!("`{word}` is a keyword of Rust; {advice}")))
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
