//! Runs what the macro has written: Rust's syntax tree, as far as macros write it.

use rattle_symbolic::functions::{Binary, Function};
use rattle_symbolic::{Macro, expand};
use std::collections::HashMap;
use syn::{Expr, ImplItem, Item, Lit, Pat, Stmt};

/// What the interpreter computes with.
#[derive(Clone, Debug)]
enum Value {
    Number(f64),
    Flag(bool),
    List(Vec<Value>),
    Nothing,
}

impl Value {
    fn number(&self) -> f64 {
        match self {
            Value::Number(x) => *x,
            other => panic!("{other:?} is no number"),
        }
    }
    fn numbers(&self) -> Vec<f64> {
        match self {
            Value::List(list) => list.iter().flat_map(Value::numbers).collect(),
            other => vec![other.number()],
        }
    }
    fn list(numbers: &[f64]) -> Value {
        Value::List(numbers.iter().map(|&x| Value::Number(x)).collect())
    }
}

/// The element of a list, without a copy of all of it.
trait At {
    fn cloned_at(self, place: usize) -> Option<Value>;
}

impl At for Option<&Value> {
    fn cloned_at(self, place: usize) -> Option<Value> {
        match self? {
            Value::List(list) => list.get(place).cloned(),
            _ => None,
        }
    }
}

type Names = HashMap<String, Value>;

/// The generated items: the fields of the kernel and the functions.
pub(crate) struct Generated {
    functions: HashMap<String, syn::ImplItemFn>,
    fields: Names,
}

impl Generated {
    pub(crate) fn new(input: &str, a: f64, n: [f64; 2]) -> Result<Generated, String> {
        let output = expand(Macro::Constraint, input.parse().expect("tokens"));
        let text = output.to_string();
        if text.contains("compile_error") {
            return Err(text[text.find("compile_error").unwrap_or(0)..].chars().take(300).collect());
        }
        let file: syn::File = syn::parse2(output).expect("items");
        let Some(Item::Const(hidden)) = file.items.into_iter().nth(1) else {
            panic!("a struct, then a const")
        };
        let Expr::Block(block) = *hidden.expr else { panic!("a block") };
        let mut functions = HashMap::new();
        for statement in block.block.stmts {
            let Stmt::Item(Item::Impl(item)) = statement else { continue };
            for item in item.items {
                if let ImplItem::Fn(function) = item {
                    functions.insert(function.sig.ident.to_string(), function);
                }
            }
        }
        let mut generated = Generated { functions, fields: Names::new() };
        let parameters = Names::from([("a".to_owned(), Value::Number(a)), ("n".to_owned(), Value::list(&n))]);
        let made = generated.functions.remove("kernel_of_lanes").expect("a constructor").block;
        let mut names = parameters;
        let Some((Stmt::Expr(Expr::Struct(kernel), None), statements)) = made.stmts.split_last() else {
            panic!("a kernel at the end")
        };
        generated.run(statements, &mut names);
        for field in &kernel.fields {
            if let syn::Member::Named(name) = &field.member
                && name != "scalar"
            {
                let value = generated.value(&field.expr, &mut names);
                generated.fields.insert(name.to_string(), value);
            }
        }
        Ok(generated)
    }

    pub(crate) fn call(&self, function: &str, arguments: &[(&str, &[f64])]) -> Vec<f64> {
        let mut names: Names =
            arguments.iter().map(|(name, list)| (format!("__{name}"), Value::list(list))).collect();
        self.run(&self.functions[function].block.stmts, &mut names).numbers()
    }

    fn run(&self, statements: &[Stmt], names: &mut Names) -> Value {
        let mut last = Value::Nothing;
        let mut chapter = None;
        for statement in statements {
            last = match statement {
                Stmt::Local(local) => {
                    let init = local.init.as_ref().expect("a value");
                    let value = self.value(&init.expr, names);
                    bind(&local.pat, value, names);
                    Value::Nothing
                }
                Stmt::Item(Item::Fn(function)) => {
                    chapter = Some(function);
                    Value::Nothing
                }
                Stmt::Expr(Expr::Call(_), Some(_)) => {
                    // A chapter sees the arguments and the memory, and no temporary of its callers.
                    let mut own = names.clone();
                    own.retain(|name, _| !name.starts_with("__t"));
                    self.run(&chapter.expect("a function before its call").block.stmts, &mut own);
                    let kept = own.into_iter().filter(|(name, _)| name.ends_with("memory"));
                    names.extend(kept);
                    Value::Nothing
                }
                Stmt::Expr(expr, _) => self.value(expr, names),
                _ => panic!("no such statement"),
            };
        }
        last
    }

    fn value(&self, expr: &Expr, names: &mut Names) -> Value {
        let mut all =
            |list: &mut dyn Iterator<Item = &Expr>| Value::List(list.map(|e| self.value(e, names)).collect());
        match expr {
            Expr::Array(array) => all(&mut array.elems.iter()),
            Expr::Tuple(tuple) => all(&mut tuple.elems.iter()),
            Expr::Paren(inner) => self.value(&inner.expr, names),
            Expr::Block(block) => self.run(&block.block.stmts, names),
            Expr::Path(path) => {
                let name = path.path.segments[path.path.segments.len() - 1].ident.to_string();
                match &name[..] {
                    "INFINITY" => Value::Number(f64::INFINITY),
                    "NAN" => Value::Number(f64::NAN),
                    _ => names[&name].clone(),
                }
            }
            Expr::Lit(literal) => match &literal.lit {
                Lit::Float(x) => Value::Number(x.base10_parse().expect("a number")),
                Lit::Int(x) => Value::Number(x.base10_parse().expect("a number")),
                _ => panic!("no such literal"),
            },
            Expr::Unary(unary) => Value::Number(-self.value(&unary.expr, names).number()),
            Expr::Binary(binary) => {
                let [a, b] = [&binary.left, &binary.right].map(|side| self.value(side, names).number());
                Value::Number(match binary.op {
                    syn::BinOp::Add(_) => a + b,
                    syn::BinOp::Sub(_) => a - b,
                    syn::BinOp::Mul(_) => a * b,
                    syn::BinOp::Div(_) => a / b,
                    _ => panic!("no such operator"),
                })
            }
            Expr::Index(index) => {
                let place = self.value(&index.index, names).number() as usize;
                let inside = match &*index.expr {
                    Expr::Path(path) => names.get(&path.path.segments[0].ident.to_string()).cloned_at(place),
                    other => Some(&self.value(other, names)).cloned_at(place),
                };
                inside.expect("a component")
            }
            Expr::Repeat(repeat) => {
                let count = self.value(&repeat.len, names).number() as usize;
                Value::List(vec![self.value(&repeat.expr, names); count])
            }
            Expr::Assign(assign) => {
                let value = self.value(&assign.right, names);
                let Expr::Index(index) = &*assign.left else { panic!("a place in the memory") };
                let place = self.value(&index.index, names).number() as usize;
                let Expr::Path(path) = &*index.expr else { panic!("the memory") };
                match names.get_mut(&path.path.segments[0].ident.to_string()) {
                    Some(Value::List(list)) => list[place] = value,
                    _ => panic!("the memory"),
                }
                Value::Nothing
            }
            Expr::Field(field) => {
                let syn::Member::Named(name) = &field.member else { panic!("a name") };
                let owner = &*field.base;
                match owner {
                    Expr::Call(_) => names[&name.to_string()].clone(), // __lane(__i).a
                    _ => self.fields[&name.to_string()].clone(),
                }
            }
            Expr::MethodCall(call) => {
                let name = call.method.to_string();
                let x = self.value(&call.receiver, names).number();
                if name == "sin_cos" {
                    return Value::list(&[x.sin(), x.cos()]);
                }
                match Function::named(&name) {
                    Some(function) => Value::Number(function.evaluate(x)),
                    None if name == "multiply_add" => {
                        let [b, c] = [0, 1].map(|i| self.value(&call.args[i], names).number());
                        Value::Number(x * b + c)
                    }
                    None => {
                        let binary =
                            Binary::ALL.iter().find(|binary| binary.name() == name).expect("a function");
                        Value::Number(binary.evaluate(x, self.value(&call.args[0], names).number()))
                    }
                }
            }
            Expr::Call(call) => {
                let Expr::Path(path) = &*call.func else { panic!("a function by name") };
                let name = path.path.segments.last().expect("a name").ident.to_string();
                if name == "from_lanes" {
                    let Expr::Closure(closure) = &call.args[0] else { panic!("a closure") };
                    return self.value(&closure.body, names);
                }
                let values: Vec<Value> =
                    call.args.iter().map(|argument| self.value(argument, names)).collect();
                match (&*name, &values[..]) {
                    ("from_f64", [x]) => x.clone(),
                    ("lt", [a, b]) => Value::Flag(a.number() < b.number()),
                    ("le", [a, b]) => Value::Flag(a.number() <= b.number()),
                    ("select", [Value::Flag(flag), a, b]) => {
                        if *flag {
                            a.clone()
                        } else {
                            b.clone()
                        }
                    }
                    _ => panic!("no function `{name}`"),
                }
            }
            _ => panic!("no such expression"),
        }
    }
}

fn bind(pattern: &Pat, value: Value, names: &mut Names) {
    match (pattern, value) {
        (Pat::Ident(name), value) => {
            names.insert(name.ident.to_string(), value);
        }
        (
            Pat::Tuple(syn::PatTuple { elems, .. }) | Pat::Slice(syn::PatSlice { elems, .. }),
            Value::List(list),
        ) => {
            assert_eq!(elems.len(), list.len());
            elems.iter().zip(list).for_each(|(pattern, value)| bind(pattern, value, names));
        }
        _ => panic!("no such pattern"),
    }
}
