//! Records: everything that a run needs to continue, as named numbers, in the order in which they are read again.
//!
//! A simulation or ensemble writes a [`Record`] of itself, and continues from one bit for bit. A record is a list of
//! [fields](Field), each with a name, a shape and numbers of one kind. How a record is stored, for example in a file,
//! is left to its user.

use crate::error::{Error, RecordMistake};

/// Numbers that differ by more than this part of their size come from another scene. On one machine they are the same;
/// the libraries of two differ by some roundings, which a difference near a constraint makes 10³ times as large. Where
/// terms cancel they make it larger, as far as roundings of places do: see [`Hallmark::allow`].
const SAME: f64 = 1e-10;
/// So many times what roundings of places make of a number is allowed.
const ALLOWED: f64 = 16.0;
/// What stands in files in the place of the name of a type, for parts that have none. No message shows it.
const NAMELESS: [&str; 3] = ["a list", "a function", "a surface"];

/// Numbers of one kind.
#[derive(Debug, Clone, PartialEq)]
pub enum Data {
    /// Lengths, momenta, times.
    Numbers(Vec<f64>),
    /// Step counts, indices, bits.
    Counts(Vec<u64>),
    /// A name.
    Text(String),
}

impl Data {
    /// The number of entries; of a text, of bytes.
    #[must_use]
    pub fn len(&self) -> usize {
        match self {
            Self::Numbers(numbers) => numbers.len(),
            Self::Counts(counts) => counts.len(),
            Self::Text(text) => text.len(),
        }
    }

    /// Whether it has no entries.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    fn kind(&self) -> &'static str {
        match self {
            Self::Numbers(_) => "numbers",
            Self::Counts(_) => "counts",
            Self::Text(_) => "text",
        }
    }
}

/// Numbers with a name and a shape, the last index fastest.
#[derive(Debug, Clone, PartialEq)]
pub struct Field {
    /// The name, after the part to which it belongs, as in `group 2/q`.
    pub name: String,
    /// The extent along each index.
    pub shape: Vec<usize>,
    /// The numbers.
    pub data: Data,
}

impl Field {
    fn described(&self) -> String {
        let Self { name, shape, data } = self;
        let with = if self.is_whole() { String::new() } else { format!(" with {} entries", data.len()) };
        format!("`{name}`, {} of shape {shape:?}{with}", data.kind())
    }

    /// Whether there are as many entries as the shape says.
    fn is_whole(&self) -> bool {
        self.shape.iter().try_fold(1_usize, |all, &n| all.checked_mul(n)) == Some(self.data.len())
    }
}

/// A list of fields.
#[doc(alias = "dump")]
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Record {
    fields: Vec<Field>,
    within: String,
}

impl Record {
    /// A record of these fields.
    #[must_use]
    pub fn of(fields: Vec<Field>) -> Self {
        Self { fields, within: String::new() }
    }

    /// The fields in order.
    #[must_use]
    pub fn fields(&self) -> &[Field] {
        &self.fields
    }

    /// The field of this name.
    #[must_use]
    pub fn field(&self, name: &str) -> Option<&Field> {
        self.fields.iter().find(|field| field.name == name)
    }

    /// Adds numbers, as many as the shape says.
    pub fn numbers(&mut self, name: &str, shape: &[usize], numbers: impl IntoIterator<Item = f64>) {
        self.add(name, shape, Data::Numbers(numbers.into_iter().collect()));
    }

    /// Adds a list of numbers.
    pub(crate) fn list(&mut self, name: &str, numbers: &[f64]) {
        self.add(name, &[numbers.len()], Data::Numbers(numbers.into()));
    }

    /// Adds vectors of D numbers each.
    pub fn vectors<const D: usize>(&mut self, name: &str, vectors: &[[f64; D]]) {
        self.add(name, &[vectors.len(), D], Data::Numbers(vectors.as_flattened().into()));
    }

    /// Adds a list of counts.
    pub fn counts(&mut self, name: &str, counts: impl IntoIterator<Item = u64>) {
        let counts = counts.into_iter().collect::<Vec<_>>();
        self.add(name, &[counts.len()], Data::Counts(counts));
    }

    /// Adds a text.
    pub fn text(&mut self, name: &str, text: &str) {
        self.add(name, &[text.len()], Data::Text(text.into()));
    }

    /// Calls `write`; the names of the fields that it adds begin with `part` and a slash.
    pub fn within(&mut self, part: &str, write: impl FnOnce(&mut Self)) {
        let length = self.within.len();
        self.within.push_str(part);
        self.within.push('/');
        write(self);
        self.within.truncate(length);
    }

    /// A reader of the fields in order.
    #[must_use]
    pub fn read(&self) -> Reading<'_> {
        Reading { rest: &self.fields, within: String::new() }
    }

    fn add(&mut self, name: &str, shape: &[usize], data: Data) {
        debug_assert_eq!(shape.iter().product::<usize>(), data.len(), "{name}");
        self.fields.push(Field { name: format!("{}{name}", self.within), shape: shape.into(), data });
    }
}

/// Reads fields in order.
#[derive(Debug, Clone)]
pub struct Reading<'a> {
    rest: &'a [Field],
    within: String,
}

impl<'a> Reading<'a> {
    /// The numbers of the next field, which must have this name and shape.
    ///
    /// # Errors
    /// [`Error::Record`] if the next field is another one.
    pub fn numbers(&mut self, name: &str, shape: &[usize]) -> Result<&'a [f64], Error> {
        let wanted = || format!("numbers of shape {shape:?}");
        match self.next(name, wanted)? {
            Field { shape: is, data: Data::Numbers(numbers), .. } if is == shape => Ok(numbers),
            field => Err(self.other(name, wanted, Some(field))),
        }
    }

    /// Whether the next field has this name.
    pub(crate) fn is_next(&self, name: &str) -> bool {
        self.rest.first().is_some_and(|field| field.name.strip_prefix(&self.within) == Some(name))
    }

    /// Passes over the next field if it has this name: one that was written before, and is not needed any more.
    pub(crate) fn pass_over(&mut self, name: &str) {
        if self.is_next(name) {
            self.rest = &self.rest[1..];
        }
    }

    /// Copies the numbers of the next field, of which there must be as many, to there.
    pub(crate) fn copy(&mut self, name: &str, to: &mut [f64]) -> Result<(), Error> {
        to.copy_from_slice(self.numbers(name, &[to.len()])?);
        Ok(())
    }

    /// The next field, of `N` numbers.
    ///
    /// # Errors
    /// As [`numbers`](Self::numbers).
    pub fn array<const N: usize>(&mut self, name: &str) -> Result<[f64; N], Error> {
        let numbers = self.numbers(name, &[N])?;
        Ok(std::array::from_fn(|i| numbers[i]))
    }

    /// The next field, of `number` vectors of D numbers.
    ///
    /// # Errors
    /// As [`numbers`](Self::numbers).
    pub fn vectors<const D: usize>(&mut self, name: &str, number: usize) -> Result<&'a [[f64; D]], Error> {
        Ok(self.numbers(name, &[number, D])?.as_chunks().0)
    }

    /// The counts of the next field, which must have this name.
    ///
    /// # Errors
    /// As [`numbers`](Self::numbers).
    pub fn counts(&mut self, name: &str) -> Result<&'a [u64], Error> {
        let wanted = || "counts".into();
        match self.next(name, wanted)? {
            Field { data: Data::Counts(counts), .. } => Ok(counts),
            field => Err(self.other(name, wanted, Some(field))),
        }
    }

    /// The next field, of `N` counts.
    ///
    /// # Errors
    /// As [`numbers`](Self::numbers).
    pub fn counted<const N: usize>(&mut self, name: &str) -> Result<[u64; N], Error> {
        let wanted = || format!("counts of shape [{N}]");
        match self.next(name, wanted)? {
            Field { data: Data::Counts(counts), .. } if counts.len() == N => {
                Ok(std::array::from_fn(|i| counts[i]))
            }
            field => Err(self.other(name, wanted, Some(field))),
        }
    }

    /// The text of the next field, which must have this name.
    ///
    /// # Errors
    /// As [`numbers`](Self::numbers).
    pub fn text(&mut self, name: &str) -> Result<&'a str, Error> {
        let wanted = || "text".into();
        match self.next(name, wanted)? {
            Field { data: Data::Text(text), .. } => Ok(text),
            field => Err(self.other(name, wanted, Some(field))),
        }
    }

    /// Checks by the first field that the record is of this kind.
    ///
    /// # Errors
    /// [`RecordMistake::Another`] if it is of another.
    pub fn expect(&mut self, here: &str) -> Result<(), Error> {
        let file = self.text("what")?;
        if file == here {
            return Ok(());
        }
        let (part, file, here) = ("kind".into(), file.into(), here.into());
        Err(Error::Record(RecordMistake::Another { part, file, here }))
    }

    /// Calls `read`; the names of the fields that it reads begin with `part` and a slash.
    ///
    /// # Errors
    /// As [`numbers`](Self::numbers).
    pub fn within<X>(
        &mut self,
        part: &str,
        read: impl FnOnce(&mut Self) -> Result<X, Error>,
    ) -> Result<X, Error> {
        let length = self.within.len();
        self.within.push_str(part);
        self.within.push('/');
        let found = read(self);
        self.within.truncate(length);
        found
    }

    /// Checks that the next fields were written by the same parts of scene and method.
    ///
    /// # Errors
    /// [`RecordMistake::Another`] names the first that differs.
    pub fn same(&mut self, here: &[Hallmark]) -> Result<(), Error> {
        for mark @ Hallmark { part, name, numbers, sizes, is_later } in here {
            let another = |file: String, here: String| {
                Err(Error::Record(RecordMistake::Another { part: part.clone(), file, here }))
            };
            let Ok(its_name) = self.text(&format!("{part} is")) else {
                if *is_later {
                    continue;
                }
                let next = self.rest.first().map_or("none", |field| &field.name);
                return another(format!("one that has none (`{next}` comes next)"), name.clone());
            };
            if its_name != name {
                return another(its_name.into(), name.clone());
            }
            let Some((Field { data: Data::Numbers(its), .. }, rest)) = self.rest.split_first() else {
                return another(format!("{name} without numbers"), name.clone());
            };
            self.rest = rest;
            if let Some(i) = first_other(its, numbers, sizes) {
                return another(mark.told(its, i), mark.told(numbers, i));
            }
        }
        Ok(())
    }

    fn next(&mut self, name: &str, wanted: impl Fn() -> String) -> Result<&'a Field, Error> {
        match self.rest.split_first() {
            Some((field, rest))
                if field.name.strip_prefix(&self.within) == Some(name) && field.is_whole() =>
            {
                self.rest = rest;
                Ok(field)
            }
            other => Err(self.other(name, wanted, other.map(|(field, _)| field))),
        }
    }

    fn other(&self, name: &str, wanted: impl Fn() -> String, found: Option<&Field>) -> Error {
        let wanted = format!("`{}{name}`, {},", self.within, wanted());
        let found = found.map_or("nothing more".into(), Field::described);
        Error::Record(RecordMistake::Field { wanted, found })
    }
}

/// What distinguishes a part of a scene or method: its name, and some of its numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct Hallmark {
    /// Which part: "method", "constraints", "effect 0".
    pub part: String,
    /// The name of its type.
    pub name: String,
    /// Its parameters, or its values at and near the positions in the record.
    pub numbers: Vec<f64>,
    /// By which size each of them is compared, if its own is not larger: that of the largest of a vector, beside which
    /// the others may be roundings, or of what is lost where terms cancel.
    pub sizes: Vec<f64>,
    /// Whether records of before lack it, and are read all the same.
    pub is_later: bool,
}

impl Hallmark {
    /// The hallmark of this part by values of its functions, compared by the size of the largest.
    pub fn new(part: impl Into<String>, name: impl Into<String>, numbers: Vec<f64>) -> Self {
        Self::of_vectors(part, name, &[&numbers])
    }

    /// The hallmark of this part by vectors, each of which is compared by the size of its own largest number.
    pub fn of_vectors(part: impl Into<String>, name: impl Into<String>, vectors: &[&[f64]]) -> Self {
        let sizes = vectors.iter().flat_map(|vector| {
            let finite = vector.iter().filter(|x| x.is_finite());
            let largest = finite.fold(0.0_f64, |most, x| most.max(x.abs()));
            vector.iter().map(move |_| largest)
        });
        let (sizes, numbers) = (sizes.collect(), vectors.concat());
        Self { part: part.into(), name: name.into(), numbers, sizes, is_later: false }
    }

    /// The hallmark of this part by its parameters, or by other numbers that are compared by the size of each.
    pub fn of_parameters(part: impl Into<String>, name: impl Into<String>, numbers: Vec<f64>) -> Self {
        let sizes = vec![0.0; numbers.len()];
        Self { part: part.into(), name: name.into(), numbers, sizes, is_later: false }
    }

    /// The same, of which records of before do not tell.
    #[must_use]
    pub fn later(self) -> Self {
        Self { is_later: true, ..self }
    }

    /// Adds the numbers of another one, of the same part of another trajectory.
    pub fn extend(&mut self, other: Self) {
        self.numbers.extend(other.numbers);
        self.sizes.extend(other.sizes);
    }

    /// Allows some times the difference from what it is at places that are rounded otherwise. Where forces cancel,
    /// roundings are all that is left of them.
    pub fn allow(&mut self, rounded: &Self) {
        for ((size, x), y) in self.sizes.iter_mut().zip(&self.numbers).zip(&rounded.numbers) {
            let lost = ALLOWED * (x - y).abs() / SAME;
            if lost.is_finite() {
                *size = size.max(lost);
            }
        }
    }

    /// What a message says of it if this one of its numbers is another.
    fn told(&self, numbers: &[f64], i: usize) -> String {
        let Self { part, name, .. } = self;
        match numbers.get(i) {
            Some(x) if NAMELESS.contains(&&**name) && self.is_later => format!("one with {part} of {x:?}"),
            Some(x) if NAMELESS.contains(&&**name) => format!("one with {part} of {x:?} near its places"),
            Some(x) => format!("{name} with {x:?}"),
            None => format!("{name} of {} numbers", numbers.len()),
        }
    }

    /// Writes the fields that [`Reading::same`] compares.
    pub fn write(&self, to: &mut Record) {
        to.text(&format!("{} is", self.part), &self.name);
        to.list(&self.part, &self.numbers);
    }
}

/// The first number that is not the same but for rounding, of itself or of this size; of lists of different lengths the
/// first that is missing.
fn first_other(a: &[f64], b: &[f64], sizes: &[f64]) -> Option<usize> {
    let near = |a: f64, b: f64, size: f64| {
        let size = size.max(a.abs()).max(b.abs());
        (a - b).is_finite() && (a - b).abs() <= SAME * size
    };
    let same =
        |((&a, &b), &size): ((&f64, &f64), &f64)| a == b || (a.is_nan() && b.is_nan()) || near(a, b, size);
    let other = a.iter().zip(b).zip(sizes).position(|pair| !same(pair));
    other.or((a.len() != b.len()).then(|| a.len().min(b.len())))
}

/// The name of a type without its modules: `Each<Sphere>`.
#[must_use]
pub fn short_name(path: &str) -> String {
    let mut short = String::new();
    for piece in path.split_inclusive(|c: char| !(c.is_alphanumeric() || "_:".contains(c))) {
        short.push_str(piece.rsplit("::").next().unwrap_or(piece));
    }
    short
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_lose_their_modules_alone() {
        assert_eq!(short_name("a::b::Each<c::Sphere, [f64; 3]>"), "Each<Sphere, [f64; 3]>");
        assert_eq!(short_name("Rattle"), "Rattle");
    }

    #[test]
    fn what_differs_is_named() {
        let part = |g: f64| Hallmark::new("effect 0", "Gravity", vec![1.0, g]);
        let mut record = Record::default();
        record.within("scene", |record| part(2.0).write(record));
        let same = |part: Hallmark| record.read().within("scene", |reading| reading.same(&[part]));
        assert!(same(part(2.0 + 1e-12)).is_ok());
        assert!(
            same(part(2.1))
                .unwrap_err()
                .to_string()
                .contains("(effect 0): it was written by Gravity with 2.0")
        );
        let other = Hallmark::new("effect 0", "Weight", vec![1.0, 2.0]);
        assert!(same(other).unwrap_err().to_string().contains("by Gravity, and here is Weight"));
        assert!(same(Hallmark::new("effect 0", "Gravity", vec![1.0])).is_err());
        assert!(record.read().numbers("q", &[1]).is_err());
    }

    #[test]
    fn numbers_that_are_none_are_the_same() {
        let vector = |a: &[f64], b: &[f64]| first_other(a, b, &Hallmark::new("", "", b.into()).sizes);
        let apart =
            |a: &[f64], b: &[f64]| first_other(a, b, &Hallmark::of_parameters("", "", b.into()).sizes);
        for other in [&vector as &dyn Fn(&[f64], &[f64]) -> Option<usize>, &apart] {
            assert_eq!(other(&[f64::NAN, 1.0], &[f64::NAN, 1.0]), None);
            assert_eq!(other(&[f64::INFINITY, 1.0], &[f64::INFINITY, 2.0]), Some(1));
            assert_eq!(other(&[1.0], &[f64::NAN]), Some(0));
            assert_eq!(other(&[f64::INFINITY], &[1.0]), Some(0));
            assert_eq!(other(&[1.0, 2.0], &[1.0]), Some(1));
        }
        assert_eq!(vector(&[1e9, 1.0], &[1e9, 1.01]), None);
        assert_eq!(apart(&[1e9, 1.0], &[1e9, 1.01]), Some(1));
    }

    #[test]
    fn what_roundings_of_places_make_is_allowed() {
        let mut force = Hallmark::of_vectors("", "", &[&[1e-17, 0.0], &[1.0, 0.0]]);
        let told = |force: &Hallmark| first_other(&[-2e-17, 0.0, 1.0, 0.0], &force.numbers, &force.sizes);
        assert_eq!(told(&force), Some(0));
        force.allow(&Hallmark { numbers: vec![1.2e-17, 0.0, f64::NAN, f64::INFINITY], ..force.clone() });
        assert_eq!(told(&force), None);
        assert_eq!(first_other(&[1e-17, 0.0, 1.0 + 1e-9, 0.0], &force.numbers, &force.sizes), Some(2));
    }
}
