//! Parquet export: one table of all robots, sorted by time.

use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use parquet::basic::{Compression, ConvertedType, Repetition, Type as PhysicalType, ZstdLevel};
use parquet::data_type::{ByteArray, ByteArrayType, DataType, DoubleType, FloatType, Int32Type, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use parquet::schema::types::Type;

use super::{COMMON_TITLES, ExportError, Record};
use crate::output;

/// The number of rows that are buffered in memory and written as one row group.
const GROUP_ROWS: usize = 1 << 19;

/// The writer of a Parquet file.
pub(super) struct Table {
    path: PathBuf,
    writer: SerializedFileWriter<File>,
    group: Group,
}

/// The rows that aren't written yet, as columns.
#[derive(Default)]
struct Group {
    rows: usize,
    /// `time_s` and `sim_time_s`.
    times: [Vec<f64>; 2],
    ticks: Vec<i64>,
    /// `run` and `robot`.
    numbers: [Vec<i32>; 2],
    /// `x_m`, `y_m`, `theta_rad`, `speed_m_per_s` and `s_m`.
    motion: [Vec<f32>; 5],
    edges: Optional<i32>,
    states: Vec<ByteArray>,
    columns: Vec<Optional<f32>>,
}

/// A column of optional values.
#[derive(Clone, Default)]
struct Optional<T> {
    values: Vec<T>,
    /// Definition levels: 1 for each row that has a value, 0 for each other row.
    present: Vec<i16>,
}

impl<T> Optional<T> {
    fn push(&mut self, value: Option<T>) {
        self.present.push(i16::from(value.is_some()));
        self.values.extend(value);
    }
}

impl Table {
    /// Creates the file. `titles` are those of all columns; the last `plugins` of them belong to plugins' columns.
    pub fn create(path: &Path, titles: &[String], plugins: usize) -> Result<Self, ExportError> {
        let failed = |reason: io::Error| ExportError::Write { path: path.to_owned(), reason };
        let zstd = ZstdLevel::try_new(1).map_err(|error| failed(error.into()))?;
        let properties = WriterProperties::builder().set_compression(Compression::ZSTD(zstd)).build();
        let schema = schema(titles, plugins).map_err(|error| failed(error.into()))?;
        let file = output::create(path).map_err(failed)?;
        let writer = SerializedFileWriter::new(file, Arc::new(schema), Arc::new(properties));
        let group = Group { columns: vec![Optional::default(); plugins], ..Group::default() };
        Ok(Self { path: path.to_owned(), writer: writer.map_err(|error| failed(error.into()))?, group })
    }

    pub fn add(&mut self, record: &Record<'_>) -> Result<(), ExportError> {
        self.group.add(record);
        if self.group.rows == GROUP_ROWS { self.write() } else { Ok(()) }
    }

    fn write(&mut self) -> Result<(), ExportError> {
        let empty = Group { columns: vec![Optional::default(); self.group.columns.len()], ..Group::default() };
        let group = std::mem::replace(&mut self.group, empty);
        let written = self.writer.next_row_group().and_then(|writer| group.write(writer));
        written.map_err(|error| ExportError::Write { path: self.path.clone(), reason: error.into() })
    }

    /// Writes the buffered rest, closes the file and returns its path.
    pub fn finish(mut self) -> Result<String, ExportError> {
        self.write()?;
        let path = self.path;
        match self.writer.close() {
            Ok(_) => Ok(path.display().to_string()),
            Err(error) => Err(ExportError::Write { path, reason: error.into() }),
        }
    }
}

/// Returns the schema: [`COMMON_TITLES`], then the plugins' columns.
fn schema(titles: &[String], plugins: usize) -> Result<Type, ParquetError> {
    use PhysicalType::{BYTE_ARRAY, DOUBLE, FLOAT, INT32, INT64};
    let common = titles.len() - plugins;
    let types = [DOUBLE, INT32, INT64, DOUBLE, INT32, FLOAT, FLOAT, FLOAT, FLOAT, FLOAT, INT32, BYTE_ARRAY];
    let types = types.into_iter().take(common).chain(std::iter::repeat_n(FLOAT, plugins));
    let field = |(title, physical): (&String, PhysicalType)| {
        let (optional, converted) = match (physical, title.as_str()) {
            (INT32, "edge") => (true, ConvertedType::UINT_32),
            (INT32, _) => (false, ConvertedType::UINT_32),
            (INT64, _) => (false, ConvertedType::UINT_64),
            (BYTE_ARRAY, _) => (false, ConvertedType::UTF8),
            _ => (!COMMON_TITLES.contains(&title.as_str()), ConvertedType::NONE),
        };
        let repetition = if optional { Repetition::OPTIONAL } else { Repetition::REQUIRED };
        let builder = Type::primitive_type_builder(title, physical);
        builder.with_repetition(repetition).with_converted_type(converted).build().map(Arc::new)
    };
    let fields = titles.iter().zip(types).map(field).collect::<Result<Vec<_>, _>>()?;
    Type::group_type_builder("robots").with_fields(fields).build()
}

impl Group {
    fn add(&mut self, record: &Record<'_>) {
        let Record { snapshot, robot, row, .. } = record;
        self.rows += 1;
        let [time, sim_time] = &mut self.times;
        time.push(snapshot.time.as_secs_f64());
        sim_time.push(record.sim_time());
        self.ticks.push(snapshot.header().tick as i64);
        let [run, robots] = &mut self.numbers;
        run.push(snapshot.run as i32);
        robots.push(*robot as i32);
        let values = [row.x, row.y, row.theta, row.speed, row.s];
        self.motion.iter_mut().zip(values).for_each(|(column, value)| column.push(value));
        self.edges.push(record.edge.map(|edge| edge as i32));
        self.states.push(record.state().into());
        let columns = self.columns.iter_mut().enumerate();
        columns.for_each(|(i, column)| column.push(snapshot.column(i, *robot)));
    }

    /// Writes all columns in the order of the schema.
    fn write(self, mut writer: SerializedRowGroupWriter<'_, File>) -> Result<(), ParquetError> {
        let out = &mut writer;
        let ([time, sim_time], [run, robot]) = (&self.times, &self.numbers);
        column::<DoubleType>(out, time, None)?;
        column::<Int32Type>(out, run, None)?;
        column::<Int64Type>(out, &self.ticks, None)?;
        column::<DoubleType>(out, sim_time, None)?;
        column::<Int32Type>(out, robot, None)?;
        for values in &self.motion {
            column::<FloatType>(out, values, None)?;
        }
        column::<Int32Type>(out, &self.edges.values, Some(&self.edges.present))?;
        column::<ByteArrayType>(out, &self.states, None)?;
        for values in &self.columns {
            column::<FloatType>(out, &values.values, Some(&values.present))?;
        }
        writer.close().map(drop)
    }
}

/// Writes the next column.
fn column<T: DataType>(
    writer: &mut SerializedRowGroupWriter<'_, File>,
    values: &[T::T],
    present: Option<&[i16]>,
) -> Result<(), ParquetError> {
    let mut column = writer.next_column()?.ok_or_else(|| ParquetError::General("too few columns".to_owned()))?;
    column.typed::<T>().write_batch(values, present, None)?;
    column.close()
}
