//! What the parser gives: the expression as it is written.

use crate::problems::Extent;
use proc_macro2::{Ident, TokenStream, TokenTree};

/// A whole macro input.
#[derive(Debug)]
pub(crate) struct Item {
    pub(crate) attributes: TokenStream,
    /// Those of the attributes that may leave the struct out, and with it all that is made for it.
    pub(crate) conditions: TokenStream,
    pub(crate) visibility: TokenStream,
    pub(crate) name: Ident,
    pub(crate) parameters: Vec<Parameter>,
    pub(crate) variables: Vec<Variable>,
    pub(crate) body: Option<Expr>,
}

impl Item {
    /// Whether its struct or a parameter must not be used any more.
    pub(crate) fn is_deprecated(&self) -> bool {
        let parameters = self.parameters.iter().map(|parameter| &parameter.attributes);
        parameters.chain([&self.attributes]).any(|attributes| has_attribute(attributes, "deprecated"))
    }
}

/// Whether one of the attributes is `#[name …]`.
pub(crate) fn has_attribute(attributes: &TokenStream, name: &str) -> bool {
    any_attribute(attributes, |first, _| matches!(first, Some(TokenTree::Ident(own)) if *own == name))
}

/// Whether one of the attributes is documentation, `#[doc = …]`, and not `#[doc(alias = …)]` or `#[doc(hidden)]`.
pub(crate) fn is_documented(attributes: &TokenStream) -> bool {
    any_attribute(attributes, |first, second| {
        matches!(first, Some(TokenTree::Ident(own)) if *own == "doc")
            && matches!(second, Some(TokenTree::Punct(punct)) if punct.as_char() == '=')
    })
}

/// Whether one of the attributes has these tokens first.
fn any_attribute(
    attributes: &TokenStream,
    is: impl Fn(Option<&TokenTree>, Option<&TokenTree>) -> bool,
) -> bool {
    attributes.clone().into_iter().any(|token| {
        let TokenTree::Group(group) = token else { return false };
        let mut tokens = group.stream().into_iter();
        let (first, second) = (tokens.next(), tokens.next());
        is(first.as_ref(), second.as_ref())
    })
}

/// A field of the struct.
#[derive(Debug)]
pub(crate) struct Parameter {
    pub(crate) attributes: TokenStream,
    pub(crate) visibility: TokenStream,
    pub(crate) name: Ident,
    pub(crate) shape: Shape,
}

/// A name between the bars.
#[derive(Debug)]
pub(crate) struct Variable {
    pub(crate) name: Ident,
    pub(crate) shape: Shape,
}

/// The lengths of nested arrays, outermost first; none for a plain number.
pub(crate) type Shape = Vec<usize>;

/// The shape of what could not be read: no array has length 0.
pub(crate) const UNKNOWN: [usize; 1] = [0];

/// An expression and where it is written.
#[derive(Debug)]
pub(crate) struct Expr {
    pub(crate) kind: Kind,
    pub(crate) extent: Extent,
    /// Of the nesting, itself included.
    pub(crate) depth: u32,
}

#[derive(Debug)]
pub(crate) enum Kind {
    /// Something that could not be parsed, and is reported already.
    Wrong,
    /// A number, with its digits.
    Number(f64, String),
    Name(Ident),
    Negative(Box<Expr>),
    /// Operands of one precedence, combined from the left.
    Chain(Box<Expr>, Vec<(Operator, Expr)>),
    /// base ^ exponent
    Power(Box<Expr>, Box<Expr>),
    /// A function with its arguments; a method has its receiver as the first.
    Call(Ident, Vec<Expr>),
    /// `sum(k in 0..3, …)` and `product(…)`
    Fold(Operator, Vec<Binder>, Box<Expr>),
    Index(Box<Expr>, Box<Expr>),
    Block(Vec<Let>, Box<Expr>),
    If(Box<Expr>, Box<Expr>, Box<Expr>),
    /// `for i in 0..3 { … }`
    Family(Vec<Binder>, Box<Expr>),
    Array(Vec<Expr>),
}

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Operator {
    Add,
    Sub,
    Mul,
    Div,
    Less,
    LessOrEqual,
    Greater,
    GreaterOrEqual,
    /// Of indices only.
    Equal,
    NotEqual,
    And,
    Or,
}

impl Operator {
    pub(crate) fn symbol(self) -> &'static str {
        match self {
            Operator::Add => "+",
            Operator::Sub => "-",
            Operator::Mul => "*",
            Operator::Div => "/",
            Operator::Less => "<",
            Operator::LessOrEqual => "<=",
            Operator::Greater => ">",
            Operator::GreaterOrEqual => ">=",
            Operator::Equal => "==",
            Operator::NotEqual => "!=",
            Operator::And => "&&",
            Operator::Or => "||",
        }
    }
}

/// `let name = value;`
#[derive(Debug)]
pub(crate) struct Let {
    pub(crate) name: Ident,
    pub(crate) value: Expr,
}

/// `index in from..to`, with `to` itself where it is `..=`.
#[derive(Debug)]
pub(crate) struct Binder {
    pub(crate) index: Ident,
    pub(crate) from: Expr,
    pub(crate) to: Expr,
    pub(crate) inclusive: bool,
}
