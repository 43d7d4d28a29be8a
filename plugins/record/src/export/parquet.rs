//! Parquet tables: one file, sorted by time.

use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use parquet::basic::{Compression, ConvertedType, Repetition, Type as PhysicalType, ZstdLevel};
use parquet::data_type::{
    ByteArray, ByteArrayType, DataType, DoubleType, FloatType, Int32Type, Int64Type,
};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use parquet::schema::types::Type;
use prost::bytes::Bytes;

use super::rows::{Column, Kind, Value};
use super::{ExportError, failed};
use crate::output::Draft;

/// The number of rows that are buffered in memory and written as one row group.
const GROUP_ROWS: usize = 1 << 19;

/// The writer of a Parquet file.
pub(super) struct Table {
    path: PathBuf,
    draft: Draft,
    writer: SerializedFileWriter<File>,
    columns: Vec<Buffer>,
    rows: usize,
}

/// The values of a column that aren't written yet.
struct Buffer {
    values: Values,
    /// Definition levels: 1 for each row that has a value, 0 for each other row. `None` if every
    /// row has one.
    present: Option<Vec<i16>>,
}

enum Values {
    U32(Vec<i32>),
    U64(Vec<i64>),
    F32(Vec<f32>),
    F64(Vec<f64>),
    Text(Vec<ByteArray>),
}

impl Table {
    /// Creates a file with a schema of the given name.
    pub fn create(
        path: &Path,
        force: bool,
        name: &str,
        columns: &[Column],
    ) -> Result<Self, ExportError> {
        let (draft, file) = Draft::create(path, force).map_err(|error| failed(path, error))?;
        let writer = writer(file, name, columns).map_err(|error| failed(path, error.into()))?;
        let columns = columns.iter().map(Buffer::new).collect();
        Ok(Self { path: path.to_owned(), draft, writer, columns, rows: 0 })
    }

    pub fn add(&mut self, row: &[Value]) -> Result<(), ExportError> {
        for (column, value) in self.columns.iter_mut().zip(row) {
            column.push(value);
        }
        self.rows += 1;
        if self.rows < GROUP_ROWS {
            return Ok(());
        }
        self.write().map_err(|error| failed(&self.path, error.into()))
    }

    /// Writes the buffered rows as a row group.
    fn write(&mut self) -> Result<(), ParquetError> {
        self.rows = 0;
        let mut group = self.writer.next_row_group()?;
        for column in &mut self.columns {
            column.write(&mut group)?;
        }
        group.close().map(drop)
    }

    /// Writes the buffered rest, closes the file and returns its name.
    pub fn finish(mut self) -> Result<String, ExportError> {
        let written = self.write().and_then(|()| self.writer.close());
        let committed = written.map_err(io::Error::from).and_then(|_| self.draft.commit());
        committed.map_err(|error| failed(&self.path, error))?;
        Ok(self.path.display().to_string())
    }
}

fn writer(
    file: File,
    name: &str,
    columns: &[Column],
) -> Result<SerializedFileWriter<File>, ParquetError> {
    let compression = Compression::ZSTD(ZstdLevel::try_new(1)?);
    let properties = WriterProperties::builder().set_compression(compression).build();
    let schema = schema(name, columns)?;
    SerializedFileWriter::new(file, Arc::new(schema), Arc::new(properties))
}

fn schema(name: &str, columns: &[Column]) -> Result<Type, ParquetError> {
    let fields = columns.iter().map(|column| field(column).map(Arc::new));
    Type::group_type_builder(name).with_fields(fields.collect::<Result<_, _>>()?).build()
}

fn field(column: &Column) -> Result<Type, ParquetError> {
    let (physical, converted) = match column.kind {
        Kind::U32 => (PhysicalType::INT32, ConvertedType::UINT_32),
        Kind::U64 => (PhysicalType::INT64, ConvertedType::UINT_64),
        Kind::F32 => (PhysicalType::FLOAT, ConvertedType::NONE),
        Kind::F64 => (PhysicalType::DOUBLE, ConvertedType::NONE),
        Kind::Text => (PhysicalType::BYTE_ARRAY, ConvertedType::UTF8),
    };
    let repetition = if column.is_optional { Repetition::OPTIONAL } else { Repetition::REQUIRED };
    let builder = Type::primitive_type_builder(&column.title, physical);
    builder.with_repetition(repetition).with_converted_type(converted).build()
}

impl Buffer {
    fn new(column: &Column) -> Self {
        let values = match column.kind {
            Kind::U32 => Values::U32(Vec::new()),
            Kind::U64 => Values::U64(Vec::new()),
            Kind::F32 => Values::F32(Vec::new()),
            Kind::F64 => Values::F64(Vec::new()),
            Kind::Text => Values::Text(Vec::new()),
        };
        Self { values, present: column.is_optional.then(Vec::new) }
    }

    fn push(&mut self, value: &Value) {
        if let Some(present) = &mut self.present {
            present.push(i16::from(*value != Value::Missing));
        }
        match (&mut self.values, *value) {
            (_, Value::Missing) => {}
            (Values::U32(values), Value::U32(value)) => values.push(value.cast_signed()),
            (Values::U64(values), Value::U64(value)) => values.push(value.cast_signed()),
            (Values::F32(values), Value::F32(value)) => values.push(value),
            (Values::F64(values), Value::F64(value)) => values.push(value),
            (Values::Text(values), Value::Text(value)) => {
                values.push(Bytes::from_static(value.as_bytes()).into())
            }
            (_, value) => debug_assert!(false, "{value:?} is of another kind than its column"),
        }
    }

    /// Writes the values as the next column of a group, and forgets them.
    fn write(
        &mut self,
        group: &mut SerializedRowGroupWriter<'_, File>,
    ) -> Result<(), ParquetError> {
        let present = self.present.as_deref();
        match &mut self.values {
            Values::U32(values) => column::<Int32Type>(group, values, present),
            Values::U64(values) => column::<Int64Type>(group, values, present),
            Values::F32(values) => column::<FloatType>(group, values, present),
            Values::F64(values) => column::<DoubleType>(group, values, present),
            Values::Text(values) => column::<ByteArrayType>(group, values, present),
        }?;
        if let Some(present) = &mut self.present {
            present.clear();
        }
        Ok(())
    }
}

/// Writes the next column, and clears its values.
fn column<T: DataType>(
    group: &mut SerializedRowGroupWriter<'_, File>,
    values: &mut Vec<T::T>,
    present: Option<&[i16]>,
) -> Result<(), ParquetError> {
    let mut column =
        group.next_column()?.ok_or_else(|| ParquetError::General("too few columns".to_owned()))?;
    column.typed::<T>().write_batch(values, present, None)?;
    column.close()?;
    values.clear();
    Ok(())
}
