//! Residuals of elements: local unknowns, given numbers, several components, and the blocks of the Jacobian.
//!
//! ```text
//! residual   Rᵢ(u, d)                    as written
//! jacobian   Jᵢⱼ = ∂Lᵢ/∂uⱼ               L = R, or what stands after `linearise`
//! condensed  Rₖ − Jₖₑ Jₑₑ⁻¹ Rₑ,  Jₖₖ − Jₖₑ Jₑₑ⁻¹ Jₑₖ        e: what is eliminated, k: the rest
//! recovered  δuₑ = −Jₑₑ⁻¹ (Rₑ + Jₑₖ δuₖ)
//! ```
//!
//! The inverse is written out, by cofactors, so at most three numbers of an element can be eliminated.

use crate::algebra::Scaled;
use crate::differentiate::Calculus;
use crate::emit::{Emitter, Frame};
use crate::expand::{reported, structure};
use crate::formula;
use crate::graph::Graph;
use crate::headings::{Headings, headings};
use crate::kernel::{components, kernel_name};
use crate::limits::TooLarge;
use crate::lower::{Lowered, lower};
use crate::macros::Expectation;
use crate::node::{Id, Input};
use crate::parse::parse;
use crate::problems::Problems;
use crate::routine::{LARGE, Routines};
use crate::syntax::{Item, UNKNOWN};
use proc_macro2::{Ident, Literal, TokenStream};
use quote::{format_ident, quote};

/// So many numbers of an element can be eliminated.
const MOST_ELIMINATED: usize = 3;

/// Which numbers of an element are which.
struct Roles {
    unknowns: usize,
    given: usize,
    kept: Vec<usize>,
    eliminated: Vec<usize>,
    /// What is eliminated, number by number.
    names: Vec<String>,
}

/// The struct and its kernel, generated for the input of `residual!`.
pub fn residual(input: TokenStream) -> TokenStream {
    let mut problems = Problems::default();
    let headings = headings(input, &mut problems);
    let Some(item) = parse(headings.item.clone(), &mut problems) else { return problems.report() };
    let roles = roles(&item, &headings, &mut problems);
    if headings.broken {
        return refused(&item, &roles, roles.unknowns, problems);
    }
    let mut graph = Graph::new();
    let expected = Expectation {
        several: true,
        every_variable: false,
        constant: true,
        noun: "the residual",
        of_time: "a residual knows no time; hand it over with what is given",
    };
    let Lowered { roots, parts, .. } = lower(&item, expected, &mut graph, &mut problems);
    let written = match (&headings.linearise, parts.first()) {
        (Some(_), Some(&first)) => first,
        _ => roots.len(),
    };
    if !problems.any() {
        check(&headings, &roles, written, roots.len(), &mut problems);
    }
    if problems.any() || roots.is_empty() {
        let components = if written > 0 { written } else { roles.unknowns };
        return refused(&item, &roles, components, problems);
    }
    match routines(graph, &roots, written, &roles) {
        Ok(routines) => implementation(&item, &headings, &routines, &roles),
        Err(Refusal::TooLarge(large)) => {
            problems.note_at(&item.name, large);
            refused(&item, &roles, written, problems)
        }
        Err(Refusal::Undetermined(message)) => {
            let name = headings.eliminated.first().unwrap_or(&item.name);
            problems.note_at(name, message);
            refused(&item, &roles, written, problems)
        }
    }
}

/// How many components there must be: so many are written, of all that there are.
fn check(headings: &Headings, roles: &Roles, written: usize, all: usize, problems: &mut Problems) {
    if let Some(word) = &headings.linearise
        && all != 2 * written
    {
        let found = all - written;
        let message =
            format!("expected as many components after `linearise` as before it, {written}; found {found}");
        problems.note_at(word, message);
    }
    if let Some(name) = headings.eliminated.first()
        && written != roles.unknowns
    {
        let message = format!(
            "to eliminate some of {} unknowns takes as many components, in their order; found {written}",
            roles.unknowns
        );
        problems.note_at(name, message);
    }
}

fn roles(item: &Item, headings: &Headings, problems: &mut Problems) -> Roles {
    let (mut all, mut eliminated, mut names, mut unknowns) = (0, Vec::new(), Vec::new(), 0);
    for (place, variable) in item.variables.iter().enumerate() {
        let size: usize = variable.shape.iter().product();
        if place < headings.unknowns {
            unknowns += size;
            if headings.eliminated.contains(&variable.name) {
                eliminated.extend(all..all + size);
                formula::components(variable.name.to_string(), &variable.shape, &mut names);
            }
        }
        all += size;
    }
    // Variables that could not be read are reported already.
    let readable = !item.variables.is_empty() && item.variables.iter().all(|v| v.shape != UNKNOWN);
    for name in headings.eliminated.iter().filter(|_| readable) {
        let known = item.variables.iter().take(headings.unknowns).any(|variable| variable.name == *name);
        if !known {
            problems.note_at(name, format!("`{name}` is no unknown; those stand between the first bars"));
        }
    }
    if let Some(first) = headings.eliminated.first()
        && readable
        && (eliminated.len() > MOST_ELIMINATED || eliminated.len() == unknowns)
    {
        let message = format!(
            "expected at most {MOST_ELIMINATED} numbers to eliminate and some that stay, found {} of {unknowns}",
            eliminated.len()
        );
        problems.note_at(first, message);
    }
    let kept = (0..unknowns).filter(|i| !eliminated.contains(i)).collect();
    Roles { unknowns, given: all - unknowns, kept, eliminated, names }
}

/// Why there are no functions.
enum Refusal {
    TooLarge(TooLarge),
    /// What is eliminated is not determined.
    Undetermined(String),
}

impl From<TooLarge> for Refusal {
    fn from(large: TooLarge) -> Self {
        Refusal::TooLarge(large)
    }
}

/// What is wrong with Jₑₑ where its determinant is 0 by its form; its rows and columns have these names.
fn undetermined(a: &[Vec<Scaled>], names: &[String]) -> Refusal {
    let rule = "the component in the place of an unknown is the one that it is found from";
    let column = |j: usize| a.iter().all(|row| row[j].is_zero());
    let all = names.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
    let row = (0..a.len()).find(|&i| a[i].iter().all(|entry| entry.is_zero()));
    Refusal::Undetermined(match (row, (0..a.len()).find(|&j| column(j))) {
        (Some(i), _) => {
            format!(
                "the component in the place of `{}` does not depend on {all}, which it is to be found from",
                names[i]
            )
        }
        (None, Some(j)) => format!("no component in the places of {all} depends on `{}`; {rule}", names[j]),
        (None, None) => format!("the components in the places of {all} do not tell these apart; {rule}"),
    })
}

/// A⁻¹ by cofactors, of one to three rows; none where it is known that there is none.
fn inverse(graph: &mut Graph, a: &[Vec<Scaled>]) -> Option<Vec<Vec<Scaled>>> {
    let n = a.len();
    let minor = |graph: &mut Graph, i: usize, j: usize| match n {
        1 => Scaled::ONE,
        2 => a[1 - i][1 - j],
        _ => {
            let ([r, s], [k, l]) = ([(i + 1) % 3, (i + 2) % 3], [(j + 1) % 3, (j + 2) % 3]); // cyclic: the sign is in it
            difference(graph, [a[r][k], a[s][l]], [a[r][l], a[s][k]])
        }
    };
    let cofactors: Vec<Vec<Scaled>> = (0..n)
        .map(|i| {
            let signed = |j: usize| if n == 2 && (i + j) % 2 == 1 { -1.0 } else { 1.0 };
            (0..n).map(|j| minor(graph, i, j).times(signed(j))).collect()
        })
        .collect();
    let terms: Vec<Scaled> = (0..n).map(|j| graph.product(&[a[0][j], cofactors[0][j]])).collect();
    let determinant = graph.sum(&terms);
    if determinant.is_zero() {
        return None;
    }
    let determinant = graph.node_of(determinant);
    let one_over = graph.reciprocal(determinant);
    let row = |i: usize| (0..n).map(|j| graph.product(&[cofactors[j][i], one_over])).collect();
    Some((0..n).map(row).collect())
}

fn difference(graph: &mut Graph, a: [Scaled; 2], b: [Scaled; 2]) -> Scaled {
    let (a, b) = (graph.product(&a), graph.product(&b));
    graph.sum(&[a, b.times(-1.0)])
}

/// a − Σ bᵢ cᵢ
fn less(graph: &mut Graph, a: Scaled, b: &[Scaled], c: &[Scaled]) -> Scaled {
    let mut terms = vec![a];
    for (&b, &c) in b.iter().zip(c) {
        terms.push(graph.product(&[b, c]).times(-1.0));
    }
    graph.sum(&terms)
}

fn routines(mut source: Graph, roots: &[Id], components: usize, roles: &Roles) -> Result<Routines, Refusal> {
    let n = roles.unknowns;
    let mut routines = Routines::empty();
    let values: Vec<Scaled> = roots[..components].iter().map(|&root| root.into()).collect();
    routines.add("residual", &source, &values)?;
    let mut calculus = Calculus::new(&mut source);
    let linearised = &roots[roots.len() - components..];
    let rows: Vec<Vec<Scaled>> =
        linearised.iter().map(|&root| calculus.gradient(&[(Scaled::ONE, root)], n as u32)).collect();
    routines.add("residual_and_jacobian", &source, &[&values[..], &rows.concat()].concat())?;
    let (k, e) = (&roles.kept, &roles.eliminated);
    if e.is_empty() {
        return Ok(routines);
    }
    let pick = |rows_of: &[usize], columns: &[usize]| -> Vec<Vec<Scaled>> {
        rows_of.iter().map(|&i| columns.iter().map(|&j| rows[i][j]).collect()).collect()
    };
    let own = pick(e, e);
    let inverse = inverse(&mut source, &own).ok_or_else(|| undetermined(&own, &roles.names))?;
    let (below, beside) = (pick(e, k), pick(k, e));
    // W = Jₑₑ⁻¹ [Jₑₖ | Rₑ], by columns.
    let column = |source: &mut Graph, of: &dyn Fn(usize) -> Scaled| -> Vec<Scaled> {
        let row = |source: &mut Graph, row: &Vec<Scaled>| {
            let terms: Vec<Scaled> =
                row.iter().enumerate().map(|(i, &entry)| source.product(&[entry, of(i)])).collect();
            source.sum(&terms)
        };
        inverse.iter().map(|entries| row(source, entries)).collect()
    };
    let by_kept: Vec<Vec<Scaled>> = (0..k.len()).map(|j| column(&mut source, &|i| below[i][j])).collect();
    let by_rest = column(&mut source, &|i| values[e[i]]);
    let mut condensed: Vec<Scaled> =
        k.iter().zip(&beside).map(|(&i, beside)| less(&mut source, values[i], beside, &by_rest)).collect();
    routines.add("condensed_residual", &source, &condensed)?;
    for (&i, beside) in k.iter().zip(&beside) {
        for (&j, column) in k.iter().zip(&by_kept) {
            condensed.push(less(&mut source, rows[i][j], beside, column));
        }
    }
    routines.add("condensed", &source, &condensed)?;
    let steps: Vec<Scaled> = (0..k.len()).map(|j| source.input(Input::Direction(j as u32)).into()).collect();
    let recovered: Vec<Scaled> = (0..e.len())
        .map(|i| {
            let mut terms = vec![by_rest[i].times(-1.0)];
            for (&step, column) in steps.iter().zip(&by_kept) {
                terms.push(source.product(&[step, column[i]]).times(-1.0));
            }
            source.sum(&terms)
        })
        .collect();
    routines.add("recovered", &source, &recovered)?;
    Ok(routines)
}

/// The struct with its formulas in the documentation, and the kernel.
fn implementation(item: &Item, headings: &Headings, routines: &Routines, roles: &Roles) -> TokenStream {
    let letter = if headings.linearise.is_some() { "[residual, what is linearised]" } else { "R" };
    let mut lines = vec![String::new(), "```text".to_owned()];
    lines.extend(formula::written(item, letter));
    lines.push("```".to_owned());
    let counts: Vec<String> = routines
        .list
        .iter()
        .map(|routine| format!("{} `{}`", routines.operations(&routine.roots), routine.name))
        .collect();
    lines.extend([String::new(), format!("Operations per call: {}.", counts.join(", "))]);
    let structure = structure(item, &lines);
    let emitter = Emitter::new(routines);
    let kernel = kernel_name(item);
    let mut parameters = Vec::new();
    for parameter in &item.parameters {
        let name = &parameter.name;
        components(quote!(self.#name), &parameter.shape, &mut parameters);
    }
    let construction = emitter.construction(&kernel, &|input| match input {
        Input::Parameter(k) => {
            let component = &parameters[k as usize];
            quote!(T::from_f64(#component))
        }
        _ => TokenStream::new(), // a kernel's fields depend on parameters only
    });
    let functions = routines
        .list
        .iter()
        .map(|routine| function(routine.name, &routine.roots, &emitter, routines, roles, &kernel));
    let (all, uses) = (functions.collect(), uses(item, &kernel, routines));
    let kernel = kernel_of(item, roles, emitter.declarations(), construction, all);
    quote!(#structure #kernel #uses)
}

/// A use of each function: those that a program does not use are no news, and a crate may forbid to allow them.
fn uses(item: &Item, kernel: &Ident, routines: &Routines) -> TokenStream {
    let (name, conditions) = (&item.name, &item.conditions);
    let quiet = if item.is_deprecated() { quote!(#[allow(deprecated)]) } else { TokenStream::new() };
    let functions = routines.list.iter().map(|routine| format_ident!("{}", routine.name));
    let number = quote!(::core::primitive::f64);
    quote! {
        #conditions
        #quiet
        const _: fn(&#name) = |__item| {
            let _ = (#name::UNKNOWNS, #name::GIVEN, #name::KEPT, __item.kernel::<#number>());
            #(let _ = #kernel::<#number>::#functions;)*
        };
    }
}

/// What stands in for an item in which something is wrong, and what that is. Functions take arrays of any length, as
/// it may be the lengths that are wrong, and only satisfy the compiler: no second wave of errors follows.
fn refused(item: &Item, roles: &Roles, components: usize, problems: Problems) -> TokenStream {
    let functions = ABOUT.iter().map(|(name, _)| {
        let (result, of_name) = (result(name, roles, components), format_ident!("{name}"));
        let step = if *name == "recovered" { quote!(, _: &[T; __K]) } else { TokenStream::new() };
        let length = if *name == "recovered" {
            quote!(, const __K: ::core::primitive::usize)
        } else {
            TokenStream::new()
        };
        quote! {
            pub fn #of_name<const __N: ::core::primitive::usize, const __D: ::core::primitive::usize #length>(
                &self,
                _: &[T; __N],
                _: &[T; __D]
                #step
            ) -> #result {
                loop {}
            }
        }
    });
    let (structure, report) = (structure(item, &[]), reported(item, problems));
    let declarations = quote!(scalar: ::core::marker::PhantomData<T>);
    let kernel = kernel_of(item, roles, declarations, quote!(loop {}), functions.collect());
    quote!(#structure #kernel #report)
}

/// The kernel's type, how it is made, and its functions.
fn kernel_of(
    item: &Item,
    roles: &Roles,
    declarations: TokenStream,
    construction: TokenStream,
    functions: TokenStream,
) -> TokenStream {
    let (name, kernel) = (&item.name, kernel_name(item));
    let (conditions, visibility) = (&item.conditions, &item.visibility);
    let quiet = if item.is_deprecated() { quote!(#[allow(deprecated)]) } else { TokenStream::new() };
    let about =
        format!("The functions of [`{name}`] over the scalar `T`: of one element, or of several in lanes.");
    let [n, d, k] = [roles.unknowns, roles.given, roles.kept.len()].map(Literal::usize_unsuffixed);
    quote! {
        #conditions
        #quiet
        #[doc = #about]
        #[derive(::core::clone::Clone, ::core::marker::Copy, ::core::fmt::Debug)]
        #visibility struct #kernel<T> { #declarations }

        #conditions
        #quiet
        #[automatically_derived]
        #[allow(clippy::approx_constant)]
        impl #name {
            /// The number of unknowns of an element.
            pub const UNKNOWNS: ::core::primitive::usize = #n;
            /// The number of given numbers of an element.
            pub const GIVEN: ::core::primitive::usize = #d;
            /// The number of unknowns left after elimination.
            pub const KEPT: ::core::primitive::usize = #k;

            /// The functions with these parameters, over the scalar `T`.
            #[inline(always)]
            pub fn kernel<T: ::rattle::real::Real>(&self) -> #kernel<T> {
                #construction
            }
        }

        #conditions
        #quiet
        #[automatically_derived]
        #[allow(clippy::approx_constant)]
        impl<T: ::rattle::real::Real> #kernel<T> {
            #functions
        }
    }
}

/// What each function gives, for the documentation.
const ABOUT: [(&str, &str); 5] = [
    ("residual", "R(u, d)."),
    ("residual_and_jacobian", "R and the derivatives of what is linearised: row i belongs to component i."),
    ("condensed_residual", "What is left of R after elimination: Rₖ − Jₖₑ Jₑₑ⁻¹ Rₑ."),
    ("condensed", "What is left of R and J after elimination: the Schur complement Jₖₖ − Jₖₑ Jₑₑ⁻¹ Jₑₖ."),
    ("recovered", "The Newton step of what is eliminated, from that of the rest: −Jₑₑ⁻¹ (Rₑ + Jₑₖ δ)."),
];

fn function(
    name: &str,
    roots: &[Id],
    emitter: &Emitter,
    routines: &Routines,
    roles: &Roles,
    kernel: &Ident,
) -> TokenStream {
    let about = ABOUT.iter().find(|(own, _)| *own == name).map_or("", |(_, about)| about);
    let [n, d, k] = [roles.unknowns, roles.given, roles.kept.len()].map(Literal::usize_unsuffixed);
    let components = routines.named("residual").map_or(0, |routine| routine.roots.len());
    let mut arguments: Vec<(Ident, TokenStream)> =
        vec![(format_ident!("__u"), quote!(&[T; #n])), (format_ident!("__d"), quote!(&[T; #d]))];
    if name == "recovered" {
        arguments.push((format_ident!("__step"), quote!(&[T; #k])));
    }
    let result = result(name, roles, components);
    let unknowns = roles.unknowns as u32;
    let spelling = move |input| match input {
        Input::Variable(i) if i < unknowns => component("__u", i),
        Input::Variable(i) => component("__d", i - unknowns),
        Input::Direction(i) => component("__step", i),
        Input::Parameter(_) | Input::Weight(_) => TokenStream::new(), // the kernel holds the one, none has the other
    };
    let large = routines.operations(roots) > LARGE;
    let frame = Frame { kernel, arguments: &arguments };
    let statements = emitter.body(roots, &spelling, large.then_some(&frame));
    let numbers: Vec<TokenStream> = roots.iter().map(|&root| emitter.result(root)).collect();
    let value = match name {
        "residual_and_jacobian" | "condensed" => {
            let kept = roles.kept.len();
            let (size, width) = if name == "condensed" { (kept, kept) } else { (components, roles.unknowns) };
            let (first, rows) = (&numbers[..size], numbers[size..].chunks(width));
            quote!(([#(#first),*], [#([#(#rows),*]),*]))
        }
        _ => quote!([#(#numbers),*]),
    };
    let hint = if large { quote!(#[inline]) } else { quote!(#[inline(always)]) };
    let name = format_ident!("{name}");
    let arguments = arguments.iter().map(|(name, form)| quote!(#name: #form));
    quote! {
        #[doc = #about]
        #hint
        pub fn #name(&self, #(#arguments),*) -> #result {
            #statements
            #value
        }
    }
}

/// What a function returns.
fn result(name: &str, roles: &Roles, components: usize) -> TokenStream {
    let [n, m, k, e] =
        [roles.unknowns, components, roles.kept.len(), roles.eliminated.len()].map(Literal::usize_unsuffixed);
    match name {
        "residual" => quote!([T; #m]),
        "residual_and_jacobian" => quote!(([T; #m], [[T; #n]; #m])),
        "condensed_residual" => quote!([T; #k]),
        "condensed" => quote!(([T; #k], [[T; #k]; #k])),
        _ => quote!([T; #e]),
    }
}

fn component(name: &str, i: u32) -> TokenStream {
    let (name, i) = (format_ident!("{name}"), Literal::u32_unsuffixed(i));
    quote!(#name[#i])
}
