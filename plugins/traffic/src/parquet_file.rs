//! The figures of a run as a Parquet file: a row for each edge.

use std::fs::File;
use std::io;
use std::path::Path;
use std::sync::Arc;

use parquet::basic::{Compression, ConvertedType, Repetition, Type as PhysicalType, ZstdLevel};
use parquet::data_type::{ByteArray, ByteArrayType, DataType, FloatType, Int32Type};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use parquet::schema::types::Type;

use crate::report::{Edge, FIGURES, Report};

type Group<'a> = SerializedRowGroupWriter<'a, File>;

/// Writes a report, in place of the file's contents.
///
/// # Errors
/// If the file can't be written.
pub fn write(path: &Path, report: &Report<'_>) -> io::Result<()> {
    let zstd = Compression::ZSTD(ZstdLevel::try_new(1)?);
    let properties = WriterProperties::builder().set_compression(zstd).build();
    let mut writer =
        SerializedFileWriter::new(File::create(path)?, Arc::new(schema()?), Arc::new(properties))?;
    let mut group = writer.next_row_group()?;
    let ids: [fn(&Edge) -> u32; 3] = [|edge| edge.id, |edge| edge.origin, |edge| edge.destination];
    for id in ids {
        let ids: Vec<i32> = report.edges.iter().map(|edge| id(edge).cast_signed()).collect();
        column::<Int32Type>(&mut group, &ids)?;
    }
    let names: Vec<ByteArray> = report.edges.iter().map(|edge| edge.name.as_str().into()).collect();
    column::<ByteArrayType>(&mut group, &names)?;
    for (_, figure) in FIGURES {
        let values: Vec<f32> = report.figures.iter().map(figure).collect();
        column::<FloatType>(&mut group, &values)?;
    }
    group.close()?;
    writer.close()?;
    Ok(())
}

/// Returns the schema, with the columns of the CSV file.
fn schema() -> Result<Type, ParquetError> {
    let mut fields = Vec::new();
    for name in ["edge", "origin", "destination"] {
        fields.push(field(name, PhysicalType::INT32, ConvertedType::UINT_32)?);
    }
    fields.push(field("name", PhysicalType::BYTE_ARRAY, ConvertedType::UTF8)?);
    for (name, _) in FIGURES {
        fields.push(field(name, PhysicalType::FLOAT, ConvertedType::NONE)?);
    }
    Type::group_type_builder("traffic").with_fields(fields).build()
}

fn field(
    name: &str,
    physical: PhysicalType,
    converted: ConvertedType,
) -> Result<Arc<Type>, ParquetError> {
    let builder =
        Type::primitive_type_builder(name, physical).with_repetition(Repetition::REQUIRED);
    builder.with_converted_type(converted).build().map(Arc::new)
}

fn column<T: DataType>(group: &mut Group<'_>, values: &[T::T]) -> Result<(), ParquetError> {
    let mut column =
        group.next_column()?.ok_or_else(|| ParquetError::General("too few columns".to_owned()))?;
    column.typed::<T>().write_batch(values, None, None)?;
    column.close()
}

#[cfg(test)]
mod tests {
    use parquet::file::reader::{FileReader, SerializedFileReader};

    use regatta_plugin::traffic::EdgeTraffic;

    use super::*;

    #[test]
    fn a_row_is_an_edge() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("traffic.parquet");
        let edges = [
            Edge { id: 5, origin: 1, destination: 2, name: "dock, \"north\"".to_owned() },
            Edge { id: u32::MAX, origin: 2, destination: 3, ..Edge::default() },
        ];
        let figures = [1.0, 2.0].map(|number| EdgeTraffic {
            occupancy: number,
            entered_per_hour: 10.0 * number,
            relative_speed: 0.25 * number,
            waiting_secs: 100.0 * number,
            contact_secs: 1000.0 * number,
            released: 2.0 * number,
            planned: 3.0 * number,
        });
        write(&path, &Report { secs: 60.0, edges: &edges, figures: &figures }).expect("written");
        let reader =
            SerializedFileReader::new(File::open(&path).expect("a file")).expect("readable");
        let rows: Vec<String> = reader
            .get_row_iter(None)
            .expect("rows")
            .map(|row| row.expect("a row").to_string())
            .collect();
        assert_eq!(
            rows,
            [
                "{edge: 5, origin: 1, destination: 2, name: \"dock, \"north\"\", occupancy: 1.0, \
                 entered_per_hour: 10.0, \
             relative_speed: 0.25, waiting_secs: 100.0, contact_secs: 1000.0, released: 2.0, planned: 3.0}",
                "{edge: 4294967295, origin: 2, destination: 3, name: \"\", occupancy: 2.0, \
                 entered_per_hour: 20.0, \
             relative_speed: 0.5, waiting_secs: 200.0, contact_secs: 2000.0, released: 4.0, planned: 6.0}",
            ]
        );
    }
}
