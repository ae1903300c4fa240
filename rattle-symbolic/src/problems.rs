//! What is wrong with an input: collected at the exact tokens, reported all at once.

use proc_macro2::{Ident, Span, TokenStream};
use std::collections::{BTreeMap, HashMap};
use std::fmt::Display;

/// From which token to which token something is written.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Extent {
    /// Grows along the source, so that problems can be put in its order.
    serial: u32,
    start: Span,
    end: Span,
}

impl Extent {
    /// From the start of this to the end of that.
    pub(crate) fn to(self, end: Extent) -> Extent {
        Extent { end: end.end, ..self }
    }
}

/// So many problems are told of one place.
const FEW: usize = 3;

/// The problems found so far.
#[derive(Debug, Default)]
pub(crate) struct Problems {
    extents: u32,
    /// The extents of names by their addresses: looked up, never iterated.
    names: HashMap<usize, Extent>,
    found: BTreeMap<(u32, String), syn::Error>,
}

impl Problems {
    /// The extent of one token.
    pub(crate) fn extent(&mut self, span: Span) -> Extent {
        self.extents += 1;
        Extent { serial: self.extents, start: span, end: span }
    }
    /// The extent of a name in the syntax, the same in every round of a loop.
    pub(crate) fn extent_of(&mut self, name: &Ident) -> Extent {
        let address = std::ptr::from_ref(name) as usize;
        if let Some(&known) = self.names.get(&address) {
            return known;
        }
        let extent = self.extent(name.span());
        self.names.insert(address, extent);
        extent
    }
    /// Notes a problem; the same one at the same place (in every round of a loop) counts once, and of problems that
    /// differ from round to round the first few are told.
    pub(crate) fn note(&mut self, at: Extent, message: impl Display) {
        let here = (at.serial, String::new())..(at.serial + 1, String::new());
        if self.full() || self.found.range(here).count() >= FEW {
            return;
        }
        let tokens: TokenStream = [at.start, at.end]
            .map(|span| proc_macro2::TokenTree::from(Ident::new("here", span)))
            .into_iter()
            .collect();
        let message = message.to_string();
        let error = syn::Error::new_spanned(tokens, &message);
        self.found.entry((at.serial, message)).or_insert(error);
    }
    /// Notes a problem at an identifier.
    pub(crate) fn note_at(&mut self, ident: &Ident, message: impl Display) {
        let at = self.extent(ident.span());
        self.note(at, message);
    }
    /// Notes what the parser stumbled over.
    pub(crate) fn note_syntax(&mut self, error: syn::Error) {
        self.extents += 1;
        self.found.entry((self.extents, error.to_string())).or_insert(error);
    }
    /// Whether so much is wrong that nobody reads on.
    pub(crate) fn full(&self) -> bool {
        self.found.len() >= 100
    }
    /// Whether anything was found.
    pub(crate) fn any(&self) -> bool {
        !self.found.is_empty()
    }
    /// The tokens that make the compiler report everything.
    pub(crate) fn report(self) -> TokenStream {
        let all = self.found.into_values().reduce(|mut all, next| {
            all.combine(next);
            all
        });
        all.map(|all| all.to_compile_error()).unwrap_or_default()
    }
}

/// A text of the user's, for a message: of a long one the beginning.
pub(crate) fn shortened(text: &str) -> String {
    match text.char_indices().nth(24) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text.to_owned(),
    }
}

/// A number for a message: a large one with its exponent.
pub(crate) fn rounded(number: f64) -> String {
    if number.abs() < 1e16 { number.to_string() } else { format!("{number:e}") }
}

/// The candidate that `name` is most likely a slip of.
pub(crate) fn nearest<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let limit = match name.chars().count() {
        0..=2 => 1,
        3..=5 => 2,
        _ => 3,
    };
    candidates
        .into_iter()
        .map(|candidate| (distance(name, candidate), candidate))
        .filter(|&(distance, candidate)| {
            let longer = name.chars().count().max(candidate.chars().count());
            // Of few letters the first one is right, or all but one are.
            let begins = candidate.starts_with(|first| name.starts_with(first));
            distance <= limit && distance < longer && (distance < 2 || longer > 4 || begins)
        })
        .min_by_key(|&(distance, _)| distance)
        .map(|(_, candidate)| candidate)
}

/// Levenshtein's distance; none between upper and lower case.
fn distance(a: &str, b: &str) -> usize {
    if a.eq_ignore_ascii_case(b) {
        return 0;
    }
    let (a, b): (Vec<char>, Vec<char>) = (a.chars().collect(), b.chars().collect());
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.iter().enumerate() {
        let mut diagonal = i;
        row[0] = i + 1;
        for (j, y) in b.iter().enumerate() {
            let replaced = diagonal + usize::from(x != y);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn suggestions() {
        let rows = [
            ("rr", Some("r")),
            ("Sin", Some("sin")),
            ("radus", Some("radius")),
            ("q", None), // every letter is one step from every other
            ("α", None), // one letter, though two bytes
            ("elephant", None),
            ("sni", Some("sin")),
            ("foo", None),
            ("fin", Some("sin")),
        ];
        for (name, expected) in rows {
            assert_eq!(nearest(name, ["r", "sin", "radius", "x", "cos"]), expected, "{name}");
        }
    }
}
