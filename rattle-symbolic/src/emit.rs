//! Straight-line Rust from scheduled functions.
//!
//! ```text
//! let t12 = t3 * t7;
//! ```
//!
//! One `let` per operation and no loop, closure or variable index: compilers vectorise exactly that.
//! What depends on parameters alone becomes fields of the kernel, computed once.
//!
//! A product that is added to something is written as `x.multiply_add(y, z)`, for scalars that round x·y + z once.
//! Which product that is depends on the sum alone, so that functions with common parts agree bit for bit.

use crate::functions::Function;
use crate::graph::{Graph, found_from};
use crate::node::{Comparison, Id, Input, Node};
use crate::routine::Routines;
use proc_macro2::{Ident, Literal, Span, TokenStream};
use quote::{ToTokens, format_ident, quote};
use std::collections::{BTreeMap, BTreeSet};

/// How the inputs of a function are spelled.
pub(crate) type Spelling<'a> = &'a dyn Fn(Input) -> TokenStream;

/// Statements per block, in functions of more than twice as many.
const CHAPTER: usize = 256;

/// Where the blocks of a function that is not inlined stand: each a function of its own.
pub(crate) struct Frame<'a> {
    /// The kernel's type.
    pub(crate) kernel: &'a Ident,
    /// The names and types of the arguments, all by reference.
    pub(crate) arguments: &'a [(Ident, TokenStream)],
}

/// ± x·y ± z.
struct Contraction {
    factors: [Id; 2],
    minus_product: bool,
    addend: Id,
    minus_addend: bool,
}

impl Contraction {
    fn of(factors: [Id; 2], minus_product: bool, addend: Id, minus_addend: bool) -> Self {
        Self { factors, minus_product, addend, minus_addend }
    }
}

pub(crate) struct Emitter<'a> {
    pub(crate) graph: &'a Graph,
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

    /// The kernel's fields, each the function of that of another kernel.
    pub(crate) fn mapped(&self, function: &TokenStream, other: &TokenStream) -> TokenStream {
        let names = (0..self.fields.len()).map(field);
        let fields = names.map(|name| quote!(#name: #function(&#other.#name),));
        quote!(#(#fields)* scalar: ::core::marker::PhantomData)
    }

    /// The statements that compute the roots; in chapters where there is a frame for them.
    pub(crate) fn body(&self, roots: &[Id], spelling: Spelling, frame: Option<&Frame>) -> TokenStream {
        let graph = self.graph;
        let reachable = self.reachable(roots);
        let mut needed: BTreeSet<Id> = roots.iter().copied().collect();
        for &id in reachable.iter().filter(|&&id| graph.moving(id)) {
            needed.extend(self.operands(id));
        }
        if let Some(frame) = frame {
            let own = |id: &Id| graph.moving(*id) && !matches!(graph.node(*id), Node::Input(_));
            let statements = self.statements(reachable.into_iter().filter(own).collect(), spelling);
            return self.chapters(&statements, roots, spelling, frame);
        }
        let held = self.fields.iter().copied().filter(|id| needed.contains(id));
        let held: TokenStream = held.map(|id| self.given(id, spelling, &quote!(self))).collect();
        let lines = reachable
            .into_iter()
            .filter(|id| needed.contains(id) && (graph.moving(*id) || graph.as_constant(*id).is_some()))
            .collect();
        let lines = self.lines(lines, roots, spelling);
        quote!(#held #lines)
    }

    /// The sum of a product and something else that this node is, if it is one; of two products, the one that is known
    /// last.
    fn contraction(&self, id: Id) -> Option<Contraction> {
        let (a, b, minus) = match *self.graph.node(id) {
            Node::Add(a, b) => (a, b, false),
            Node::Sub(a, b) => (a, b, true),
            _ => return None,
        };
        let factors = |id: Id| match *self.graph.node(id) {
            Node::Mul(x, y) if self.graph.moving(id) => Some([x, y]),
            Node::Power(x, 4) if self.graph.moving(id) => Some([x, x]),
            _ => None,
        };
        let of_a = || factors(a).map(|factors| Contraction::of(factors, false, b, minus));
        let of_b = || factors(b).map(|factors| Contraction::of(factors, minus, a, false));
        if self.graph.depth(a) > self.graph.depth(b) { of_a().or_else(of_b) } else { of_b().or_else(of_a) }
    }

    /// The nodes that this one is computed from as it is written here.
    fn operands(&self, id: Id) -> Vec<Id> {
        match self.contraction(id) {
            Some(Contraction { factors: [x, y], addend, .. }) => vec![x, y, addend],
            None => self.graph.node(id).children(),
        }
    }

    /// The nodes that the roots need, ascending.
    fn reachable(&self, roots: &[Id]) -> Vec<Id> {
        found_from(roots.iter().copied(), |id| self.operands(id))
    }

    /// A root, after its statements.
    pub(crate) fn result(&self, root: Id) -> TokenStream {
        let name = temporary(root);
        quote!(#name)
    }

    /// The statement for what costs nothing to have: fields, constants and inputs.
    pub(crate) fn given(&self, id: Id, spelling: Spelling, owner: &TokenStream) -> TokenStream {
        let name = temporary(id);
        match self.fields.binary_search(&id) {
            Ok(place) => {
                let field = field(place);
                quote!(let #name = #owner.#field;)
            }
            Err(_) => {
                let operation = self.operation(id, spelling);
                quote!(let #name = #operation;)
            }
        }
    }

    /// One `let` per operation, with the nodes that it computes.
    fn statements(&self, ids: Vec<Id>, spelling: Spelling) -> Vec<(Vec<Id>, TokenStream)> {
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
        statements
    }

    fn lines(&self, ids: Vec<Id>, results: &[Id], spelling: Spelling) -> TokenStream {
        let statements = self.statements(ids, spelling);
        if statements.len() <= 2 * CHAPTER {
            return statements.into_iter().map(|(_, statement)| statement).collect();
        }
        self.blocks(&statements, results)
    }

    /// Long functions in blocks that hand over what is needed later: compilers nest one scope per `let`.
    fn blocks(&self, statements: &[(Vec<Id>, TokenStream)], results: &[Id]) -> TokenStream {
        let blocks: Vec<&[(Vec<Id>, TokenStream)]> = statements.chunks(CHAPTER).collect();
        let mut needed: BTreeSet<Id> = results.iter().copied().collect();
        let mut texts = Vec::with_capacity(blocks.len());
        for block in blocks.into_iter().rev() {
            let defined: BTreeSet<Id> = block.iter().flat_map(|(ids, _)| ids.iter().copied()).collect();
            let handed: Vec<Ident> = defined.intersection(&needed).map(|&id| temporary(id)).collect();
            let lines = block.iter().map(|(_, statement)| statement);
            texts.push(quote!(let [#(#handed),*] = { #(#lines)* [#(#handed),*] };));
            for id in defined {
                needed.extend(self.operands(id));
            }
        }
        texts.into_iter().rev().collect()
    }

    /// Very long functions as functions that leave what is needed later in `__memory`: the compiler's time
    /// grows faster than the length of a function.
    fn chapters(
        &self,
        statements: &[(Vec<Id>, TokenStream)],
        results: &[Id],
        spelling: Spelling,
        frame: &Frame,
    ) -> TokenStream {
        let chapters: Vec<&[(Vec<Id>, TokenStream)]> = statements.chunks(CHAPTER).collect();
        // By chapter: what it computes and what it reads; and which chapter is the last to read something.
        let mut last: BTreeMap<Id, usize> = BTreeMap::new();
        let mut plan = Vec::with_capacity(chapters.len());
        for (place, chapter) in chapters.iter().enumerate() {
            let defined: BTreeSet<Id> = chapter.iter().flat_map(|(ids, _)| ids.iter().copied()).collect();
            let operands = defined.iter().flat_map(|&id| self.operands(id));
            let read: BTreeSet<Id> = operands.filter(|id| !defined.contains(id)).collect();
            last.extend(read.iter().map(|&id| (id, place)));
            plan.push((defined, read));
        }
        last.extend(results.iter().map(|&id| (id, usize::MAX)));
        let Frame { kernel, arguments } = frame;
        let (names, types): (Vec<_>, Vec<_>) = arguments.iter().map(|(name, form)| (name, form)).unzip();
        let mut slots: BTreeMap<Id, usize> = BTreeMap::new();
        let mut free: BTreeSet<usize> = BTreeSet::new();
        let mut texts = Vec::with_capacity(chapters.len());
        for (place, (chapter, (defined, read))) in chapters.into_iter().zip(plan).enumerate() {
            let read_later = |id: &Id| last.get(id).is_some_and(|&last| last > place);
            let given = read.iter().map(|&id| match slots.get(&id) {
                Some(&slot) => load(id, slot),
                None => self.given(id, spelling, &quote!(__kernel)),
            });
            let given: Vec<TokenStream> = given.collect();
            let finished = read.iter().filter(|id| !read_later(id));
            free.extend(finished.filter_map(|id| slots.remove(id)));
            let mut stores = Vec::new();
            for &id in defined.iter().filter(|id| read_later(id)) {
                let slot = free.pop_first().unwrap_or(slots.len());
                slots.insert(id, slot);
                let (name, slot) = (temporary(id), Literal::usize_unsuffixed(slot));
                stores.push(quote!(__memory[#slot] = #name;));
            }
            let lines = chapter.iter().map(|(_, statement)| statement);
            texts.push(quote!(#(#given)* #(#lines)* #(#stores)*));
        }
        let size = Literal::usize_unsuffixed(slots.len() + free.len());
        let texts = texts.iter().map(|text| {
            quote! {{
                #[inline(never)]
                fn chapter<T: ::rattle::real::Real>(
                    __kernel: &#kernel<T>, #(#names: #types,)* __memory: &mut [T; #size],
                ) { #text }
                chapter(self, #(#names,)* &mut __memory);
            }}
        });
        let found: BTreeSet<Id> = results.iter().copied().collect();
        let results = found.iter().map(|&id| match slots.get(&id) {
            Some(&slot) => load(id, slot),
            None => self.given(id, spelling, &quote!(self)),
        });
        quote! {
            let mut __memory = [T::from_f64(0.0); #size];
            #(#texts)*
            #(#results)*
        }
    }

    fn operation(&self, id: Id, spelling: Spelling) -> TokenStream {
        let t = temporary;
        if let Some(Contraction { factors: [x, y], minus_product, addend, minus_addend }) =
            self.contraction(id)
        {
            let (x, y, addend) = (t(x), t(y), t(addend));
            let x = if minus_product { quote!((-#x)) } else { quote!(#x) };
            let addend = if minus_addend { quote!(-#addend) } else { quote!(#addend) };
            return quote!(#x.multiply_add(#y, #addend));
        }
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

fn load(id: Id, slot: usize) -> TokenStream {
    let (name, slot) = (temporary(id), Literal::usize_unsuffixed(slot));
    quote!(let #name = __memory[#slot];)
}

fn prefix(operator: TokenStream, a: Ident) -> TokenStream {
    quote!(#operator #a)
}

fn infix(a: Ident, operator: TokenStream, b: Ident) -> TokenStream {
    quote!(#a #operator #b)
}

pub(crate) fn temporary(id: Id) -> Ident {
    format_ident!("__t{}", id.0, span = Span::call_site()) // a user's constant `t0` would be a pattern
}

fn field(i: usize) -> Ident {
    format_ident!("p{i}", span = Span::call_site())
}

/// The literal; numbers in graphs are finite, but for those of derivatives, which may be none or overflow.
fn number(x: f64) -> TokenStream {
    if x.is_nan() {
        return quote!(::core::primitive::f64::NAN);
    }
    let size = match x.is_finite() {
        true => Literal::f64_suffixed(x.abs()).into_token_stream(),
        false => quote!(::core::primitive::f64::INFINITY),
    };
    if x.is_sign_negative() { quote!(-#size) } else { quote!(#size) }
}
