//! Builds changes of source files into them, all at once, each behind a number that is asked for when a program runs.
//! They are those of `cargo mutants`, and comparisons, selections, least and largest by method turned over.
//!
//! `switch LIST SKIP FILE…` rewrites the files in place, appends a row for each change to LIST, and leaves out those
//! whose numbers are in SKIP.

use quote::{ToTokens, quote};
use std::collections::BTreeSet;
use std::fmt::Write as _;
use syn::spanned::Spanned;
use syn::visit_mut::{self, VisitMut};
use syn::{BinOp, Block, Expr, Pat, ReturnType, Type, UnOp, parse_quote};

struct Switch {
    file: String,
    within: Vec<String>,
    next: u32,
    skip: BTreeSet<u32>,
    list: String,
}

impl Switch {
    /// A number for a change; none where it is left out.
    fn change(&mut self, at: proc_macro2::Span, what: &str) -> Option<u32> {
        self.next += 1;
        let n = self.next;
        if self.skip.contains(&n) {
            return None;
        }
        let what = what.split_whitespace().collect::<Vec<_>>().join(" ");
        let place = at.start();
        let _ = writeln!(
            self.list,
            "{n}\t{}:{}:{}\t{}\t{what}",
            self.file,
            place.line,
            place.column + 1,
            self.within.join("::")
        );
        Some(n)
    }

    fn function(&mut self, sig: &syn::Signature, attrs: &[syn::Attribute], block: &mut Block) {
        let is_test = attrs.iter().any(|a| a.path().is_ident("test"));
        if sig.constness.is_some() || is_test {
            return;
        }
        self.within.push(sig.ident.to_string());
        self.visit_block_mut(block);
        let mut values: Vec<Expr> = Vec::new();
        match &sig.output {
            ReturnType::Default => values.push(parse_quote!(())),
            ReturnType::Type(_, ty) => values_of(ty, &mut values),
        }
        if !block.stmts.is_empty() {
            for value in values.into_iter().rev() {
                let what = format!("the function → {}", value.to_token_stream());
                if let Some(n) = self.change(sig.ident.span(), &what) {
                    block.stmts.insert(0, parse_quote!(if crate::mutant::on(#n) { return #value; }));
                }
            }
        }
        self.within.pop();
    }
}

fn values_of(ty: &Type, values: &mut Vec<Expr>) {
    let text = ty.to_token_stream().to_string().replace(' ', "");
    match text.as_str() {
        "bool" => values.extend([parse_quote!(true), parse_quote!(false)]),
        "f64" => values.extend([parse_quote!(0.0), parse_quote!(1.0)]),
        "usize" | "u32" | "u64" => values.extend([parse_quote!(0), parse_quote!(1)]),
        "T" => values.extend([parse_quote!(T::from_f64(0.0)), parse_quote!(T::from_f64(1.0))]),
        "S" => values.extend([parse_quote!(S::from_f64(0.0)), parse_quote!(S::from_f64(1.0))]),
        _ if text.starts_with("Result<(),") => values.push(parse_quote!(Ok(()))),
        _ if text.starts_with("Result<bool,") => {
            values.extend([parse_quote!(Ok(true)), parse_quote!(Ok(false))])
        }
        _ if text.starts_with("Option<") => values.push(parse_quote!(None)),
        _ => {}
    }
}

/// What stands in for an operator.
fn others(op: &BinOp) -> Vec<BinOp> {
    match op {
        BinOp::Add(_) => vec![parse_quote!(-), parse_quote!(*)],
        BinOp::Sub(_) => vec![parse_quote!(+), parse_quote!(/)],
        BinOp::Mul(_) => vec![parse_quote!(+), parse_quote!(/)],
        BinOp::Div(_) => vec![parse_quote!(*)],
        BinOp::Rem(_) => vec![parse_quote!(/), parse_quote!(+)],
        BinOp::Eq(_) => vec![parse_quote!(!=)],
        BinOp::Ne(_) => vec![parse_quote!(==)],
        BinOp::Lt(_) => vec![parse_quote!(>), parse_quote!(<=)],
        BinOp::Gt(_) => vec![parse_quote!(<), parse_quote!(>=)],
        BinOp::Le(_) => vec![parse_quote!(>)],
        BinOp::Ge(_) => vec![parse_quote!(<)],
        BinOp::And(_) => vec![parse_quote!(||)],
        BinOp::Or(_) => vec![parse_quote!(&&)],
        BinOp::BitAnd(_) => vec![parse_quote!(|)],
        BinOp::BitOr(_) => vec![parse_quote!(&)],
        BinOp::BitXor(_) => vec![parse_quote!(|)],
        BinOp::AddAssign(_) => vec![parse_quote!(-=), parse_quote!(*=)],
        BinOp::SubAssign(_) => vec![parse_quote!(+=), parse_quote!(/=)],
        BinOp::MulAssign(_) => vec![parse_quote!(+=), parse_quote!(/=)],
        BinOp::DivAssign(_) => vec![parse_quote!(*=)],
        BinOp::BitAndAssign(_) => vec![parse_quote!(|=)],
        BinOp::BitOrAssign(_) => vec![parse_quote!(&=)],
        _ => vec![],
    }
}

fn has_let(e: &Expr) -> bool {
    match e {
        Expr::Let(_) => true,
        Expr::Binary(b) => matches!(b.op, BinOp::And(_)) && (has_let(&b.left) || has_let(&b.right)),
        Expr::Paren(p) => has_let(&p.expr),
        _ => false,
    }
}

impl VisitMut for Switch {
    fn visit_item_fn_mut(&mut self, f: &mut syn::ItemFn) {
        let (sig, attrs) = (f.sig.clone(), f.attrs.clone());
        self.function(&sig, &attrs, &mut f.block);
    }
    fn visit_impl_item_fn_mut(&mut self, f: &mut syn::ImplItemFn) {
        let (sig, attrs) = (f.sig.clone(), f.attrs.clone());
        self.function(&sig, &attrs, &mut f.block);
    }
    fn visit_trait_item_fn_mut(&mut self, f: &mut syn::TraitItemFn) {
        let (sig, attrs) = (f.sig.clone(), f.attrs.clone());
        if let Some(block) = &mut f.default {
            self.function(&sig, &attrs, block);
        }
    }
    fn visit_item_impl_mut(&mut self, i: &mut syn::ItemImpl) {
        let name = i.self_ty.to_token_stream().to_string();
        self.within.push(name.split_whitespace().next().unwrap_or("").to_string());
        visit_mut::visit_item_impl_mut(self, i);
        self.within.pop();
    }
    fn visit_item_mod_mut(&mut self, m: &mut syn::ItemMod) {
        if !m.attrs.iter().any(|a| a.to_token_stream().to_string().contains("test")) {
            visit_mut::visit_item_mod_mut(self, m);
        }
    }
    fn visit_item_const_mut(&mut self, _: &mut syn::ItemConst) {}
    fn visit_item_static_mut(&mut self, _: &mut syn::ItemStatic) {}
    fn visit_impl_item_const_mut(&mut self, _: &mut syn::ImplItemConst) {}
    fn visit_trait_item_const_mut(&mut self, _: &mut syn::TraitItemConst) {}
    fn visit_type_mut(&mut self, _: &mut Type) {}
    fn visit_attribute_mut(&mut self, _: &mut syn::Attribute) {}
    fn visit_pat_mut(&mut self, _: &mut Pat) {}
    fn visit_expr_repeat_mut(&mut self, e: &mut syn::ExprRepeat) {
        self.visit_expr_mut(&mut e.expr);
    }
    fn visit_generic_argument_mut(&mut self, _: &mut syn::GenericArgument) {}

    fn visit_expr_match_mut(&mut self, m: &mut syn::ExprMatch) {
        visit_mut::visit_expr_match_mut(self, m);
        let wild = match m.arms.last().map(|a| &a.pat) {
            Some(Pat::Wild(_)) => true,
            Some(Pat::Ident(i)) => i.ident.to_string().starts_with(char::is_lowercase),
            _ => false,
        };
        let last = m.arms.len().saturating_sub(1);
        for (i, arm) in m.arms.iter_mut().enumerate() {
            if let Some((_, guard)) = &mut arm.guard {
                if has_let(guard) {
                    continue;
                }
                let (a, b) = (
                    self.change(guard.span(), &format!("guard {} → true", guard.to_token_stream())),
                    self.change(guard.span(), &format!("guard {} → false", guard.to_token_stream())),
                );
                let (a, b) = (a.unwrap_or(0), b.unwrap_or(0));
                *guard = Box::new(parse_quote!(crate::mutant::on(#a) || !crate::mutant::on(#b) && (#guard)));
            } else if wild && i < last {
                let what = format!("match arm {} left out", arm.pat.to_token_stream());
                if let Some(n) = self.change(arm.pat.span(), &what) {
                    arm.guard = Some((Default::default(), Box::new(parse_quote!(!crate::mutant::on(#n)))));
                }
            }
        }
    }

    fn visit_expr_mut(&mut self, e: &mut Expr) {
        if matches!(e, Expr::Const(_) | Expr::Macro(_)) {
            return;
        }
        let before = e.to_token_stream().to_string();
        visit_mut::visit_expr_mut(self, e);
        let short: String = before.chars().take(160).collect();
        match e {
            Expr::Binary(b) => {
                if has_let(&b.left) || has_let(&b.right) {
                    return;
                }
                let mut arms = quote!();
                let at = b.op.span();
                let (l, r) = (&b.left, &b.right);
                let lazy = matches!(b.op, BinOp::And(_) | BinOp::Or(_));
                let compares = matches!(
                    b.op,
                    BinOp::Eq(_) | BinOp::Ne(_) | BinOp::Lt(_) | BinOp::Gt(_) | BinOp::Le(_) | BinOp::Ge(_)
                );
                let name = b.op.to_token_stream().to_string();
                let assigns = name.len() > 1 && name.ends_with('=') && !compares;
                let mut any = false;
                for other in others(&b.op) {
                    let what = format!("{} → {} in {short}", name, other.to_token_stream());
                    if let Some(n) = self.change(at, &what) {
                        any = true;
                        let changed = if lazy || assigns { quote!(#l #other #r) } else { quote!(l #other r) };
                        arms = quote!(#arms if crate::mutant::on(#n) { #changed } else);
                    }
                }
                if !any {
                    return;
                }
                let op = &b.op;
                let whole = if lazy || assigns {
                    quote!((#arms { #l #op #r }))
                } else if compares {
                    quote!((match (&(#l), &(#r)) { (l, r) => #arms { l #op r } }))
                } else {
                    quote!((match (#l, #r) { (l, r) => #arms { l #op r } }))
                };
                *e = syn::parse2(whole).expect("an expression");
            }
            Expr::Unary(u) if matches!(u.op, UnOp::Not(_) | UnOp::Neg(_)) => {
                let name = u.op.to_token_stream().to_string();
                if let Some(n) = self.change(u.op.span(), &format!("{name} left out in {short}")) {
                    let (op, inner) = (&u.op, &u.expr);
                    *e = if matches!(op, UnOp::Not(_)) {
                        parse_quote!((if crate::mutant::on(#n) { #inner } else { !#inner }))
                    } else {
                        parse_quote!((match #inner { x => if crate::mutant::on(#n) { x } else { -x } }))
                    };
                }
            }
            Expr::MethodCall(m) if m.args.len() == 1 && m.turbofish.is_none() => {
                let (x, y, name) = (&m.receiver, &m.args[0], m.method.to_string());
                let changed: Option<proc_macro2::TokenStream> = match name.as_str() {
                    "le" => Some(quote!(y.lt(x))),
                    "lt" => Some(quote!(y.le(x))),
                    "min" => Some(quote!(x.max(y))),
                    "max" => Some(quote!(x.min(y))),
                    _ => None,
                };
                if let Some(changed) = changed
                    && let Some(n) = self.change(m.method.span(), &format!("{name} turned over in {short}"))
                {
                    let method = &m.method;
                    *e = parse_quote!((match (#x, #y) {
                        (x, y) => if crate::mutant::on(#n) { #changed } else { x.#method(y) }
                    }));
                }
            }
            Expr::Call(c)
                if c.args.len() == 3 && c.func.to_token_stream().to_string().ends_with(":: select") =>
            {
                if let Some(n) = self.change(c.func.span(), &format!("select turned over in {short}")) {
                    let (f, m, a, b) = (&c.func, &c.args[0], &c.args[1], &c.args[2]);
                    *e = parse_quote!((match (#m, #a, #b) {
                        (m, a, b) => if crate::mutant::on(#n) { #f(m, b, a) } else { #f(m, a, b) }
                    }));
                }
            }
            _ => {}
        }
    }
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let skip = std::fs::read_to_string(&arguments[1]).unwrap_or_default();
    let skip = skip.split_whitespace().map(|n| n.parse().expect("a number")).collect();
    let mut switch = Switch { file: String::new(), within: vec![], next: 0, skip, list: String::new() };
    for file in &arguments[2..] {
        let text = std::fs::read_to_string(file).expect("a file");
        let mut tree = syn::parse_file(&text).expect("Rust");
        switch.file = file.clone();
        switch.visit_file_mut(&mut tree);
        std::fs::write(file, tree.to_token_stream().to_string()).expect("written");
    }
    std::fs::write(&arguments[0], switch.list).expect("a list");
}
