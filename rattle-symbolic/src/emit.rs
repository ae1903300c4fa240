//! Straight-line Rust from scheduled functions.
//!
//! ```text
//! let t12 = t3 * t7;
//! ```
//!
//! One `let` per operation and no loop, closure or variable index: compilers vectorise exactly that.
//! What depends on parameters alone becomes fields of the kernel, computed once.

use crate::functions::Function;
use crate::graph::{Comparison, Graph, Id, Input, Node};
use crate::routine::Routines;
use proc_macro2::{Ident, Literal, Span, TokenStream};
use quote::{format_ident, quote};
use std::collections::BTreeSet;

/// How the inputs of a function are spelled.
pub(crate) type Spelling<'a> = &'a dyn Fn(Input) -> TokenStream;

/// Statements per block, in functions of more than twice as many.
const CHAPTER: usize = 256;

pub(crate) struct Emitter<'a> {
    graph: &'a Graph,
    /// The nodes that the kernel holds, ascending.
    fields: Vec<Id>,
}

impl<'a> Emitter<'a> {
    pub(crate) fn new(routines: &'a Routines) -> Self {
        let graph = &routines.graph;
        let held = |id: &Id| !graph.moving(*id) && graph.as_constant(*id).is_none();
        let mut fields = BTreeSet::new();
        for routine in &routines.list {
            fields.extend(routine.roots.iter().copied().filter(held));
            for id in graph.reachable(&routine.roots) {
                if graph.moving(id) {
                    fields.extend(graph.node(id).children().into_iter().filter(held));
                }
            }
        }
        Emitter { graph, fields: fields.into_iter().collect() }
    }

    /// The declarations of the kernel's fields.
    pub(crate) fn declarations(&self) -> TokenStream {
        let names = (0..self.fields.len()).map(field);
        quote!(#(#names: T,)* scalar: ::core::marker::PhantomData<T>)
    }

    /// An expression that makes the kernel, as a block.
    pub(crate) fn construction(&self, kernel: &Ident, spelling: Spelling) -> TokenStream {
        let statements = self.lines(self.graph.reachable(&self.fields), &self.fields, spelling);
        let names = (0..self.fields.len()).map(field);
        let values = self.fields.iter().map(|&id| temporary(id));
        quote! {
            #statements
            #kernel { #(#names: #values,)* scalar: ::core::marker::PhantomData }
        }
    }

    /// The statements that compute the roots.
    pub(crate) fn body(&self, roots: &[Id], spelling: Spelling) -> TokenStream {
        let graph = self.graph;
        let reachable = graph.reachable(roots);
        let mut needed: BTreeSet<Id> = roots.iter().copied().collect();
        for &id in reachable.iter().filter(|&&id| graph.moving(id)) {
            needed.extend(graph.node(id).children());
        }
        let held = self.fields.iter().enumerate().filter(|(_, id)| needed.contains(id)).map(|(i, &id)| {
            let (name, field) = (temporary(id), field(i));
            quote!(let #name = self.#field;)
        });
        let held: TokenStream = held.collect();
        let lines = reachable
            .into_iter()
            .filter(|id| needed.contains(id) && (graph.moving(*id) || graph.as_constant(*id).is_some()))
            .collect();
        let lines = self.lines(lines, roots, spelling);
        quote!(#held #lines)
    }

    /// A root, after its statements.
    pub(crate) fn result(&self, root: Id) -> TokenStream {
        let name = temporary(root);
        quote!(#name)
    }

    fn lines(&self, ids: Vec<Id>, results: &[Id], spelling: Spelling) -> TokenStream {
        let present: BTreeSet<Id> = ids.iter().copied().collect();
        let other = |function, a| self.graph.find(&Node::Call(function, a)).filter(|id| present.contains(id));
        let mut statements: Vec<(Vec<Id>, TokenStream)> = Vec::with_capacity(ids.len());
        for &id in &ids {
            let pair = match *self.graph.node(id) {
                Node::Call(Function::Sin, a) => other(Function::Cos, a).map(|cosine| (a, id, cosine)),
                Node::Call(Function::Cos, a) => other(Function::Sin, a).map(|sine| (a, sine, id)),
                _ => None,
            };
            match pair {
                // The earlier of a sine and a cosine of one argument computes both.
                Some((a, sine, cosine)) if id == sine.min(cosine) => {
                    let [a, sine_name, cosine_name] = [a, sine, cosine].map(temporary);
                    let statement = quote!(let (#sine_name, #cosine_name) = #a.sin_cos(););
                    statements.push((vec![sine, cosine], statement));
                }
                Some(_) => {}
                None => {
                    let (name, operation) = (temporary(id), self.operation(id, spelling));
                    statements.push((vec![id], quote!(let #name = #operation;)));
                }
            }
        }
        if statements.len() <= 2 * CHAPTER {
            return statements.into_iter().map(|(_, statement)| statement).collect();
        }
        self.chapters(&statements, results)
    }

    /// Long functions in blocks that hand over what is needed later: compilers nest one scope per `let`.
    fn chapters(&self, statements: &[(Vec<Id>, TokenStream)], results: &[Id]) -> TokenStream {
        let chapters: Vec<&[(Vec<Id>, TokenStream)]> = statements.chunks(CHAPTER).collect();
        let mut needed: BTreeSet<Id> = results.iter().copied().collect();
        let mut texts = Vec::with_capacity(chapters.len());
        for chapter in chapters.into_iter().rev() {
            let defined: BTreeSet<Id> = chapter.iter().flat_map(|(ids, _)| ids.iter().copied()).collect();
            let handed: Vec<Ident> = defined.intersection(&needed).map(|&id| temporary(id)).collect();
            let lines = chapter.iter().map(|(_, statement)| statement);
            texts.push(quote!(let [#(#handed),*] = { #(#lines)* [#(#handed),*] };));
            for id in defined {
                needed.extend(self.graph.node(id).children());
            }
        }
        texts.into_iter().rev().collect()
    }

    fn operation(&self, id: Id, spelling: Spelling) -> TokenStream {
        let t = temporary;
        match *self.graph.node(id) {
            Node::Constant(bits) => {
                let number = number(f64::from_bits(bits));
                quote!(T::from_f64(#number))
            }
            Node::Input(input) => spelling(input),
            Node::Neg(a) => prefix(quote!(-), t(a)),
            Node::Add(a, b) => infix(t(a), quote!(+), t(b)),
            Node::Sub(a, b) => infix(t(a), quote!(-), t(b)),
            Node::Mul(a, b) => infix(t(a), quote!(*), t(b)),
            Node::Div(a, b) => infix(t(a), quote!(/), t(b)),
            Node::Power(a, 4) => infix(t(a), quote!(*), t(a)),
            Node::Power(a, _) => {
                let a = t(a); // scheduling leaves the reciprocal as the only other power
                quote!(T::from_f64(1.0) / #a)
            }
            Node::Call(function, a) => {
                let (a, method) = (t(a), Ident::new(function.name(), Span::call_site()));
                quote!(#a.#method())
            }
            Node::Call2(function, a, b) => {
                let (a, b, method) = (t(a), t(b), Ident::new(function.name(), Span::call_site()));
                quote!(#a.#method(#b))
            }
            Node::Select(comparison, a, b, then, other) => {
                let (a, b, then, other) = (t(a), t(b), t(then), t(other));
                let compare = match comparison {
                    Comparison::Less => quote!(lt),
                    Comparison::LessOrEqual => quote!(le),
                };
                quote!(T::select(T::#compare(#a, #b), #then, #other))
            }
            Node::Sum(_) | Node::Product(_) => unreachable!("scheduling leaves binary operations only"),
        }
    }
}

fn prefix(operator: TokenStream, a: Ident) -> TokenStream {
    quote!(#operator #a)
}

fn infix(a: Ident, operator: TokenStream, b: Ident) -> TokenStream {
    quote!(#a #operator #b)
}

fn temporary(id: Id) -> Ident {
    format_ident!("__t{}", id.0, span = Span::call_site()) // a user's constant `t0` would be a pattern
}

fn field(i: usize) -> Ident {
    format_ident!("p{i}", span = Span::call_site())
}

/// The literal; numbers in graphs are finite.
fn number(x: f64) -> TokenStream {
    let size = Literal::f64_suffixed(x.abs());
    if x.is_sign_negative() { quote!(-#size) } else { quote!(#size) }
}
