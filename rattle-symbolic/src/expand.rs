//! From a macro's input to the items it makes.

use crate::emit::Emitter;
use crate::formula::{self, Names};
use crate::graph::Graph;
use crate::kernel::Kernel;
use crate::limits::TooLarge;
use crate::lower::{Lowered, lower};
use crate::macros::{Macro, Sizes};
use crate::node::Id;
use crate::parse::parse;
use crate::problems::Problems;
use crate::routine::{self, Routines};
use crate::syntax::{Item, Parameter, is_documented};
use proc_macro2::{Literal, TokenStream};
use quote::quote;

/// The items generated for an input: always a struct, so that other code can name it, and an error for every mistake.
pub fn expand(which: Macro, input: TokenStream) -> TokenStream {
    let mut problems = Problems::default();
    let Some(item) = parse(input, &mut problems) else { return problems.report() };
    let which = which.of(&item);
    let mut graph = Graph::new();
    let Lowered { roots, named, .. } = lower(&item, which.expectation(), &mut graph, &mut problems);
    which.check(&item, roots.len(), &mut problems);
    let sizes = which.sizes(&item, roots.len());
    if problems.any() || roots.is_empty() {
        return which.refused(&item, &sizes, problems);
    }
    let routines = match which.routines(graph, &roots, &sizes) {
        Ok(routines) => routines,
        Err(large) => {
            problems.note_at(&item.name, large);
            return which.refused(&item, &sizes, problems);
        }
    };
    let names = Names::of(&item, named);
    let documentation = which.documentation(&item, &sizes, &routines, &names);
    let kinks = kinks(&routines, &names);
    let structure = structure(&item, &documentation);
    let emitter = Emitter::new(&routines);
    let kernel = Kernel { item: &item, emitter: &emitter, routines: &routines, sizes: &sizes, kinks: &kinks };
    let implementation = kernel.implementation(which);
    quote!(#structure #implementation)
}

impl Macro {
    fn routines(self, graph: Graph, roots: &[Id], sizes: &Sizes) -> Result<Routines, TooLarge> {
        let variables = sizes.variables as u32;
        match self {
            Macro::Constraint => routine::constraint(graph, roots, variables),
            Macro::Potential => routine::potential(graph, roots[0], variables),
            Macro::DrivenPotential => routine::driven_potential(graph, roots[0], variables),
            Macro::Force => routine::force(graph, roots, variables, sizes.coordinates() > roots.len()),
            Macro::PairPotential => routine::pair(graph, roots[0]),
            Macro::Hamiltonian => routine::hamiltonian(graph, roots[0], variables),
            Macro::PhaseConstraint => routine::phase_constraint(graph, roots, variables),
        }
    }

    /// The formula, its derivatives and what they cost, below what the user wrote.
    fn documentation(
        self,
        item: &Item,
        &Sizes { variables, .. }: &Sizes,
        routines: &Routines,
        names: &Names,
    ) -> Vec<String> {
        let letter = self.letter();
        let mut lines = vec![String::new(), "```text".to_owned()];
        lines.extend(formula::written(item, letter));
        let (graph, gradients) = &routines.gradients;
        if variables <= 6 && gradients.len() <= variables * 3 {
            for (i, &entry) in gradients.iter().enumerate() {
                let of = match gradients.len() > variables {
                    true => format!("{letter}[{}]", i / variables),
                    false => letter.to_owned(),
                };
                let by = names.variable(i % variables);
                let derivative = formula::formula(graph, entry, names).unwrap_or("…".to_owned());
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

    /// What stands in for an item in which something is wrong, and what that is.
    fn refused(self, item: &Item, sizes: &Sizes, problems: Problems) -> TokenStream {
        let (stub, report) = (self.stub(item, sizes), reported(item, problems));
        quote!(#stub #report)
    }

    /// The struct, and functions that only satisfy the compiler, so that no second wave of errors follows.
    fn stub(self, item: &Item, sizes: &Sizes) -> TokenStream {
        let structure = structure(item, &[]);
        let variables = match sizes.coordinates() {
            0 => 3,
            variables => variables,
        };
        let roots = match (self, sizes.roots) {
            (Macro::Force, 0) if variables % 2 == 0 => variables / 2,
            (Macro::Force, 0) => variables,
            (_, roots) => roots.max(1),
        };
        let sizes = Sizes { variables: variables + usize::from(sizes.time), roots, ..*sizes };
        let routines = Routines::empty();
        let emitter = Emitter::new(&routines);
        let kernel = Kernel { item, emitter: &emitter, routines: &routines, sizes: &sizes, kinks: &[] };
        let implementation = kernel.implementation(self);
        quote!(#structure #implementation)
    }
}

/// So many kinks are named one by one.
const MOST_NAMED: usize = 64;

/// What changes sign where the equations are not smooth, as text; of few.
fn kinks(routines: &Routines, names: &Names) -> Vec<String> {
    let long = "an argument of abs, sign, min, max or if";
    let text = |&kink: &Id| formula::formula(&routines.gradients.0, kink.into(), names);
    let few = routines.kinks.len() <= MOST_NAMED;
    let named = |kink: &Id| if few { text(kink) } else { None };
    routines.kinks.iter().map(|kink| named(kink).unwrap_or_else(|| long.to_owned())).collect()
}

/// What is wrong with an item, if it is there at all.
pub(crate) fn reported(item: &Item, problems: Problems) -> TokenStream {
    let (conditions, report) = (&item.conditions, problems.report());
    if conditions.is_empty() { report } else { quote!(#conditions const _: () = { #report };) }
}

/// The user's struct.
pub(crate) fn structure(item: &Item, documentation: &[String]) -> TokenStream {
    let Item { attributes, visibility, name, .. } = item;
    // A name that is taken is reported already; the stub has it once.
    let first =
        |&(i, parameter): &(usize, &Parameter)| item.parameters[..i].iter().all(|p| p.name != parameter.name);
    let fields = item.parameters.iter().enumerate().filter(first).map(|(_, parameter)| {
        let (attributes, visibility, name) = (&parameter.attributes, &parameter.visibility, &parameter.name);
        let shape = array_type(&parameter.shape);
        let note = format!("The parameter `{name}`.");
        let note = if is_documented(attributes) { TokenStream::new() } else { quote!(#[doc = #note]) };
        quote!(#attributes #note #visibility #name: #shape)
    });
    quote! {
        #attributes
        #(#[doc = #documentation])*
        #[derive(
            ::core::clone::Clone, ::core::marker::Copy, ::core::fmt::Debug, ::core::cmp::PartialEq
        )]
        #visibility struct #name { #(#fields),* }
    }
}

fn array_type(shape: &[usize]) -> TokenStream {
    match shape.split_first() {
        None => quote!(::core::primitive::f64),
        Some((&length, inner)) => {
            let (inner, length) = (array_type(inner), Literal::usize_unsuffixed(length));
            quote!([#inner; #length])
        }
    }
}
