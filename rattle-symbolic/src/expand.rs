//! From a macro's input to the items it makes.

use crate::emit::Emitter;
use crate::graph::{Graph, Id, Input};
use crate::lower::{Expectation, lower};
use crate::parse::parse;
use crate::problems::Problems;
use crate::routine::{self, Routines};
use crate::syntax::{Item, Shape};
use proc_macro2::{Ident, Literal, TokenStream};
use quote::{format_ident, quote};

/// Which macro it is.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Macro {
    /// `constraint!`
    Constraint,
    /// `potential!`
    Potential,
    /// `pair_potential!`
    PairPotential,
}

/// The items for an input: always a struct that can be named, and an error for every mistake.
pub fn expand(which: Macro, input: TokenStream) -> TokenStream {
    let mut problems = Problems::default();
    let Some(item) = parse(input, &mut problems) else { return problems.report() };
    let mut graph = Graph::new();
    let roots = lower(&item, which.expectation(), &mut graph, &mut problems);
    which.check(&item, &mut problems);
    let sizes = Sizes { variables: item.variables.iter().map(|v| size(&v.shape)).sum(), roots: roots.len() };
    if problems.any() || roots.is_empty() {
        let stub = which.stub(&item, &sizes);
        let report = problems.report();
        return quote!(#stub #report);
    }
    let routines = which.routines(graph, &roots, sizes.variables as u32);
    let documentation = which.documentation(&routines);
    let structure = structure(&item, &documentation);
    let emitter = Emitter::new(&routines);
    let kernel = Kernel { item: &item, emitter: &emitter, routines: &routines, sizes: &sizes };
    let implementation = kernel.implementation(which);
    quote!(#structure #implementation)
}

/// How many coordinates and equations there are.
struct Sizes {
    variables: usize,
    roots: usize,
}

fn size(shape: &Shape) -> usize {
    shape.iter().product()
}

impl Macro {
    fn expectation(self) -> Expectation {
        match self {
            Macro::Constraint => Expectation { several: true, every_variable: true, noun: "this equation" },
            Macro::Potential => Expectation { several: false, every_variable: false, noun: "the potential" },
            Macro::PairPotential => {
                Expectation { several: false, every_variable: true, noun: "the potential" }
            }
        }
    }

    /// What holds for this macro beyond its expression.
    fn check(self, item: &Item, problems: &mut Problems) {
        if self == Macro::PairPotential
            && let [first, rest @ ..] = &item.variables[..]
        {
            let message = "a pair potential has one variable, the distance, as in `|r| depth / r`";
            if let Some(second) = rest.first() {
                problems.note_at(&second.name, message);
            } else if !first.shape.is_empty() {
                problems.note_at(&first.name, message);
            }
        }
    }

    fn routines(self, graph: Graph, roots: &[Id], variables: u32) -> Routines {
        match self {
            Macro::Constraint => routine::constraint(graph, roots, variables),
            Macro::Potential => routine::potential(graph, roots[0], variables),
            Macro::PairPotential => routine::pair(graph, roots[0]),
        }
    }

    fn documentation(self, routines: &Routines) -> Vec<String> {
        let counts: Vec<String> = routines
            .list
            .iter()
            .map(|routine| format!("`{}` {}", routine.name, routines.operations(&routine.roots)))
            .collect();
        vec![String::new(), format!("Operations per call: {}.", counts.join(", "))]
    }

    /// The struct, and functions that only satisfy the compiler, so that no second wave of errors follows.
    fn stub(self, item: &Item, sizes: &Sizes) -> TokenStream {
        let structure = structure(item, &[]);
        let sizes = Sizes {
            variables: if sizes.variables == 0 { 3 } else { sizes.variables },
            roots: sizes.roots.max(1),
        };
        let routines = Routines::empty();
        let emitter = Emitter::new(&routines);
        let kernel = Kernel { item, emitter: &emitter, routines: &routines, sizes: &sizes };
        let implementation = kernel.implementation(self);
        quote!(#structure #implementation)
    }
}

/// The user's struct.
fn structure(item: &Item, documentation: &[String]) -> TokenStream {
    let Item { attributes, visibility, name, .. } = item;
    let fields = item.parameters.iter().map(|parameter| {
        let (attributes, visibility, name) = (&parameter.attributes, &parameter.visibility, &parameter.name);
        let shape = array_type(&parameter.shape);
        let documented = attributes.clone().into_iter().any(|token| token.to_string().contains("doc"));
        let note = format!("The parameter `{name}`.");
        let note = if documented { TokenStream::new() } else { quote!(#[doc = #note]) };
        quote!(#attributes #note #visibility #name: #shape)
    });
    quote! {
        #attributes
        #(#[doc = #documentation])*
        #[derive(Clone, Copy, Debug, PartialEq)]
        #visibility struct #name { #(#fields),* }
    }
}

fn array_type(shape: &[usize]) -> TokenStream {
    match shape.split_first() {
        None => quote!(f64),
        Some((&length, inner)) => {
            let (inner, length) = (array_type(inner), Literal::usize_unsuffixed(length));
            quote!([#inner; #length])
        }
    }
}

/// The implementation of the kernel's trait.
struct Kernel<'a> {
    item: &'a Item,
    emitter: &'a Emitter<'a>,
    routines: &'a Routines,
    sizes: &'a Sizes,
}

impl Kernel<'_> {
    fn implementation(&self, which: Macro) -> TokenStream {
        let name = &self.item.name;
        let kernel = format_ident!("{}Kernel", name);
        let (d, m) = (self.sizes.variables, self.sizes.roots);
        let (d_size, m_size) = (Literal::usize_unsuffixed(d), Literal::usize_unsuffixed(m));
        let (owner, interface, functions) = match which {
            Macro::Constraint => {
                let g = self.array("value", 0, m);
                let jacobian = self.rows("jacobian", 0);
                let with_value = self.rows("value_and_jacobian", m);
                let with_value = {
                    let value = self.array("value_and_jacobian", 0, m);
                    quote!((#value, #with_value))
                };
                let products = self.rows("hessian_vector", 0);
                let jet: Vec<TokenStream> = (0..3).map(|i| self.array("jet", i * m, m)).collect();
                let (row, rows) = (quote!([T; #m_size]), quote!([[T; #d_size]; #m_size]));
                let functions = [
                    self.function("value", quote!((&self, q: &[T; #d_size]) -> #row), g),
                    self.function("jacobian", quote!((&self, q: &[T; #d_size]) -> #rows), jacobian),
                    self.function(
                        "value_and_jacobian",
                        quote!((&self, q: &[T; #d_size]) -> (#row, #rows)),
                        with_value,
                    ),
                    self.function(
                        "hessian_vector",
                        quote!((&self, q: &[T; #d_size], v: &[T; #d_size]) -> #rows),
                        products,
                    ),
                    self.function(
                        "jet",
                        quote!((&self, q: &[T; #d_size], v: &[T; #d_size]) -> (#row, #row, #row)),
                        quote!((#(#jet),*)),
                    ),
                ];
                (
                    quote!(Constraint<#d_size, #m_size>),
                    quote!(ConstraintKernel<T, #d_size, #m_size>),
                    quote!(#(#functions)*),
                )
            }
            Macro::Potential => {
                let value = self.single("value");
                let gradient = self.array("gradient", 0, d);
                let functions = [
                    self.function("value", quote!((&self, q: &[T; #d_size]) -> T), value),
                    self.function("gradient", quote!((&self, q: &[T; #d_size]) -> [T; #d_size]), gradient),
                ];
                (quote!(Potential<#d_size>), quote!(PotentialKernel<T, #d_size>), quote!(#(#functions)*))
            }
            Macro::PairPotential => {
                let functions = ["value", "slope"].map(|name| {
                    let result = self.single(name);
                    self.function(name, quote!((&self, s: T) -> T), result)
                });
                (quote!(PairPotential), quote!(PairKernel<T>), quote!(#(#functions)*))
            }
        };
        let declarations = self.emitter.declarations();
        let parameters = self.parameters();
        let construction = self.emitter.construction(&kernel, &|input| match input {
            Input::Parameter(k) => parameters.get(k as usize).cloned().unwrap_or_default(),
            _ => TokenStream::new(), // a kernel's fields depend on parameters only
        });
        let unused = if self.routines.list.is_empty() { quote!(let _ = self;) } else { TokenStream::new() };
        quote! {
            #[allow(clippy::all, clippy::pedantic, clippy::nursery, clippy::restriction)]
            #[allow(unused_variables, unreachable_pub, non_camel_case_types, missing_docs)]
            const _: () = {
                use ::rattle::real::Real;

                #[derive(Clone, Copy, Debug)]
                pub struct #kernel<T> { #declarations }

                #[automatically_derived]
                impl ::rattle::kernel::#owner for #name {
                    type Kernel<T: Real> = #kernel<T>;

                    #[inline(always)]
                    fn kernel<T: Real>(&self) -> #kernel<T> {
                        #unused
                        #construction
                    }
                }

                #[automatically_derived]
                impl<T: Real> ::rattle::kernel::#interface for #kernel<T> {
                    #functions
                }
            };
        }
    }

    /// Each component of the parameters, as the scalar.
    fn parameters(&self) -> Vec<TokenStream> {
        let mut list = Vec::new();
        for parameter in &self.item.parameters {
            let name = &parameter.name;
            components(quote!(self.#name), &parameter.shape, &mut list);
        }
        list.into_iter().map(|component| quote!(T::from_f64(#component))).collect()
    }

    fn function(&self, name: &str, signature: TokenStream, result: TokenStream) -> TokenStream {
        let statements = match self.routines.named(name) {
            Some(routine) => self.emitter.body(&routine.roots, &spelling(self.is_pair())),
            None => TokenStream::new(),
        };
        let name = Ident::new(name, proc_macro2::Span::call_site());
        quote! {
            #[inline(always)]
            fn #name #signature {
                #statements
                #result
            }
        }
    }

    fn is_pair(&self) -> bool {
        self.routines.named("slope").is_some()
    }

    fn result(&self, name: &str, i: usize) -> TokenStream {
        let root = self.routines.named(name).and_then(|routine| routine.roots.get(i));
        root.map_or(quote!(T::from_f64(0.0)), |&root| self.emitter.result(root))
    }

    fn single(&self, name: &str) -> TokenStream {
        self.result(name, 0)
    }

    fn array(&self, name: &str, start: usize, length: usize) -> TokenStream {
        let components = (start..start + length).map(|i| self.result(name, i));
        quote!([#(#components),*])
    }

    fn rows(&self, name: &str, start: usize) -> TokenStream {
        let d = self.sizes.variables;
        let rows = (0..self.sizes.roots).map(|i| self.array(name, start + i * d, d));
        quote!([#(#rows),*])
    }
}

fn components(path: TokenStream, shape: &[usize], list: &mut Vec<TokenStream>) {
    match shape.split_first() {
        None => list.push(path),
        Some((&length, inner)) => {
            for i in 0..length {
                let i = Literal::usize_unsuffixed(i);
                components(quote!(#path[#i]), inner, list);
            }
        }
    }
}

/// The inputs of a function as its arguments.
fn spelling(is_pair: bool) -> impl Fn(Input) -> TokenStream {
    move |input| match input {
        Input::Variable(_) if is_pair => quote!(s),
        Input::Variable(k) => component("q", k),
        Input::Direction(k) => component("v", k),
        Input::Weight(k) => component("weights", k),
        Input::Parameter(_) => TokenStream::new(), // always held by the kernel
    }
}

fn component(name: &str, k: u32) -> TokenStream {
    let (name, k) = (Ident::new(name, proc_macro2::Span::call_site()), Literal::u32_unsuffixed(k));
    quote!(#name[#k])
}
