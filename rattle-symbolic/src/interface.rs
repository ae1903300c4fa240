//! The traits that the macros implement: which functions with which arguments and results.

use crate::macros::{Macro, Sizes};
use crate::node::Input;
use proc_macro2::{Ident, Literal, Span, TokenStream};
use quote::quote;

/// The shape of an argument or a result.
#[derive(Clone, Debug)]
pub(crate) enum Form {
    Number,
    Array(usize, Box<Form>),
    Tuple(Vec<Form>),
}

impl Form {
    fn array(n: usize) -> Form {
        Form::Array(n, Box::new(Form::Number))
    }
    fn of(self, n: usize) -> Form {
        Form::Array(n, Box::new(self))
    }

    /// The type.
    pub(crate) fn tokens(&self) -> TokenStream {
        match self {
            Form::Number => quote!(T),
            Form::Array(n, inner) => {
                let (n, inner) = (Literal::usize_unsuffixed(*n), inner.tokens());
                quote!([#inner; #n])
            }
            Form::Tuple(parts) => {
                let parts = parts.iter().map(Form::tokens);
                quote!((#(#parts),*))
            }
        }
    }

    /// An expression of this type with the numbers in turn.
    pub(crate) fn filled(&self, numbers: &mut dyn Iterator<Item = TokenStream>) -> TokenStream {
        match self {
            Form::Number => numbers.next().unwrap_or(quote!(T::from_f64(0.0))),
            Form::Array(n, inner) => {
                let parts: Vec<TokenStream> = (0..*n).map(|_| inner.filled(numbers)).collect();
                quote!([#(#parts),*])
            }
            Form::Tuple(parts) => {
                let parts: Vec<TokenStream> = parts.iter().map(|part| part.filled(numbers)).collect();
                quote!((#(#parts),*))
            }
        }
    }
}

/// A function of a kernel.
pub(crate) struct Method {
    pub(crate) name: &'static str,
    arguments: Vec<(&'static str, Form)>,
    pub(crate) result: Form,
}

impl Method {
    fn new(name: &'static str, arguments: &[(&'static str, &Form)], result: Form) -> Self {
        let arguments = arguments.iter().map(|&(name, form)| (name, form.clone())).collect();
        Self { name, arguments, result }
    }

    pub(crate) fn signature(&self) -> TokenStream {
        let name = Ident::new(self.name, Span::call_site());
        let arguments = self.arguments().into_iter().map(|(name, form)| quote!(#name: #form));
        let result = self.result.tokens();
        quote!(fn #name(&self, #(#arguments),*) -> #result)
    }

    /// The same for the function that makes coefficients of power series.
    pub(crate) fn series_signature(&self) -> TokenStream {
        let name = Ident::new(self.name, Span::call_site());
        let arguments = self.arguments().into_iter().map(|(name, form)| quote!(#name: #form));
        let result = self.result.tokens();
        quote! {
            fn #name<const FIRST: ::core::primitive::bool>(
                &self, #(#arguments,)* __order: &mut ::rattle::series::Order<'_, T, FIRST>,
            ) -> #result
        }
    }

    /// The names and types of the arguments.
    pub(crate) fn arguments(&self) -> Vec<(Ident, TokenStream)> {
        let argument = |(name, form): &(&'static str, Form)| {
            let (name, tokens) = (argument_name(name), form.tokens());
            match form {
                Form::Number => (name, tokens),
                _ => (name, quote!(&#tokens)),
            }
        };
        self.arguments.iter().map(argument).collect()
    }
}

/// An argument as it is called in generated code, where a constant `q` of the user's would be a pattern.
fn argument_name(name: &str) -> Ident {
    Ident::new(&format!("__{name}"), Span::call_site())
}

impl Macro {
    /// The trait of the struct and that of its kernel, with their arguments.
    pub(crate) fn traits(self, sizes: &Sizes) -> (TokenStream, TokenStream) {
        let [d, half, m] = [sizes.variables, sizes.variables / 2, sizes.roots].map(Literal::usize_unsuffixed);
        let before = Literal::usize_unsuffixed(sizes.coordinates());
        match self {
            Macro::Constraint => (quote!(Constraint<#d, #m>), quote!(ConstraintKernel<T, #d, #m>)),
            Macro::Potential => (quote!(Potential<#d>), quote!(PotentialKernel<T, #d>)),
            Macro::DrivenPotential => {
                (quote!(DrivenPotential<#before>), quote!(DrivenPotentialKernel<T, #before>))
            }
            Macro::Force => (quote!(ForceLaw<#m>), quote!(ForceLawKernel<T, #m>)),
            Macro::PairPotential => (quote!(PairPotential), quote!(PairKernel<T>)),
            Macro::Hamiltonian => (quote!(Hamiltonian<#half>), quote!(HamiltonianKernel<T, #half>)),
            Macro::PhaseConstraint => {
                (quote!(PhaseConstraint<#half, #m>), quote!(PhaseConstraintKernel<T, #half, #m>))
            }
        }
    }

    /// The functions of the kernel's trait; their results are those of the routines of that name.
    pub(crate) fn methods(self, sizes: &Sizes) -> Vec<Method> {
        let (d, m) = (sizes.variables, sizes.roots);
        let method = Method::new;
        let tuple = |parts: &[&Form]| Form::Tuple(parts.iter().map(|&part| part.clone()).collect());
        let number = Form::Number;
        match self {
            Macro::Constraint => {
                let (q, row) = (Form::array(d), Form::array(m));
                let rows = q.clone().of(m);
                let hessian = q.clone().of(d).of(m);
                vec![
                    method("value", &[("q", &q)], row.clone()),
                    method("jacobian", &[("q", &q)], rows.clone()),
                    method("value_and_jacobian", &[("q", &q)], tuple(&[&row, &rows])),
                    method("hessian_vector", &[("q", &q), ("v", &q)], rows),
                    method("jet", &[("q", &q), ("v", &q)], tuple(&[&row, &row, &row])),
                    method("hessian", &[("q", &q)], hessian),
                    method("weighted_hessian_vector", &[("q", &q), ("weights", &row), ("v", &q)], q.clone()),
                ]
            }
            Macro::Potential => {
                let q = Form::array(d);
                vec![
                    method("value", &[("q", &q)], number.clone()),
                    method("gradient", &[("q", &q)], q.clone()),
                ]
            }
            Macro::DrivenPotential => {
                let q = Form::array(sizes.coordinates());
                let place = [("q", &q), ("t", &number)];
                vec![
                    method("value", &place, number.clone()),
                    method("gradient", &place, q.clone()),
                    method("rate", &place, number.clone()),
                ]
            }
            Macro::Force => {
                let (q, slopes) = (Form::array(m), Form::array(m).of(m));
                let place = [("q", &q), ("v", &q), ("t", &number)];
                vec![
                    method("value", &place, q.clone()),
                    method("value_and_slopes", &place, tuple(&[&q, &slopes])),
                ]
            }
            Macro::PairPotential => {
                vec![
                    method("value", &[("s", &number)], number.clone()),
                    method("slope", &[("s", &number)], number.clone()),
                ]
            }
            Macro::Hamiltonian => {
                let q = Form::array(d / 2);
                let both = tuple(&[&q, &q]);
                vec![
                    method("value", &[("q", &q), ("p", &q)], number),
                    method("gradients", &[("q", &q), ("p", &q)], both.clone()),
                    method("hessian_vector", &[("q", &q), ("p", &q), ("dq", &q), ("dp", &q)], both),
                ]
            }
            Macro::PhaseConstraint => {
                let (q, row) = (Form::array(d / 2), Form::array(m));
                let rows = q.clone().of(m);
                let both = tuple(&[&rows, &rows]);
                vec![
                    method("value", &[("q", &q), ("p", &q)], row.clone()),
                    method("jacobians", &[("q", &q), ("p", &q)], both.clone()),
                    method("value_and_jacobians", &[("q", &q), ("p", &q)], tuple(&[&row, &rows, &rows])),
                    method("hessian_vector", &[("q", &q), ("p", &q), ("dq", &q), ("dp", &q)], both),
                ]
            }
        }
    }

    /// The function of which the kernel has power series too, and the one that makes their coefficients.
    pub(crate) fn series(self, sizes: &Sizes) -> Option<(&'static str, Method)> {
        let (q, number) = (Form::array(sizes.variables), Form::Number);
        let rows = q.clone().of(sizes.roots);
        match self {
            Macro::Constraint => Some(("jacobian", Method::new("jacobian_series", &[("q", &q)], rows))),
            Macro::Potential => Some(("gradient", Method::new("gradient_series", &[("q", &q)], q.clone()))),
            Macro::PairPotential => {
                Some(("slope", Method::new("slope_series", &[("s", &number)], number.clone())))
            }
            Macro::DrivenPotential | Macro::Force | Macro::Hamiltonian | Macro::PhaseConstraint => None,
        }
    }

    /// How the functions spell their inputs.
    pub(crate) fn spelling(self, sizes: &Sizes) -> impl Fn(Input) -> TokenStream {
        let half = match self {
            Macro::Hamiltonian | Macro::PhaseConstraint => (sizes.variables / 2) as u32,
            Macro::Force => sizes.roots as u32,
            _ => u32::MAX,
        };
        let time = if sizes.time { sizes.variables as u32 - 1 } else { u32::MAX };
        let second = if self == Macro::Force { "v" } else { "p" };
        let directions = if half == u32::MAX { ["v", "v"] } else { ["dq", "dp"] };
        let component = |name: &str, k: u32| {
            let (name, k) = (argument_name(name), Literal::u32_unsuffixed(k));
            quote!(#name[#k])
        };
        move |input| match input {
            Input::Variable(_) if self == Macro::PairPotential => quote!(__s),
            Input::Variable(k) if k == time => quote!(__t),
            Input::Variable(k) if k < half => component("q", k),
            Input::Variable(k) => component(second, k - half),
            Input::Direction(k) if k < half => component(directions[0], k),
            Input::Direction(k) => component(directions[1], k - half),
            Input::Weight(k) => component("weights", k),
            Input::Parameter(_) => TokenStream::new(), // always held by the kernel
        }
    }
}
