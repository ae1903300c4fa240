//! Tokens to syntax: expressions, by precedence climbing.
//!
//! ```text
//! loosest    ||     &&     < <= > >=     + -     * /     − (sign)     ^ (from the right)     .f() [i]    tightest
//! ```
//!
//! `-x^2` is −(x²), `x^-y^2` is x^(−(y²)), `2^3^2` is 2^(3²). Rust's own grammar cannot serve: there
//! `^` binds looser than `+`. Known slips (`**`, `2x`, `=`) are reported and read as what was meant,
//! so that the rest is still checked; anything else that cannot be read ends its own pair of
//! parentheses or its own `let`, not the whole expression.

use crate::functions::Function;
use crate::problems::{Extent, Problems};
use crate::syntax::{Binder, Expr, Kind, Let, Operator};
use crate::tokens::{self, drain, error, found, invisible, is_invisible, meaningless, starts_operand};
use proc_macro2::{Ident, Span};
use syn::ext::IdentExt;
use syn::parse::{ParseStream, Parser as _, Result};
use syn::{Lit, LitInt, Token, braced, bracketed, parenthesized, token};

/// Deeper nesting is an error, long before it could exhaust the stack.
const DEEPEST: u32 = 100;

pub(crate) struct Parser<'p> {
    pub(crate) problems: &'p mut Problems,
    depth: u32,
    /// Whether this is the condition of an `if`, where `==` compares indices.
    condition: bool,
    /// The operator before what is read next.
    before: Option<Span>,
}

/// How tightly an operator binds, from loosest.
fn precedence(operator: Operator) -> usize {
    match operator {
        Operator::Or => 0,
        Operator::And => 1,
        Operator::Less
        | Operator::LessOrEqual
        | Operator::Greater
        | Operator::GreaterOrEqual
        | Operator::Equal
        | Operator::NotEqual => COMPARISON,
        Operator::Add | Operator::Sub => SUM,
        Operator::Mul | Operator::Div => 4,
    }
}
const COMPARISON: usize = 2;
const SUM: usize = 3;

fn take(input: ParseStream, operator: Operator) -> Result<()> {
    match operator {
        Operator::Or => input.parse::<Token![||]>().map(drop),
        Operator::And => input.parse::<Token![&&]>().map(drop),
        Operator::LessOrEqual => input.parse::<Token![<=]>().map(drop),
        Operator::GreaterOrEqual => input.parse::<Token![>=]>().map(drop),
        Operator::Equal => input.parse::<Token![==]>().map(drop),
        Operator::NotEqual => input.parse::<Token![!=]>().map(drop),
        Operator::Less => input.parse::<Token![<]>().map(drop),
        Operator::Greater => input.parse::<Token![>]>().map(drop),
        Operator::Add => input.parse::<Token![+]>().map(drop),
        Operator::Sub => input.parse::<Token![-]>().map(drop),
        Operator::Mul => input.parse::<Token![*]>().map(drop),
        Operator::Div => input.parse::<Token![/]>().map(drop),
    }
}

impl<'p> Parser<'p> {
    pub(crate) fn new(problems: &'p mut Problems) -> Self {
        Parser { problems, depth: 0, condition: false, before: None }
    }

    /// The expression that the whole input is; problems inside it are noted, not returned.
    pub(crate) fn whole(&mut self, input: ParseStream) -> Option<Expr> {
        let start = self.problems.extent(input.span());
        match self.expression(input).and_then(|expr| self.finished(input).map(|()| expr)) {
            Ok(expr) => Some(expr),
            Err(error) => {
                self.before = None;
                self.problems.note_syntax(error);
                drain(input);
                Some(self.make(Kind::Wrong, start))
            }
        }
    }

    fn finished(&mut self, input: ParseStream) -> Result<()> {
        if input.is_empty() {
            return Ok(());
        }
        let message = if input.peek(Token![;]) {
            "unexpected `;`: only `let` ends with one, and only inside `{ }`".to_owned()
        } else if let Some(message) = meaningless(input).or_else(|| tokens::word_of_elsewhere(input)) {
            message
        } else if starts_operand(input) {
            "expected an operator before this; a product is written with `*`".to_owned()
        } else {
            format!("expected the end of the expression, found {}", found(input))
        };
        Err(error(input, message))
    }

    /// One level down.
    fn nested(
        &mut self,
        input: ParseStream,
        inside: impl FnOnce(&mut Self, ParseStream) -> Result<Expr>,
    ) -> Result<Expr> {
        self.depth += 1;
        let result = if self.depth > DEEPEST { Err(error(input, TOO_DEEP)) } else { inside(self, input) };
        self.depth -= 1;
        result
    }

    fn expression(&mut self, input: ParseStream) -> Result<Expr> {
        self.nested(input, |parser, input| {
            let left = parser.level(input, 0)?;
            parser.equation(input, left)
        })
    }

    /// `left = right` and `left == right` are slips for `left - right`.
    fn equation(&mut self, input: ParseStream, left: Expr) -> Result<Expr> {
        let (span, symbol) = if input.peek(Token![==]) {
            (input.parse::<Token![==]>()?.spans[0], "==")
        } else if input.peek(Token![!=]) {
            return Err(error(input, "`!=` is not a comparison of real numbers; use `<`, `<=`, `>` or `>=`"));
        } else if input.peek(Token![=]) {
            (input.parse::<Token![=]>()?.span, "=")
        } else {
            return Ok(left);
        };
        let at = self.problems.extent(span);
        self.problems.note(
            at,
            format!("found `{symbol}`, expected an expression; for a constraint `left = right` write `left - right`"),
        );
        let right = self.expression(input)?;
        let extent = left.extent.to(right.extent);
        Ok(self.make(Kind::Chain(Box::new(left), vec![(Operator::Sub, right)]), extent))
    }

    /// The binary operator that comes next.
    fn operator(&self, input: ParseStream) -> Option<Operator> {
        macro_rules! first {
            ($($token:tt $operator:ident),*) => {
                $(if input.peek(Token![$token]) { return Some(Operator::$operator); })*
            };
        }
        if is_invisible(input) || input.peek(Token![*]) && input.peek2(Token![*]) {
            return None; // an operand, or a slip for `^`
        }
        if self.condition && input.peek(Token![==]) {
            return Some(Operator::Equal);
        }
        if self.condition && input.peek(Token![!=]) {
            return Some(Operator::NotEqual);
        }
        first!(|| Or, && And, <= LessOrEqual, >= GreaterOrEqual, < Less, > Greater, + Add, - Sub, * Mul, / Div);
        None
    }

    /// An expression of operators that bind at least as tightly as `least`.
    fn level(&mut self, input: ParseStream, least: usize) -> Result<Expr> {
        let mut left = self.signed(input)?;
        while let Some(level) = self.operator(input).map(precedence).filter(|&level| level >= least) {
            let mut rest: Vec<(Operator, Expr)> = Vec::new();
            while let Some(operator) = self.operator(input).filter(|&operator| precedence(operator) == level)
            {
                if level == COMPARISON && !rest.is_empty() {
                    return Err(error(input, "comparisons do not chain; write `a < b && b < c`"));
                }
                self.before = Some(input.span());
                take(input, operator)?;
                rest.push((operator, self.level(input, level + 1)?));
            }
            if let Some((_, last)) = rest.last() {
                let extent = left.extent.to(last.extent);
                left = self.make(Kind::Chain(Box::new(left), rest), extent);
            }
        }
        Ok(left)
    }

    fn signed(&mut self, input: ParseStream) -> Result<Expr> {
        if is_invisible(input) || !input.peek(Token![-]) {
            return self.power(input);
        }
        let minus: Token![-] = input.parse()?;
        self.before = Some(minus.span);
        let start = self.problems.extent(minus.span);
        let inner = self.nested(input, Self::signed)?;
        let extent = start.to(inner.extent);
        Ok(self.make(Kind::Negative(Box::new(inner)), extent))
    }

    fn power(&mut self, input: ParseStream) -> Result<Expr> {
        let base = self.postfix(input)?;
        if input.peek(Token![*]) && input.peek2(Token![*]) {
            let first: Token![*] = input.parse()?;
            let second: Token![*] = input.parse()?;
            let at = self.problems.extent(first.span);
            let at = at.to(self.problems.extent(second.span));
            self.before = Some(second.span);
            self.problems.note(at, "found `**`, expected an operator; a power is written `x^2`");
        } else if input.peek(Token![^]) {
            self.before = Some(input.parse::<Token![^]>()?.span);
        } else {
            return Ok(base);
        }
        let exponent = self.nested(input, Self::signed)?;
        let extent = base.extent.to(exponent.extent);
        if matches!(&exponent.kind, Kind::Number(_, digits) if digits == "1")
            && let Some(below) = tokens::divisor(input)
        {
            let message = format!("`^` comes before `/`; a root is written `x^(1/{below})`");
            self.problems.note(exponent.extent, message);
        }
        Ok(self.make(Kind::Power(Box::new(base), Box::new(exponent)), extent))
    }

    fn postfix(&mut self, input: ParseStream) -> Result<Expr> {
        let mut expr = self.atom(input)?;
        loop {
            if input.peek(Token![.]) && !input.peek(Token![..]) {
                input.parse::<Token![.]>()?;
                if !input.peek(Ident::peek_any) {
                    let message = match input.fork().parse::<LitInt>() {
                        Ok(place) => format!("a component is written with brackets: `[{place}]`"),
                        Err(_) => "expected a function after the dot, as in `x.sin()`".to_owned(),
                    };
                    return Err(error(input, message));
                }
                let name = input.call(Ident::parse_any)?;
                if !input.peek(token::Paren) {
                    let of_self = matches!(&expr.kind, Kind::Name(owner) if owner == "self");
                    let message = if of_self {
                        format!("parameters are named directly: `{name}`")
                    } else {
                        format!("there are no fields here; call the function `{name}()` or index with `[0]`")
                    };
                    return Err(syn::Error::new_spanned(&name, message));
                }
                let (mut arguments, end) = self.arguments(input)?;
                let extent = expr.extent.to(end);
                arguments.insert(0, expr);
                expr = self.make(Kind::Call(name, arguments), extent);
            } else if input.peek(token::Bracket) {
                let inside;
                let bracket = bracketed!(inside in input);
                if let Some(separate) = tokens::separate_indices(&inside) {
                    let message = format!("each index has its own brackets; write `{separate}`");
                    self.problems.note_syntax(error(&inside, message));
                    drain(&inside);
                    return Ok(self.make(Kind::Wrong, expr.extent));
                }
                let index = self.group(&inside, bracket.span.close());
                let extent = expr.extent.to(self.problems.extent(bracket.span.close()));
                expr = self.make(Kind::Index(Box::new(expr), Box::new(index)), extent);
            } else {
                break;
            }
            if expr.depth > DEEPEST {
                return Err(error(input, TOO_DEEP));
            }
        }
        Ok(expr)
    }

    /// What stands alone between delimiters. What is wrong in there ends there.
    fn group(&mut self, inside: ParseStream, close: Span) -> Expr {
        if inside.is_empty() {
            let at = self.problems.extent(close);
            self.problems.note(at, "expected an expression between the brackets");
            return self.make(Kind::Wrong, at);
        }
        let start = self.problems.extent(close);
        self.whole(inside).unwrap_or_else(|| self.make(Kind::Wrong, start))
    }

    fn atom(&mut self, input: ParseStream) -> Result<Expr> {
        let behind = self.before.take();
        if let (Some(operator), true) = (behind, input.is_empty()) {
            return Err(syn::Error::new(operator, "expected an expression after this, found the end"));
        }
        let start = self.problems.extent(input.span());
        if let Some(inside) = invisible(input) {
            // A fragment of a `macro_rules!` macro is one operand, as it is in Rust.
            let parsed = (|input: ParseStream| Ok(self.whole(input))).parse2(inside);
            return Ok(parsed?.unwrap_or_else(|| self.make(Kind::Wrong, start)));
        }
        if input.peek(token::Paren) {
            let inside;
            let paren = parenthesized!(inside in input);
            let mut expr = self.group(&inside, paren.span.close());
            expr.extent = start.to(self.problems.extent(paren.span.close()));
            return Ok(expr);
        }
        if input.peek(token::Brace) {
            return self.block(input);
        }
        if input.peek(token::Bracket) {
            let inside;
            let bracket = bracketed!(inside in input);
            let elements = self.list(&inside)?;
            let extent = start.to(self.problems.extent(bracket.span.close()));
            return Ok(self.make(Kind::Array(elements), extent));
        }
        if input.peek(Token![if]) {
            return self.branch(input);
        }
        if input.peek(Token![for]) {
            return self.family(input);
        }
        if input.peek(Lit) {
            return self.number(input);
        }
        if !input.peek(Token![let])
            && !input.peek(Token![self])
            && let Some(message) = meaningless(input)
        {
            return Err(error(input, message));
        }
        if input.peek(Ident::peek_any) && !input.peek(Token![let]) {
            return self.name(input);
        }
        if behind.is_some() && input.peek(Token![=]) {
            return Err(error(input, "a name is set once; write `let` and another name"));
        }
        Err(error(input, tokens::no_operand(input)))
    }

    fn name(&mut self, input: ParseStream) -> Result<Expr> {
        let name = input.call(Ident::parse_any)?;
        let start = self.problems.extent(name.span());
        if input.peek(Token![::]) {
            let message = "there are no paths here; functions and constants are called by name, as in `sin(x)` and `pi`";
            return Err(syn::Error::new_spanned(&name, message));
        }
        if input.peek(Token![!]) && !input.peek(Token![!=]) {
            return self.foreign(&name, start, input);
        }
        if Function::named(&name.to_string()).is_some() && tokens::power_of_function(input) {
            let message = format!("a power of `{name}` is written `{name}(x)^2`");
            return Err(syn::Error::new_spanned(&name, message));
        }
        if !input.peek(token::Paren) {
            return match starts_operand(input) && Function::named(&name.to_string()).is_some() {
                true => self.bare_call(name, start, input),
                false => Ok(self.make(Kind::Name(name), start)),
            };
        }
        if name == "sum" || name == "product" {
            return self.fold(name, start, input);
        }
        let (arguments, end) = self.arguments(input)?;
        Ok(self.make(Kind::Call(name, arguments), start.to(end)))
    }

    /// `name!(…)`, of which nobody knows what it stands for.
    fn foreign(&mut self, name: &Ident, start: Extent, input: ParseStream) -> Result<Expr> {
        let bang: Token![!] = input.parse()?;
        let extent = start.to(self.problems.extent(bang.span));
        let advice = "write what it stands for, or make it a parameter";
        self.problems
            .note(extent, format!("`{name}!` is a macro, and none is expanded in a formula; {advice}"));
        if input.cursor().any_group().is_some() {
            input.parse::<proc_macro2::TokenTree>()?;
        }
        Ok(self.make(Kind::Wrong, extent))
    }

    /// `sqrt x` is a slip for `sqrt(x)`.
    fn bare_call(&mut self, name: Ident, start: Extent, input: ParseStream) -> Result<Expr> {
        let next = found(input).replace('`', "");
        let next = if Function::named(&next).is_some() { "…" } else { &next };
        self.problems
            .note(start, format!("`{name}` needs its argument in parentheses; write `{name}({next})`"));
        let argument = self.nested(input, Self::postfix)?;
        let extent = start.to(argument.extent);
        Ok(self.make(Kind::Call(name, vec![argument]), extent))
    }

    fn arguments(&mut self, input: ParseStream) -> Result<(Vec<Expr>, Extent)> {
        let inside;
        let paren = parenthesized!(inside in input);
        let arguments = self.list(&inside)?;
        Ok((arguments, self.problems.extent(paren.span.close())))
    }

    fn list(&mut self, inside: ParseStream) -> Result<Vec<Expr>> {
        let mut list = Vec::new();
        while !inside.is_empty() {
            list.push(self.expression(inside)?);
            if inside.peek(Token![,]) {
                inside.parse::<Token![,]>()?;
            } else {
                self.finished(inside)?;
            }
        }
        Ok(list)
    }

    fn fold(&mut self, name: Ident, start: Extent, input: ParseStream) -> Result<Expr> {
        let operator = if name == "sum" { Operator::Add } else { Operator::Mul };
        let inside;
        let paren = parenthesized!(inside in input);
        let binders = self.binders(&inside)?;
        if binders.is_empty() {
            let message = format!("expected an index, as in `{name}(k in 0..3, a[k])`");
            return Err(syn::Error::new_spanned(&name, message));
        }
        let body = self.group(&inside, paren.span.close());
        let extent = start.to(self.problems.extent(paren.span.close()));
        Ok(self.make(Kind::Fold(operator, binders, Box::new(body)), extent))
    }

    /// `i in 0..3, j in i..3` with a comma after each, but for one before a block.
    fn binders(&mut self, input: ParseStream) -> Result<Vec<Binder>> {
        let mut list = Vec::new();
        while input.peek(syn::Ident) && input.peek2(Token![in]) {
            let index: Ident = input.parse()?;
            input.parse::<Token![in]>()?;
            let from = self.level(input, SUM)?;
            if !input.peek(Token![..]) {
                return Err(error(input, "expected a range of whole numbers, as in `0..3`"));
            }
            let inclusive = input.peek(Token![..=]);
            if inclusive {
                input.parse::<Token![..=]>()?;
            } else {
                input.parse::<Token![..]>()?;
            }
            let to = self.level(input, SUM)?;
            list.push(Binder { index, from, to, inclusive });
            if input.peek(Token![,]) {
                input.parse::<Token![,]>()?;
            } else if !input.peek(token::Brace) {
                return Err(error(input, "expected `,` after the range"));
            }
        }
        Ok(list)
    }

    fn family(&mut self, input: ParseStream) -> Result<Expr> {
        let keyword: Token![for] = input.parse()?;
        let start = self.problems.extent(keyword.span);
        let binders = self.binders(input)?;
        if binders.is_empty() || !input.peek(token::Brace) {
            return Err(error(input, "expected an index and a block, as in `for i in 0..3 { … }`"));
        }
        let body = self.block(input)?;
        let extent = start.to(body.extent);
        Ok(self.make(Kind::Family(binders, Box::new(body)), extent))
    }

    fn branch(&mut self, input: ParseStream) -> Result<Expr> {
        self.nested(input, Self::branch_inside)
    }

    fn branch_inside(&mut self, input: ParseStream) -> Result<Expr> {
        let keyword: Token![if] = input.parse()?;
        let start = self.problems.extent(keyword.span);
        let outside = std::mem::replace(&mut self.condition, true);
        let condition = self.level(input, 0);
        self.condition = outside;
        let condition = condition?;
        if !input.peek(token::Brace) {
            let message = meaningless(input).or_else(|| tokens::word_of_elsewhere(input));
            return Err(error(
                input,
                message.unwrap_or_else(|| "expected `{` after the condition".to_owned()),
            ));
        }
        let then = self.block(input)?;
        if let (false, Some(message)) = (input.peek(Token![else]), tokens::word_of_elsewhere(input)) {
            return Err(error(input, message));
        }
        if !input.peek(Token![else]) {
            let message =
                "this `if` has no `else`, so no value when the condition is false; add `else { … }`";
            return Err(syn::Error::new(keyword.span, message));
        }
        input.parse::<Token![else]>()?;
        let other = if input.peek(Token![if]) {
            self.branch(input)?
        } else if input.peek(token::Brace) {
            self.block(input)?
        } else {
            return Err(error(input, "expected `{` after `else`"));
        };
        let extent = start.to(other.extent);
        Ok(self.make(Kind::If(Box::new(condition), Box::new(then), Box::new(other)), extent))
    }

    fn block(&mut self, input: ParseStream) -> Result<Expr> {
        let inside;
        let brace = braced!(inside in input);
        let start = self.problems.extent(brace.span.open());
        let end = self.problems.extent(brace.span.close());
        let outside = std::mem::replace(&mut self.condition, false);
        let mut lets = Vec::new();
        while inside.peek(Token![let]) || tokens::lets(&inside) {
            if let Some(binding) = self.binding(&inside) {
                lets.push(binding);
            }
        }
        let result = if inside.is_empty() {
            self.problems.note(end, "the block ends without an expression; its last line is its value");
            self.make(Kind::Wrong, end)
        } else {
            self.whole(&inside).unwrap_or_else(|| self.make(Kind::Wrong, end))
        };
        self.condition = outside;
        Ok(self.make(Kind::Block(lets, Box::new(result)), start.to(end)))
    }

    /// `let name = value;`. A bad one is noted and skipped.
    fn binding(&mut self, input: ParseStream) -> Option<Let> {
        let mut name = None;
        let value = self.binding_value(input, &mut name);
        match value {
            Ok(value) => Some(Let { name: name?, value }),
            Err(error) => {
                self.problems.note_syntax(error);
                let at = self.problems.extent(input.span());
                while !input.is_empty() && !input.peek(Token![;]) {
                    let _ = input.parse::<proc_macro2::TokenTree>();
                }
                let _ = input.parse::<Option<Token![;]>>();
                Some(Let { name: name?, value: self.make(Kind::Wrong, at) })
            }
        }
    }

    fn binding_value(&mut self, input: ParseStream, name: &mut Option<Ident>) -> Result<Expr> {
        if input.parse::<Option<Token![let]>>()?.is_none() {
            let name: Ident = input.fork().parse()?;
            let message = format!("`let` is missing; write `let {name} = …;`");
            self.problems.note_syntax(error(input, message));
        }
        if input.peek(Token![mut]) {
            return Err(error(input, "`mut` has no meaning in a formula; leave it out"));
        }
        if !input.peek(Ident::peek_any) && !input.peek(Token![_]) {
            return Err(error(input, "expected a name after `let`"));
        }
        *name = Some(tokens::name(input)?);
        if input.peek(Token![:]) {
            return Err(error(input, "`let` takes no type here; write `let a = …;`"));
        }
        if !input.peek(Token![=]) || input.peek(Token![==]) {
            return Err(error(input, "expected `=` after the name"));
        }
        input.parse::<Token![=]>()?;
        let value = self.expression(input)?;
        if !input.peek(Token![;]) {
            let message = if starts_operand(input) {
                "expected an operator, or `;` at the end of the `let`"
            } else {
                "expected `;` at the end of the `let`"
            };
            return Err(error(input, meaningless(input).unwrap_or_else(|| message.to_owned())));
        }
        input.parse::<Token![;]>()?;
        Ok(value)
    }

    pub(crate) fn make(&mut self, kind: Kind, extent: Extent) -> Expr {
        let below = |list: &[Expr]| list.iter().map(|expr| expr.depth).max().unwrap_or(0);
        let depth = match &kind {
            Kind::Wrong | Kind::Number(..) | Kind::Name(_) => 0,
            Kind::Negative(inner) | Kind::Family(_, inner) | Kind::Fold(_, _, inner) => inner.depth,
            Kind::Chain(first, rest) => {
                rest.iter().map(|(_, expr)| expr.depth).max().unwrap_or(0).max(first.depth)
            }
            Kind::Power(a, b) | Kind::Index(a, b) => a.depth.max(b.depth),
            Kind::Call(_, list) | Kind::Array(list) => below(list),
            Kind::Block(lets, result) => {
                lets.iter().map(|binding| binding.value.depth).max().unwrap_or(0).max(result.depth)
            }
            Kind::If(a, b, c) => a.depth.max(b.depth).max(c.depth),
        };
        Expr { kind, extent, depth: depth + 1 }
    }
}

const TOO_DEEP: &str = "nested too deeply; give the inner part a name with `let`";
