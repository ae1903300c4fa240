//! The recurrences of power series, written for a function: one line per operation, which makes the next coefficient of
//! its result from those of its operands.
//!
//! ```text
//! let t12 = series.product(4, t3, t7);
//! ```
//!
//! What is linear is written as it is. Every other operation has products of its own, numbered in the order of the
//! lines, with factors whose lower coefficients are kept at run time (`rattle_core::kernel::series`). Numbers that stay
//! enter the coefficient 0 alone.

use crate::emit::{Emitter, Spelling, temporary};
use crate::functions::{Binary, Function};
use crate::graph::Graph;
use crate::node::{Comparison, Id, Node};
use proc_macro2::{Ident, Literal, Span, TokenStream};
use quote::quote;
use std::collections::BTreeSet;

/// Products in a block, as in `rattle_core::kernel::series`.
const WIDTH: usize = 8;

/// The series of a function, line by line.
pub(crate) struct Series {
    /// Blocks of products that it takes.
    pub(crate) blocks: usize,
    pub(crate) statements: TokenStream,
    /// The coefficients of its results.
    pub(crate) results: Vec<TokenStream>,
}

impl Series {
    /// The series of the roots.
    pub(crate) fn of(emitter: &Emitter, roots: &[Id], spelling: Spelling) -> Self {
        let graph = emitter.graph;
        let reachable = graph.reachable(roots);
        let mut writer = Writer { graph, reachable: &reachable, products: 0, lines: Vec::new() };
        let still = |id: &Id| !graph.moving(*id);
        let mut read: BTreeSet<Id> = roots.iter().copied().collect();
        for &id in reachable.iter().filter(|&&id| graph.moving(id)) {
            read.extend(graph.node(id).children());
        }
        let given = read.iter().copied().filter(still);
        let given: Vec<TokenStream> = given.map(|id| emitter.given(id, spelling, &quote!(self))).collect();
        for &id in reachable.iter().filter(|&&id| graph.moving(id)) {
            writer.line(id, spelling);
        }
        let Writer { products, lines, .. } = writer;
        let blocks = products.div_ceil(WIDTH);
        let results = roots.iter().map(|&root| coefficient(graph, root)).collect();
        let count = Literal::usize_unsuffixed(blocks);
        let statements = quote! {
            let __series = &mut __order.take(#count);
            #(#given)*
            #(#lines)*
        };
        Series { blocks, statements, results }
    }
}

/// An operand as a series, also where it stays.
fn coefficient(graph: &Graph, id: Id) -> TokenStream {
    let name = temporary(id);
    if graph.moving(id) { quote!(#name) } else { quote!(__series.constant(#name)) }
}

struct Writer<'a> {
    graph: &'a Graph,
    reachable: &'a [Id],
    /// Those taken so far.
    products: usize,
    lines: Vec<TokenStream>,
}

impl Writer<'_> {
    /// The numbers of the next products: one, or an array.
    fn take(&mut self, n: usize) -> TokenStream {
        let first = self.products;
        self.products += n;
        let numbers = (first..first + n).map(Literal::usize_unsuffixed);
        if n == 1 { quote!(#first) } else { quote!([#(#numbers),*]) }
    }

    fn line(&mut self, id: Id, spelling: Spelling) {
        let name = temporary(id);
        if let Node::Call(function, a) = *self.graph.node(id)
            && let Some((method, first, second)) = pair(function)
        {
            return self.both(id, a, method, [first, second]);
        }
        let operation = self.operation(id, spelling);
        self.lines.push(quote!(let #name = #operation;));
    }

    /// Two functions that are each other's slopes, of which one at least is needed: at the first.
    fn both(&mut self, id: Id, a: Id, method: &str, functions: [Function; 2]) {
        let ids = functions.map(|function| {
            let found = self.graph.find(&Node::Call(function, a));
            found.filter(|id| self.reachable.binary_search(id).is_ok())
        });
        if ids.iter().flatten().min() != Some(&id) {
            return;
        }
        let names = ids.map(|id| match id {
            Some(id) => {
                let name = temporary(id);
                quote!(#name)
            }
            None => quote!(_),
        });
        let [first, second] = names;
        let (a, at, method) =
            (temporary(a), self.take(functions[0].products()), Ident::new(method, Span::call_site()));
        self.lines.push(quote!(let (#first, #second) = __series.#method(#at, #a);));
    }

    fn operation(&mut self, id: Id, spelling: Spelling) -> TokenStream {
        let graph = self.graph;
        let moving = |id: Id| graph.moving(id);
        let t = temporary;
        let series = |id: Id| coefficient(graph, id);
        match *graph.node(id) {
            Node::Input(input) => spelling(input),
            Node::Neg(a) => {
                let a = t(a);
                quote!(-#a)
            }
            Node::Add(a, b) => {
                let (still, other) = if moving(a) { (b, a) } else { (a, b) };
                let (still_name, other) = (t(still), t(other));
                if moving(still) {
                    quote!(#other + #still_name)
                } else {
                    quote!(__series.shift(#other, #still_name))
                }
            }
            Node::Sub(a, b) => {
                let (a_name, b_name) = (t(a), t(b));
                match (moving(a), moving(b)) {
                    (true, true) => quote!(#a_name - #b_name),
                    (true, false) => quote!(__series.shift(#a_name, -#b_name)),
                    _ => quote!(__series.shift(-#b_name, #a_name)),
                }
            }
            Node::Mul(a, b) if moving(a) && moving(b) => {
                // The factor that is known later is the second.
                let (a, b) = if graph.depth(a) > graph.depth(b) { (b, a) } else { (a, b) };
                let (a, b, at) = (t(a), t(b), self.take(1));
                quote!(__series.product(#at, #a, #b))
            }
            Node::Mul(a, b) => {
                let (a, b) = (t(a), t(b));
                quote!(#a * #b)
            }
            Node::Div(a, b) if moving(b) => {
                let (a, b, at) = (series(a), t(b), self.take(1));
                quote!(__series.quotient(#at, #a, #b))
            }
            Node::Div(a, b) => {
                let (a, b) = (t(a), t(b));
                quote!(#a / #b)
            }
            Node::Power(a, 4) => {
                let (a, at) = (t(a), self.take(1));
                quote!(__series.square(#at, #a))
            }
            Node::Power(a, _) => {
                let (a, at) = (t(a), self.take(1)); // scheduling leaves the reciprocal as the only other power
                quote!(__series.reciprocal(#at, #a))
            }
            Node::Call(function, a) => {
                let (a, at) = (t(a), self.take(function.products()));
                let method = Ident::new(function.name(), Span::call_site());
                quote!(__series.#method(#at, #a))
            }
            Node::Call2(Binary::Powf, a, b) if moving(b) => {
                let (a, b, at) = (series(a), t(b), self.take(3));
                quote!(__series.power(#at, #a, #b))
            }
            Node::Call2(function, a, b) => {
                let name = t(b);
                let b = if function == Binary::Powf { quote!(#name) } else { series(b) };
                let (a, at) = (series(a), self.take(function.products()));
                let method = Ident::new(function.name(), Span::call_site());
                quote!(__series.#method(#at, #a, #b))
            }
            Node::Select(comparison, a, b, then, other) => {
                let method = match comparison {
                    Comparison::Less => quote!(select_lt),
                    Comparison::LessOrEqual => quote!(select_le),
                };
                let [a, b, then, other] = [a, b, then, other].map(series);
                let at = self.take(1);
                quote!(__series.#method(#at, #a, #b, #then, #other))
            }
            Node::Constant(_) => unreachable!("numbers stay"),
            Node::Sum(_) | Node::Product(_) => unreachable!("scheduling leaves binary operations only"),
        }
    }
}

/// Functions that come in pairs, and the method for both.
fn pair(function: Function) -> Option<(&'static str, Function, Function)> {
    match function {
        Function::Sin | Function::Cos => Some(("sin_cos", Function::Sin, Function::Cos)),
        Function::Sinh | Function::Cosh => Some(("sinh_cosh", Function::Sinh, Function::Cosh)),
        _ => None,
    }
}
