//! The headings of `residual!`, taken out of its tokens: what is left is an item as the other macros have it.
//!
//! ```text
//! headings  (`given` `|` variables `|`  or  `eliminate` `(` names `)`)*      between the variables and the expression
//! result    expression (`linearise` expression)?                             made `[expression, expression]`
//! ```

use crate::problems::Problems;
use proc_macro2::{Delimiter, Group, Ident, Literal, Punct, Spacing, Span, TokenStream, TokenTree};
use std::fmt::Display;

/// The input with its headings taken out.
pub(crate) struct Headings {
    pub(crate) item: TokenStream,
    /// How many of the variables are unknowns; the others are given.
    pub(crate) unknowns: usize,
    pub(crate) eliminated: Vec<Ident>,
    /// The word, where components are followed by those that are differentiated in their stead.
    pub(crate) linearise: Option<Ident>,
    /// Whether it is not known where the expression begins or ends: the one of the item stands in for it.
    pub(crate) broken: bool,
}

struct Reader<'a> {
    tokens: &'a [TokenTree],
    next: usize,
    problems: &'a mut Problems,
    broken: bool,
}

/// Takes `given |…|`, `eliminate(…)` and `linearise …` out of the tokens.
pub(crate) fn headings(input: TokenStream, problems: &mut Problems) -> Headings {
    let tokens: Vec<TokenTree> = input.into_iter().collect();
    let mut reader = Reader { tokens: &tokens, next: 0, problems, broken: false };
    let mut eliminated = Vec::new();
    let Some((first, second)) = reader.bar(0).and_then(|first| Some((first, reader.bar(first + 1)?))) else {
        let item = tokens.into_iter().collect();
        return Headings { item, unknowns: usize::MAX, eliminated, linearise: None, broken: false };
    };
    let mut variables = tokens[first + 1..second].to_vec();
    let unknowns = variables.split(|token| is_punct(token, ',')).filter(|part| !part.is_empty()).count();
    reader.next = second + 1;
    while !reader.broken {
        if let Some(word) = reader.word("given") {
            reader.given(&word, &mut variables);
        } else if let Some(word) = reader.word("eliminate") {
            reader.eliminate(&word, &mut eliminated);
        } else {
            break;
        }
    }
    let (body, linearise) = if reader.broken { (nothing(), None) } else { reader.body() };
    let (body, broken) = if reader.broken { (nothing(), true) } else { (body, false) };
    let head = tokens[..=first].iter().chain(&variables).chain([&tokens[second]]).cloned();
    Headings { item: head.chain(body).collect(), unknowns, eliminated, linearise, broken }
}

/// An expression without mistakes.
fn nothing() -> TokenStream {
    TokenTree::Literal(Literal::u32_unsuffixed(0)).into()
}

impl Reader<'_> {
    fn bar(&self, from: usize) -> Option<usize> {
        (from..self.tokens.len()).find(|&i| is_punct(&self.tokens[i], '|'))
    }

    fn wrong(&mut self, at: Span, message: impl Display) {
        let at = self.problems.extent(at);
        self.problems.note(at, message);
    }

    /// As a mistake after which the expression cannot be found.
    fn lost(&mut self, at: Span, message: impl Display) {
        self.wrong(at, message);
        self.broken = true;
    }

    /// This word, unless it is the name of something: then an operator follows, or nothing.
    fn word(&mut self, name: &str) -> Option<Ident> {
        let word = ident(self.tokens.get(self.next)?, name)?;
        let heads = match self.tokens.get(self.next + 1)? {
            TokenTree::Punct(punct) => punct.as_char() == '|',
            _ => true,
        };
        heads.then(|| self.next += 1)?;
        Some(word)
    }

    fn given(&mut self, word: &Ident, variables: &mut Vec<TokenTree>) {
        let start = self.next;
        let open = self.tokens.get(start).filter(|token| is_punct(token, '|'));
        let (Some(open), Some(close)) = (open, self.bar(start + 1)) else {
            return self.lost(word.span(), "expected two bars after `given`, as in `given |c: [f64; 2]|`");
        };
        if close == start + 1 {
            self.wrong(open.span(), "there is nothing between these bars; leave `given` out");
        } else {
            if !variables.last().is_some_and(|token| is_punct(token, ',')) {
                variables.push(TokenTree::Punct(Punct::new(',', Spacing::Alone)));
            }
            variables.extend(self.tokens[start + 1..close].iter().cloned());
        }
        self.next = close + 1;
    }

    fn eliminate(&mut self, word: &Ident, eliminated: &mut Vec<Ident>) {
        const EXPECTED: &str = "expected names of unknowns in parentheses, as in `eliminate(p)`";
        let Some(TokenTree::Group(group)) =
            self.tokens.get(self.next).filter(|token| is_group(token, Delimiter::Parenthesis))
        else {
            return self.lost(word.span(), EXPECTED);
        };
        let names: Vec<TokenTree> = group.stream().into_iter().collect();
        if names.is_empty() {
            self.wrong(word.span(), EXPECTED);
        }
        let mut parts: Vec<&[TokenTree]> = names.split(|token| is_punct(token, ',')).collect();
        if parts.last().is_some_and(|last| last.is_empty()) {
            parts.pop();
        }
        for part in parts {
            match part {
                [TokenTree::Ident(name)] if eliminated.contains(name) => {
                    self.wrong(name.span(), format!("`{name}` stands here twice"));
                }
                [TokenTree::Ident(name)] => eliminated.push(name.clone()),
                [TokenTree::Ident(name), next, ..] => {
                    self.wrong(
                        next.span(),
                        format!("expected `,` or `)` after `{name}`; it goes as a whole"),
                    );
                }
                [first, ..] => self.wrong(first.span(), EXPECTED),
                [] => self.wrong(group.span_open(), EXPECTED),
            }
        }
        self.next += 1;
    }

    /// `{ lets; A linearise B }` as `{ lets; [A, B] }`, and `A linearise B` as `[A, B]`.
    fn body(&mut self) -> (TokenStream, Option<Ident>) {
        let tokens = &self.tokens[self.next..];
        if let [TokenTree::Group(group)] = tokens
            && group.delimiter() == Delimiter::Brace
        {
            let inner: Vec<TokenTree> = group.stream().into_iter().collect();
            let start = inner.iter().rposition(|token| is_punct(token, ';')).map_or(0, |last| last + 1);
            let (result, linearise) = self.both(&inner[start..]);
            let whole = inner[..start].iter().cloned().chain(result).collect();
            return (grouped(Delimiter::Brace, whole, group.span()), linearise);
        }
        self.both(tokens)
    }

    fn both(&mut self, tokens: &[TokenTree]) -> (TokenStream, Option<Ident>) {
        let collected = |tokens: &[TokenTree]| tokens.iter().cloned().collect::<TokenStream>();
        let parts: Vec<&[TokenTree]> = tokens.split(|token| linearise(token).is_some()).collect();
        let words: Vec<Ident> = tokens.iter().filter_map(linearise).collect();
        let Some(word) = words.first() else { return (collected(tokens), None) };
        if let Some(other) = words.iter().find(|word| *word == "linearize") {
            self.wrong(other.span(), "write `linearise`");
        }
        if let Some(second) = words.get(1) {
            self.lost(
                second.span(),
                "`linearise` stands once, between the residual and what is differentiated",
            );
        } else if parts.iter().any(|part| part.is_empty()) {
            let message =
                "expected the residual before `linearise`, and after it what is differentiated instead";
            self.lost(word.span(), message);
        }
        let mut comma = TokenTree::Punct(Punct::new(',', Spacing::Alone));
        comma.set_span(word.span());
        let pair = collected(parts[0]).into_iter().chain([comma]).chain(collected(parts[1])).collect();
        (grouped(Delimiter::Bracket, pair, word.span()), Some(word.clone()))
    }
}

fn grouped(delimiter: Delimiter, inside: TokenStream, span: Span) -> TokenStream {
    let mut group = Group::new(delimiter, inside);
    group.set_span(span);
    TokenTree::Group(group).into()
}

fn is_punct(token: &TokenTree, c: char) -> bool {
    matches!(token, TokenTree::Punct(punct) if punct.as_char() == c)
}

fn is_group(token: &TokenTree, delimiter: Delimiter) -> bool {
    matches!(token, TokenTree::Group(group) if group.delimiter() == delimiter)
}

fn ident(token: &TokenTree, name: &str) -> Option<Ident> {
    match token {
        TokenTree::Ident(ident) if ident == name => Some(ident.clone()),
        _ => None,
    }
}

fn linearise(token: &TokenTree) -> Option<Ident> {
    ident(token, "linearise").or_else(|| ident(token, "linearize"))
}
