//! The functions of the language, one row each.
//!
//! ```text
//! name        how the user writes it; the methods of `Real` and of `Recurrences` (power series) have the same name
//! value       f(x) for f64
//! products    how many products its power series takes; the compiler holds this against the method of `Recurrences`
//! derivative  from the argument x and the result f, which is already known; g is the graph that it is written into
//! ```
//!
//! The table is a macro that hands its rows to another macro. So each module reads its own columns: this one reads
//! names, values and products, and `rules` reads derivatives; that column uses the names of `rules`.
//!
//! A row is all that most functions need in this crate. Two kinds need one more line: functions that are not smooth, or
//! differ on the two sides of an infinity, are listed in `kinks`, and two that are computed together (sine and cosine)
//! in `recurrence::pair`.

/// Hands the rows of the functions of one argument to the macro `$columns`.
macro_rules! functions_of_one {
    ($columns:ident) => {
        $columns! {
        //  variant name   value    products  derivative
            Sqrt  "sqrt",  f64::sqrt,  1,  |g, _, f| g.guarded_reciprocal(f).times(0.5);
            Cbrt  "cbrt",  f64::cbrt,  2,  |g, _, f| { let d = g.power(f, 4); g.guarded_reciprocal(d).times(THIRD) };
            Exp   "exp",   f64::exp,   1,  |_, _, f| f.into();
            Ln    "ln",    f64::ln,    1,  |g, x, _| g.slope_of_logarithm(x);
            Log10 "log10", f64::log10, 1,  |g, x, _| g.slope_of_logarithm(x).times(LOG10_E);
            Log2  "log2",  f64::log2,  1,  |g, x, _| g.slope_of_logarithm(x).times(LOG2_E);
            Sin   "sin",   f64::sin,   2,  |g, x, _| g.call(Function::Cos, x).into();
            Cos   "cos",   f64::cos,   2,  |g, x, _| Scaled::from(g.call(Function::Sin, x)).times(-1.0);
            Tan   "tan",   f64::tan,   2,  |g, _, f| g.shifted_square(1.0, f, 1.0);
            Asin  "asin",  f64::asin,  3,  |g, x, _| g.reciprocal_root(Graph::one_minus_square, x);
            Acos  "acos",  f64::acos,  3,  |g, x, _| g.reciprocal_root(Graph::one_minus_square, x).times(-1.0);
            Atan  "atan",  f64::atan,  2,  |g, x, _| { let d = g.shifted_square(1.0, x, 1.0); g.reciprocal_of(d) };
            Sinh  "sinh",  f64::sinh,  2,  |g, x, _| g.call(Function::Cosh, x).into();
            Cosh  "cosh",  f64::cosh,  2,  |g, x, _| g.call(Function::Sinh, x).into();
            Tanh  "tanh",  f64::tanh,  2,  |g, _, f| g.one_minus_square(f);
            Asinh "asinh", f64::asinh, 3,  |g, x, _| g.reciprocal_root(|g, x| g.shifted_square(1.0, x, 1.0), x);
            Acosh "acosh", f64::acosh, 3,  |g, x, _| { let d = g.reciprocal_root(Graph::square_minus_one, x); g.unless_negative(x, d) };
            Atanh "atanh", |x| x.abs().atanh().copysign(x), 2,  |g, x, _| g.reciprocal_within_one(x);
            Abs   "abs",   f64::abs,   1,  |g, x, _| g.signum(x);
            Sign  "sign",  sign,       1,  |_, _, _| Scaled::ZERO;
            Floor "floor", f64::floor, 1,  |_, _, _| Scaled::ZERO;
            Erf   "erf",   libm::erf,  3,  |g, x, _| g.bell(x).times(FRAC_2_SQRT_PI);
        }
    };
}
pub(crate) use functions_of_one;

/// Hands the rows of the functions of two arguments to the macro `$columns`.
///
/// `powf` takes its two products where the exponent stays; see `recurrence` for one that moves.
macro_rules! functions_of_two {
    ($columns:ident) => {
        $columns! {
        //  variant name   value    products  derivatives by a and by b
            Powf  "powf",  f64::powf,  2,  |g, a, b, f| g.slopes_of_power(a, b, f),
                "xʸ for an exponent that is no constant multiple of ½ or ⅓.";
            Atan2 "atan2", f64::atan2, 5,  |g, a, b, _| g.slopes_of_angle(a, b),
                "The angle of the point (x, y), written `atan2(y, x)`.";
            Hypot "hypot", f64::hypot, 3,  |g, a, b, f| g.slopes_of_distance(a, b, f),
                "√(x² + y²) without overflow on the way.";
        }
    };
}
pub(crate) use functions_of_two;

macro_rules! names_and_values {
    ($($variant:ident $name:literal, $value:expr, $products:literal, $derivative:expr;)*) => {
        /// A function of one argument.
        #[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
        #[allow(missing_docs, reason = "the name says it")]
        pub enum Function { $($variant),* }

        impl Function {
            /// All of them, in the order of the table.
            pub const ALL: &[Function] = &[$(Function::$variant),*];

            /// How the user writes it, and the method of `Real` that evaluates it.
            pub fn name(self) -> &'static str {
                match self { $(Function::$variant => $name),* }
            }
            /// f(x)
            pub fn evaluate(self, x: f64) -> f64 {
                let value: fn(f64) -> f64 = match self { $(Function::$variant => $value),* };
                value(x)
            }
            /// How many products its power series takes.
            pub(crate) fn products(self) -> usize {
                match self { $(Function::$variant => $products),* }
            }
        }
    };
}
functions_of_one!(names_and_values);

impl Function {
    /// The function of that name.
    pub fn named(name: &str) -> Option<Function> {
        Function::ALL.iter().copied().find(|function| function.name() == name)
    }
}

macro_rules! names_and_values_of_two {
    ($($variant:ident $name:literal, $value:expr, $products:literal, $derivatives:expr, $meaning:literal;)*) => {
        /// A function of two arguments that is one operation of the scalar.
        #[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
        pub enum Binary { $(#[doc = $meaning] $variant),* }

        impl Binary {
            /// All of them, in the order of the table.
            pub const ALL: &[Binary] = &[$(Binary::$variant),*];

            /// The method of `Real` that evaluates it.
            pub fn name(self) -> &'static str {
                match self { $(Binary::$variant => $name),* }
            }
            /// f(a, b)
            pub fn evaluate(self, a: f64, b: f64) -> f64 {
                let value: fn(f64, f64) -> f64 = match self { $(Binary::$variant => $value),* };
                value(a, b)
            }
            /// How many products its power series takes.
            pub(crate) fn products(self) -> usize {
                match self { $(Binary::$variant => $products),* }
            }
        }
    };
}
functions_of_two!(names_and_values_of_two);

/// −1, 0 or 1; NaN for NaN, as `Real::sign`.
fn sign(x: f64) -> f64 {
    if x > 0.0 {
        1.0
    } else if x < 0.0 {
        -1.0
    } else {
        x * 0.0
    }
}
