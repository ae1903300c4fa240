//! From a macro's input to the items it makes.

use crate::emit::{Emitter, Frame};
use crate::formula::{self, Names};
use crate::graph::{Graph, Id, Input};
use crate::interface::Method;
use crate::lower::{Expectation, Lowered, lower};
use crate::parse::parse;
use crate::problems::Problems;
use crate::recurrence::Series;
use crate::routine::{self, Routines};
use crate::syntax::{Item, Parameter, Shape};
use proc_macro2::{Ident, Literal, TokenStream, TokenTree};
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
    /// `hamiltonian!`
    Hamiltonian,
    /// `phase_constraint!`
    PhaseConstraint,
}

/// The items for an input: always a struct that can be named, and an error for every mistake.
pub fn expand(which: Macro, input: TokenStream) -> TokenStream {
    let mut problems = Problems::default();
    let Some(item) = parse(input, &mut problems) else { return problems.report() };
    let mut graph = Graph::new();
    let Lowered { roots, named } = lower(&item, which.expectation(), &mut graph, &mut problems);
    which.check(&item, &mut problems);
    let sizes = Sizes { variables: item.variables.iter().map(|v| size(&v.shape)).sum(), roots: roots.len() };
    if problems.any() || roots.is_empty() {
        let stub = which.stub(&item, &sizes);
        let report = problems.report();
        return quote!(#stub #report);
    }
    let routines = which.routines(graph, &roots, sizes.variables as u32);
    let documentation = which.documentation(&item, &routines, named);
    let structure = structure(&item, &documentation);
    let emitter = Emitter::new(&routines);
    let kernel = Kernel { item: &item, emitter: &emitter, routines: &routines, sizes: &sizes };
    let implementation = kernel.implementation(which);
    quote!(#structure #implementation)
}

/// How many coordinates and equations there are.
pub(crate) struct Sizes {
    pub(crate) variables: usize,
    pub(crate) roots: usize,
}

fn size(shape: &Shape) -> usize {
    shape.iter().product()
}

impl Macro {
    fn expectation(self) -> Expectation {
        let equations = Expectation { several: true, every_variable: true, noun: "this equation" };
        let energy = |noun| Expectation { several: false, every_variable: false, noun };
        match self {
            Macro::Constraint | Macro::PhaseConstraint => equations,
            Macro::Potential => energy("the potential"),
            Macro::Hamiltonian => energy("the Hamiltonian"),
            Macro::PairPotential => Expectation { every_variable: true, ..energy("the potential") },
        }
    }

    /// What holds for this macro beyond its expression.
    fn check(self, item: &Item, problems: &mut Problems) {
        match (self, &item.variables[..]) {
            (Macro::PairPotential, [first, rest @ ..]) => {
                let message = "a pair potential has one variable, the distance, as in `|r| depth / r`";
                if let Some(second) = rest.first() {
                    problems.note_at(&second.name, message);
                } else if !first.shape.is_empty() {
                    problems.note_at(&first.name, message);
                }
            }
            (Macro::Hamiltonian | Macro::PhaseConstraint, variables @ [first, ..]) => {
                let message =
                    "expected coordinates and momenta of one shape, as in `|q: [f64; 2], p: [f64; 2]|`";
                match variables {
                    [q, p] if q.shape == p.shape => {}
                    [_, p] => problems.note_at(&p.name, message),
                    [_, _, third, ..] => problems.note_at(&third.name, message),
                    _ => problems.note_at(&first.name, message),
                }
            }
            _ => {}
        }
    }

    fn routines(self, graph: Graph, roots: &[Id], variables: u32) -> Routines {
        match self {
            Macro::Constraint => routine::constraint(graph, roots, variables),
            Macro::Potential => routine::potential(graph, roots[0], variables),
            Macro::PairPotential => routine::pair(graph, roots[0]),
            Macro::Hamiltonian => routine::hamiltonian(graph, roots[0], variables),
            Macro::PhaseConstraint => routine::phase_constraint(graph, roots, variables),
        }
    }

    fn letter(self) -> &'static str {
        match self {
            Macro::Constraint | Macro::PhaseConstraint => "g",
            Macro::Potential | Macro::PairPotential => "U",
            Macro::Hamiltonian => "H",
        }
    }

    /// The formula, its derivatives and what they cost, below what the user wrote.
    fn documentation(self, item: &Item, routines: &Routines, named: Vec<(Id, String)>) -> Vec<String> {
        let letter = self.letter();
        let mut lines = vec![String::new(), "```text".to_owned()];
        lines.extend(formula::written(item, letter));
        let names = Names::of(item, named);
        let (graph, gradients) = &routines.gradients;
        let variables: usize = item.variables.iter().map(|variable| size(&variable.shape)).sum();
        if variables <= 6 && gradients.len() <= variables * 3 {
            for (i, &entry) in gradients.iter().enumerate() {
                let of = match gradients.len() > variables {
                    true => format!("{letter}[{}]", i / variables),
                    false => letter.to_owned(),
                };
                let by = names.variable(i % variables);
                let derivative = formula::derivative(graph, entry, &names).unwrap_or("…".to_owned());
                lines.push(format!("∂{of}/∂{by} = {derivative}"));
            }
        }
        lines.push("```".to_owned());
        let counts = routines.list.iter().filter(|routine| !routine.roots.is_empty());
        let counts: Vec<String> = counts
            .map(|routine| format!("{} `{}`", routines.operations(&routine.roots), routine.name))
            .collect();
        lines.extend([String::new(), format!("Operations per call: {}.", counts.join(", "))]);
        lines
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
    // A name that is taken is reported already; the stub has it once.
    let first =
        |&(i, parameter): &(usize, &Parameter)| item.parameters[..i].iter().all(|p| p.name != parameter.name);
    let fields = item.parameters.iter().enumerate().filter(first).map(|(_, parameter)| {
        let (attributes, visibility, name) = (&parameter.attributes, &parameter.visibility, &parameter.name);
        let shape = array_type(&parameter.shape);
        let documented = attributes.clone().into_iter().any(is_documentation);
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

/// Whether this is the bracket of `#[doc = …]`.
fn is_documentation(token: TokenTree) -> bool {
    let TokenTree::Group(group) = token else { return false };
    let first = group.stream().into_iter().next();
    first.is_some_and(|first| matches!(first, TokenTree::Ident(name) if name == "doc"))
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
        let kernel = self.name();
        let (owner, interface) = which.traits(self.sizes);
        // What a trait provides by itself has no routine where it is large; a stub has none at all.
        let written = |name| self.routines.list.is_empty() || self.routines.named(name).is_some();
        let functions = which.methods(self.sizes).into_iter().filter(|method| written(method.name));
        let functions = functions.map(|method| self.function(&method, which));
        let (constants, kinks) = self.structure_of_equations(which);
        let series = self.series(which);
        let map = self.map(which);
        let declarations = self.emitter.declarations();
        let parameters = self.parameters();
        let construction = self.emitter.construction(&kernel, &|input| match input {
            Input::Parameter(k) => parameters.get(k as usize).cloned().unwrap_or_default(),
            _ => TokenStream::new(), // a kernel's fields depend on parameters only
        });
        quote! {
            #[allow(clippy::all, clippy::pedantic, clippy::nursery, clippy::restriction)]
            #[allow(unused_variables, unreachable_pub, non_camel_case_types, missing_docs)]
            const _: () = {
                #[derive(Clone, Copy, Debug)]
                pub struct #kernel<T> { #declarations }

                #[automatically_derived]
                impl ::rattle::kernel::#owner for #name {
                    type Kernel<T: ::rattle::real::Real> = #kernel<T>;
                    #constants

                    #[inline(always)]
                    fn kernel_of_lanes<'a, T: ::rattle::real::Real>(
                        __lane: impl Fn(usize) -> &'a Self,
                    ) -> #kernel<T>
                    where
                        Self: 'a,
                    {
                        #construction
                    }

                    #map
                }

                #[automatically_derived]
                impl<T: ::rattle::real::Real> ::rattle::kernel::#interface for #kernel<T> {
                    #(#functions)*
                    #kinks
                    #series
                }
            };
        }
    }

    /// The kernel number by number, for what goes in lanes.
    fn map(&self, which: Macro) -> TokenStream {
        if !matches!(which, Macro::Constraint | Macro::Potential) {
            return TokenStream::new();
        }
        let kernel = self.name();
        let fields = self.emitter.mapped(&quote!(__number), &quote!(__kernel));
        quote! {
            #[inline(always)]
            fn map_kernel<T: ::rattle::real::Real, U: ::rattle::real::Real>(
                __kernel: &#kernel<T>,
                __number: impl Fn(&T) -> U,
            ) -> #kernel<U> {
                #kernel { #fields }
            }
        }
    }

    /// Which derivatives can be other than zero, and where the function is not smooth.
    fn structure_of_equations(&self, which: Macro) -> (TokenStream, TokenStream) {
        if let (Macro::Potential, Some(gradient)) = (which, self.routines.named("gradient")) {
            let acts = gradient.roots.iter().map(|&root| self.routines.graph.number(root) != Some(0.0));
            let d = Literal::usize_unsuffixed(self.sizes.variables);
            return (TokenStream::new(), quote!(const ACTS_ALONG: [bool; #d] = [#(#acts),*];));
        }
        if which != Macro::Constraint {
            return Default::default();
        }
        let (d, m) = (self.sizes.variables, self.sizes.roots);
        let sparsity = match self.routines.named("value_and_jacobian") {
            Some(both) => {
                let rows = both.roots[m..].chunks(d).map(|row| {
                    let entries = row.iter().map(|&root| self.routines.graph.number(root) != Some(0.0));
                    quote!([#(#entries),*])
                });
                let (d, m) = (Literal::usize_unsuffixed(d), Literal::usize_unsuffixed(m));
                quote!(const SPARSITY: [[bool; #d]; #m] = [#(#rows),*];)
            }
            None => TokenStream::new(),
        };
        let Some(kinks) = self.routines.named("kinks").filter(|kinks| !kinks.roots.is_empty()) else {
            return (sparsity, TokenStream::new());
        };
        let statements = self.emitter.body(&kinks.roots, &which.spelling(self.sizes), None);
        let values = kinks.roots.iter().map(|&root| self.emitter.result(root));
        let count = Literal::usize_unsuffixed(kinks.roots.len());
        let kinks = quote! {
            const KINKS: usize = #count;

            #[inline(always)]
            fn kinks(&self, __q: &[T; #d], __found: &mut [T]) {
                #statements
                let __values = [#(#values),*];
                let __count = if __found.len() < #count { __found.len() } else { #count };
                __found[..__count].copy_from_slice(&__values[..__count]);
            }
        };
        (sparsity, kinks)
    }

    /// The recurrences of the derivatives along a curve, for functions that are not too large for it.
    fn series(&self, which: Macro) -> TokenStream {
        let Some((of, method)) = which.series(self.sizes) else { return TokenStream::new() };
        let Some(routine) = self.routines.named(of) else { return TokenStream::new() };
        if self.routines.operations(&routine.roots) > routine::LARGE {
            return TokenStream::new();
        }
        let Series { blocks, statements, results } =
            Series::of(self.emitter, &routine.roots, &which.spelling(self.sizes));
        let result = method.result.filled(&mut results.into_iter());
        let (signature, blocks) = (method.series_signature(), Literal::usize_unsuffixed(blocks));
        quote! {
            const SERIES: Option<usize> = Some(#blocks);

            #[inline(always)]
            #signature {
                #statements
                #result
            }
        }
    }

    /// Each component of the parameters, as the scalar.
    fn parameters(&self) -> Vec<TokenStream> {
        let mut list = Vec::new();
        for parameter in &self.item.parameters {
            let name = &parameter.name;
            components(quote!(__lane(__i).#name), &parameter.shape, &mut list);
        }
        list.into_iter().map(|component| quote!(T::from_lanes(|__i| #component))).collect()
    }

    fn function(&self, method: &Method, which: Macro) -> TokenStream {
        let roots = self.routines.named(method.name).map_or(&[][..], |routine| &routine.roots);
        let large = self.routines.operations(roots) > routine::LARGE;
        let kernel = self.name();
        let arguments = method.arguments();
        let frame = Frame { kernel: &kernel, arguments: &arguments };
        let statements = self.emitter.body(roots, &which.spelling(self.sizes), large.then_some(&frame));
        let result = method.result.filled(&mut roots.iter().map(|&root| self.emitter.result(root)));
        let signature = method.signature();
        let hint = if large {
            quote!(#[inline]) // a copy at each call would cost the compiler more than the call
        } else {
            quote!(#[inline(always)])
        };
        quote! {
            #hint
            #signature {
                #statements
                #result
            }
        }
    }

    /// The kernel's type.
    fn name(&self) -> Ident {
        format_ident!("{}Kernel", self.item.name)
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
