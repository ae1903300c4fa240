//! Long tables for pandas, Polars and DuckDB: Apache Parquet.

use super::stream::{NUMBERS, Writer, append, names, taken, width, wrong};
use crate::files;
use crate::watch::{Column, Rows};
use parquet::basic::{Repetition, Type as Physical};
use parquet::data_type::{DataType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use parquet::schema::types::Type;
use std::fs::File;
use std::io;
use std::iter::repeat;
use std::path::Path;
use std::sync::Arc;

/// A table with the columns `step`, `trajectory` and `t`, and one for each recorded number: `height`, or `q_0_2` for an
/// entry of an array (for positions: body 0, coordinate 2). For long tables with few columns; for many bodies take
/// [`NpzParts`](super::NpzParts). The file is readable after [`Stream::finish`](super::Stream::finish),
/// and has its columns also where no row was recorded.
#[doc(alias = "pandas")]
#[doc(alias = "table")]
#[derive(Debug)]
pub struct Parquet {
    begun: Begun,
    waiting: Rows,
}

/// A file has its columns from the first row.
#[derive(Debug)]
enum Begun {
    Not(File),
    Yes(Box<SerializedFileWriter<File>>),
    /// It could not be.
    Never,
}

impl Parquet {
    /// Creates the file `path`, and its folder where that is missing.
    ///
    /// # Errors
    /// Those of the file system.
    pub fn create(path: impl AsRef<Path>) -> io::Result<Self> {
        Ok(Self { begun: Begun::Not(files::create(path.as_ref())?), waiting: Rows::default() })
    }

    /// The file, begun with the columns of the rows that wait.
    fn begun(&mut self) -> Result<&mut SerializedFileWriter<File>, ParquetError> {
        if let Begun::Not(_) = self.begun
            && let Begun::Not(file) = std::mem::replace(&mut self.begun, Begun::Never)
        {
            let schema = Arc::new(schema(&self.waiting.columns)?);
            // Numbers of a motion do not repeat.
            let properties = WriterProperties::builder().set_dictionary_enabled(false).build();
            let writer = SerializedFileWriter::new(file, schema, Arc::new(properties))?;
            self.begun = Begun::Yes(Box::new(writer));
        }
        match &mut self.begun {
            Begun::Yes(writer) => Ok(writer),
            _ => Err(ParquetError::General("the file could not be begun".into())),
        }
    }

    fn write_group(&mut self) -> Result<(), ParquetError> {
        self.begun()?;
        let rows = taken(&mut self.waiting);
        let mut group = self.begun()?.next_row_group()?;
        let whole = |counts: &[u64]| counts.iter().map(|&count| count.cast_signed()).collect::<Vec<_>>();
        column::<Int64Type>(&mut group, &whole(&rows.steps))?;
        column::<Int64Type>(&mut group, &whole(&rows.trajectories))?;
        column::<DoubleType>(&mut group, &rows.times)?;
        for number in 0..width(&rows.columns) {
            let numbers = rows.numbers.iter().skip(number).step_by(width(&rows.columns));
            column::<DoubleType>(&mut group, &numbers.copied().collect::<Vec<_>>())?;
        }
        group.close()?;
        Ok(())
    }
}

impl Writer for Parquet {
    fn write(&mut self, rows: &Rows) -> io::Result<()> {
        if let Begun::Not(_) = self.begun {
            self.waiting.columns = rows.columns.clone();
        } else if !rows.is_empty() {
            rows.fit(&self.waiting).map_err(wrong)?; // a table has one width
        }
        self.begun().map_err(of_the_system)?;
        append(rows, &mut self.waiting);
        if (width(&rows.columns) + 3) * self.waiting.len() < NUMBERS {
            return Ok(());
        }
        self.write_group().map_err(of_the_system)
    }

    fn finish(mut self) -> io::Result<()> {
        if !self.waiting.is_empty() {
            self.write_group().map_err(of_the_system)?;
        }
        self.begun().and_then(|file| file.finish().map(|_| ())).map_err(of_the_system)
    }
}

fn column<T: DataType>(
    group: &mut SerializedRowGroupWriter<'_, File>,
    values: &[T::T],
) -> Result<(), ParquetError> {
    let Some(mut column) = group.next_column()? else {
        return Err(ParquetError::General("rows have more columns than the first ones".into()));
    };
    column.typed::<T>().write_batch(values, None, None)?;
    column.close()
}

fn schema(columns: &[Column]) -> Result<Type, ParquetError> {
    let field = |name: &str, kind| {
        let field = Type::primitive_type_builder(name, kind).with_repetition(Repetition::REQUIRED).build()?;
        Ok::<_, ParquetError>(Arc::new(field))
    };
    let kinds = [Physical::INT64, Physical::INT64].into_iter().chain(repeat(Physical::DOUBLE));
    let names = names(columns).map_err(ParquetError::General)?;
    let fields = names.iter().zip(kinds).map(|(name, kind)| field(name, kind)).collect::<Result<_, _>>()?;
    Type::group_type_builder("rows").with_fields(fields).build()
}

/// What the system says, if that was it.
fn of_the_system(error: ParquetError) -> io::Error {
    match error {
        ParquetError::External(error) => match error.downcast::<io::Error>() {
            Ok(error) => *error,
            Err(error) => io::Error::other(error),
        },
        error => io::Error::other(error),
    }
}
