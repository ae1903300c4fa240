//! The operations of expressions, each with the numbers of its operands.

use crate::functions::{Binary, Function};

/// A node of a graph.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub struct Id(pub(crate) u32);

impl Id {
    pub(crate) fn index(self) -> usize {
        self.0 as usize
    }
}

/// An input of an expression, given when the expression is evaluated.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub enum Input {
    /// A field of the user's struct.
    Parameter(u32),
    /// A coordinate q.
    Variable(u32),
    /// A component of the direction v.
    Direction(u32),
    /// A weight λ, one per equation.
    Weight(u32),
}

/// The comparison of a branch.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub enum Comparison {
    /// `a < b`
    Less,
    /// `a ≤ b`
    LessOrEqual,
}

/// One operation.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub enum Node {
    /// A number, by its bits: +0 and −0 differ.
    Constant(u64),
    /// An input.
    Input(Input),
    /// −a
    Neg(Id),
    /// a + b
    Add(Id, Id),
    /// a − b
    Sub(Id, Id),
    /// a · b
    Mul(Id, Id),
    /// a / b
    Div(Id, Id),
    /// a^(n/2) with the given n, neither 0, 1 nor 2.
    Power(Id, i32),
    /// f(a)
    Call(Function, Id),
    /// f(a, b)
    Call2(Binary, Id, Id),
    /// The fourth field where the comparison of the second and third holds, else the fifth.
    Select(Comparison, Id, Id, Id, Id),
    /// Σ cᵢ aᵢ, the coefficients by their bits. Only in derivatives.
    Sum(Box<[(u64, Id)]>),
    /// Π aᵢ^nᵢ. Only in derivatives.
    Product(Box<[(Id, u32)]>),
}

impl Node {
    /// The nodes from which this one is computed.
    pub fn children(&self) -> Vec<Id> {
        match *self {
            Node::Constant(_) | Node::Input(_) => vec![],
            Node::Neg(a) | Node::Power(a, _) | Node::Call(_, a) => vec![a],
            Node::Add(a, b) | Node::Sub(a, b) | Node::Mul(a, b) | Node::Div(a, b) | Node::Call2(_, a, b) => {
                vec![a, b]
            }
            Node::Select(_, a, b, then, other) => vec![a, b, then, other],
            Node::Sum(ref terms) => terms.iter().map(|&(_, a)| a).collect(),
            Node::Product(ref factors) => factors.iter().map(|&(a, _)| a).collect(),
        }
    }
}
