//! The kernel that a macro writes: its type, and the traits of the struct and of the kernel.

use crate::emit::{Emitter, Frame};
use crate::interface::Method;
use crate::macros::{Macro, Sizes};
use crate::node::Input;
use crate::recurrence::Series;
use crate::routine::{LARGE, Routines};
use crate::syntax::Item;
use proc_macro2::{Ident, Literal, Span, TokenStream};
use quote::{format_ident, quote};
use syn::ext::IdentExt;

/// The implementation of the kernel's trait.
pub(crate) struct Kernel<'a> {
    pub(crate) item: &'a Item,
    pub(crate) emitter: &'a Emitter<'a>,
    pub(crate) routines: &'a Routines,
    pub(crate) sizes: &'a Sizes,
    /// What changes sign where equations are not smooth, as text.
    pub(crate) kinks: &'a [String],
}

impl Kernel<'_> {
    pub(crate) fn implementation(&self, which: Macro) -> TokenStream {
        let name = &self.item.name;
        let kernel = self.name();
        let (owner, interface) = which.traits(self.sizes);
        // What a trait provides by itself has no routine where it is large; a stub has none at all.
        let written = |name| self.routines.list.is_empty() || self.routines.named(name).is_some();
        let functions = which.methods(self.sizes).into_iter().filter(|method| written(method.name));
        let functions = functions.map(|method| self.function(&method, which));
        let (acts_along, kinks) = (self.acts_along(which), self.kinks(which));
        let depends_on = self.depends_on(which);
        let series = self.series(which);
        let (map, nan) = (self.map(which), self.nan_parameter());
        let declarations = self.emitter.declarations();
        let parameters = self.parameters();
        let construction = self.emitter.construction(&kernel, &|input| match input {
            Input::Parameter(k) => parameters.get(k as usize).cloned().unwrap_or_default(),
            _ => TokenStream::new(), // a kernel's fields depend on parameters only
        });
        let conditions = &self.item.conditions;
        // No other lint of the compiler's looks here, and a crate may forbid to allow one. Clippy's looks at numbers.
        let quiet = if self.item.is_deprecated() { quote!(#[allow(deprecated)]) } else { TokenStream::new() };
        quote! {
            #conditions
            #quiet
            #[allow(clippy::approx_constant)]
            const _: () = {
                #[derive(::core::clone::Clone, ::core::marker::Copy, ::core::fmt::Debug)]
                pub struct #kernel<T> { #declarations }

                #[automatically_derived]
                impl ::rattle::kernel::#owner for #name {
                    type Kernel<T: ::rattle::real::Real> = #kernel<T>;

                    #[inline(always)]
                    fn kernel_of_lanes<'a, T: ::rattle::real::Real>(
                        __lane: impl ::core::ops::Fn(::core::primitive::usize) -> &'a Self,
                    ) -> #kernel<T>
                    where
                        Self: 'a,
                    {
                        #construction
                    }

                    #map

                    #nan
                }

                #[automatically_derived]
                impl<T: ::rattle::real::Real> ::rattle::kernel::#interface for #kernel<T> {
                    #(#functions)*
                    #acts_along
                    #depends_on
                    #kinks
                    #series
                }
            };
        }
    }

    /// The kernel number by number, for what goes in lanes.
    fn map(&self, which: Macro) -> TokenStream {
        if matches!(which, Macro::DrivenPotential | Macro::Force | Macro::PairPotential) {
            return TokenStream::new();
        }
        let kernel = self.name();
        let fields = self.emitter.mapped(&quote!(__number), &quote!(__kernel));
        quote! {
            #[inline(always)]
            fn map_kernel<T: ::rattle::real::Real, U: ::rattle::real::Real>(
                __kernel: &#kernel<T>,
                __number: impl ::core::ops::Fn(&T) -> U,
            ) -> #kernel<U> {
                #kernel { #fields }
            }
        }
    }

    /// Which parameter is NaN.
    fn nan_parameter(&self) -> TokenStream {
        let looks = self.item.parameters.iter().map(|parameter| {
            let (name, text) = (&parameter.name, parameter.name.unraw().to_string());
            let mut list = Vec::new();
            components(quote!(self.#name), &parameter.shape, &mut list);
            // None of an array without entries.
            let looks = (!list.is_empty()).then(|| quote!(if #(::core::primitive::f64::is_nan(#list))||*));
            looks.map(|looks| quote!(#looks { return ::core::option::Option::Some(#text); }))
        });
        quote! {
            fn nan_parameter(&self) -> ::core::option::Option<&'static ::core::primitive::str> {
                #(#looks)*
                ::core::option::Option::None
            }
        }
    }

    /// Which components of a potential's gradient can be other than zero.
    fn acts_along(&self, which: Macro) -> TokenStream {
        let (Macro::Potential, Some(gradient)) = (which, self.routines.named("gradient")) else {
            return TokenStream::new();
        };
        let acts = gradient.roots.iter().map(|&root| self.routines.graph.number(root) != Some(0.0));
        let d = Literal::usize_unsuffixed(self.sizes.variables);
        quote! {
            #[inline(always)]
            fn acts_along(&self) -> [::core::primitive::bool; #d] {
                [#(#acts),*]
            }
        }
    }

    /// Whether a force depends on velocities, has slopes by them, and depends on time.
    fn depends_on(&self, which: Macro) -> TokenStream {
        if which != Macro::Force {
            return TokenStream::new();
        }
        let (on_velocity, on_time) = (self.routines.on_velocity, self.sizes.time);
        let sloped = self.routines.named("value_and_slopes").is_some();
        quote! {
            const ON_VELOCITY: ::core::primitive::bool = #on_velocity;
            const SLOPED: ::core::primitive::bool = #sloped;
            const ON_TIME: ::core::primitive::bool = #on_time;
        }
    }

    /// Where equations are not smooth.
    fn kinks(&self, which: Macro) -> TokenStream {
        let Some(kinks) = self.routines.named("kinks").filter(|kinks| !kinks.roots.is_empty()) else {
            return TokenStream::new();
        };
        let statements = self.emitter.body(&kinks.roots, &which.spelling(self.sizes), None);
        let values = kinks.roots.iter().map(|&root| self.emitter.result(root));
        let in_phase = which == Macro::PhaseConstraint;
        let d = if in_phase { self.sizes.variables / 2 } else { self.sizes.variables };
        let [d, count] = [d, kinks.roots.len()].map(Literal::usize_unsuffixed);
        let momenta = if in_phase { quote!(__p: &[T; #d],) } else { TokenStream::new() };
        let texts = self.kinks;
        quote! {
            const KINKS: &'static [&'static ::core::primitive::str] = &[#(#texts),*];

            #[inline(always)]
            fn kinks(&self, __q: &[T; #d], #momenta __first: ::core::primitive::usize, __found: &mut [T]) {
                #statements
                let __values = [#(#values),*];
                let mut __i: ::core::primitive::usize = 0;
                while __i < <[T]>::len(__found) && __first + __i < #count {
                    __found[__i] = __values[__first + __i];
                    __i += 1;
                }
            }
        }
    }

    /// The recurrences of the derivatives along a curve, for functions that are not too large for it.
    fn series(&self, which: Macro) -> TokenStream {
        let Some((of, method)) = which.series(self.sizes) else { return TokenStream::new() };
        let Some(routine) = self.routines.named(of) else { return TokenStream::new() };
        if self.routines.operations(&routine.roots) > LARGE {
            return TokenStream::new();
        }
        let Series { blocks, statements, results } =
            Series::of(self.emitter, &routine.roots, &which.spelling(self.sizes));
        let result = method.result.filled(&mut results.into_iter());
        let (signature, blocks) = (method.series_signature(), Literal::usize_unsuffixed(blocks));
        quote! {
            #[inline(always)]
            fn series(&self) -> ::core::option::Option<::core::primitive::usize> {
                ::core::option::Option::Some(#blocks)
            }

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
        let signature = method.signature();
        let Some(routine) = self.routines.named(method.name) else {
            return quote!(#signature { loop {} }); // a stub's, called by nobody
        };
        let roots = &routine.roots;
        let large = self.routines.operations(roots) > LARGE;
        let kernel = self.name();
        let arguments = method.arguments();
        let frame = Frame { kernel: &kernel, arguments: &arguments };
        let statements = self.emitter.body(roots, &which.spelling(self.sizes), large.then_some(&frame));
        let result = method.result.filled(&mut roots.iter().map(|&root| self.emitter.result(root)));
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
        kernel_name(self.item)
    }
}

/// The kernel's name. It is no name of the user's: what the compiler says of names it says of the struct's alone.
pub(crate) fn kernel_name(item: &Item) -> Ident {
    format_ident!("{}Kernel", item.name, span = Span::call_site())
}

pub(crate) fn components(path: TokenStream, shape: &[usize], list: &mut Vec<TokenStream>) {
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
