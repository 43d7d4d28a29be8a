//! Tables of Apache Parquet, as data warehouses export them, as a text of CSV.

use bytes::Bytes;
use parquet::basic::{LogicalType, TimeUnit};
use parquet::errors::ParquetError;
use parquet::file::metadata::{ColumnChunkMetaData, RowGroupMetaData};
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::Field;
use parquet::schema::types::Type;

use super::clock;
use super::rows::{self, MOST_CELLS, MOST_COLUMNS, Rows};

/// The most bytes of all cells: a small file can repeat a long text.
const MOST_BYTES: usize = 256 << 20;
const SECS_PER_DAY: i64 = 86_400;

/// The meaning of a column's integers.
#[derive(Clone, Copy)]
enum Kind {
    /// Numbers, texts, dates.
    Plain,
    /// Times of day, so many units a second.
    Clock { units: i64 },
    /// Dates with a time of day, so many units a second, of a zone or of UTC.
    Timestamp { units: i64, is_utc: bool },
}

/// Returns the table as CSV: a header, and a line for each row.
///
/// # Errors
/// The reason if it isn't a file of Parquet, or its columns are nested or too many.
pub(super) fn csv_of(bytes: Vec<u8>) -> Result<String, String> {
    // The crate panics at some pages that can't be, and nothing of its state is used afterwards.
    let table = std::panic::catch_unwind(|| table_of(bytes));
    rows::to_csv(&table.unwrap_or_else(|_| Err("it is damaged: write it again".to_owned()))?)
}

fn table_of(bytes: Vec<u8>) -> Result<Rows, String> {
    let reader = SerializedFileReader::new(Bytes::from(bytes)).map_err(reason_of)?;
    if !reader.metadata().row_groups().iter().flat_map(RowGroupMetaData::columns).all(is_in_file) {
        return Err("it is damaged: a column lies before the file's start".to_owned());
    }
    let metadata = reader.metadata().file_metadata();
    let columns = metadata.schema().get_fields();
    if columns.len() > MOST_COLUMNS as usize {
        return Err(format!("it has more than {MOST_COLUMNS} columns: remove some"));
    }
    let rows = usize::try_from(metadata.num_rows()).unwrap_or(usize::MAX);
    if rows.saturating_mul(columns.len()) > MOST_CELLS {
        return Err(format!("it has more than {MOST_CELLS} cells: split the file"));
    }
    let kinds = columns.iter().map(|column| kind_of(column)).collect::<Result<Vec<_>, _>>()?;
    let mut table: Rows = vec![columns.iter().map(|column| column.name().to_owned()).collect()];
    let mut size = 0;
    for row in reader.get_row_iter(None).map_err(reason_of)? {
        let row = row.map_err(reason_of)?;
        let fields = row.get_column_iter().zip(&kinds);
        let cells: Vec<String> = fields.map(|((_, field), kind)| text_of(field, *kind)).collect();
        size += cells.iter().map(String::len).sum::<usize>();
        if size > MOST_BYTES {
            return Err(format!("its cells have more than {MOST_BYTES} bytes: split the file"));
        }
        table.push(cells);
    }
    Ok(table)
}

/// Whether a column's place can be one: the crate panics at others.
fn is_in_file(column: &ColumnChunkMetaData) -> bool {
    let start = column.dictionary_page_offset().unwrap_or_else(|| column.data_page_offset());
    start >= 0 && column.compressed_size() >= 0
}

fn reason_of(error: ParquetError) -> String {
    format!("it can't be read as a table of Parquet ({error}): write it again, or as .csv")
}

/// Returns the meaning of a column.
///
/// # Errors
/// If it has columns of its own, or several values a row.
fn kind_of(column: &Type) -> Result<Kind, String> {
    let info = column.get_basic_info();
    let is_list =
        info.has_repetition() && info.repetition() == parquet::basic::Repetition::REPEATED;
    if column.is_group() || is_list {
        let name = column.name().escape_debug();
        return Err(format!("the column `{name}` is nested: write each value as a column"));
    }
    Ok(match info.logical_type_ref() {
        Some(LogicalType::Time(time)) => Kind::Clock { units: units_of(&time.unit) },
        Some(LogicalType::Timestamp(time)) => {
            Kind::Timestamp { units: units_of(&time.unit), is_utc: time.is_adjusted_to_u_t_c }
        }
        _ => Kind::Plain,
    })
}

fn units_of(unit: &TimeUnit) -> i64 {
    match unit {
        TimeUnit::MILLIS => 1_000,
        TimeUnit::MICROS => 1_000_000,
        TimeUnit::NANOS => 1_000_000_000,
    }
}

/// Returns the text of a cell on one line.
fn text_of(field: &Field, kind: Kind) -> String {
    let text = match (integer_of(field), kind) {
        (Some(number), Kind::Clock { units }) => clock_text(number, units),
        (Some(number), Kind::Timestamp { units, is_utc }) => timestamp_text(number, units, is_utc),
        _ => plain_text(field),
    };
    text.replace(['\r', '\n'], " ")
}

/// The number of a time, whatever its unit.
fn integer_of(field: &Field) -> Option<i64> {
    match field {
        Field::Int(number) | Field::TimeMillis(number) => Some(i64::from(*number)),
        Field::Long(number)
        | Field::TimeMicros(number)
        | Field::TimestampMillis(number)
        | Field::TimestampMicros(number) => Some(*number),
        _ => None,
    }
}

fn plain_text(field: &Field) -> String {
    match field {
        Field::Null => String::new(),
        Field::Str(text) => text.clone(),
        // Older programs write texts without saying so.
        Field::Bytes(bytes) => String::from_utf8_lossy(bytes.data()).into_owned(),
        // A column of numbers with an empty cell has become one of floating-point numbers.
        Field::Float(number) if number.is_nan() => String::new(),
        Field::Double(number) if number.is_nan() => String::new(),
        Field::Float(number) => number.to_string(),
        Field::Double(number) => number.to_string(),
        Field::Date(days) => clock::date_text(i64::from(*days)),
        // Times without a logical type, of old programs.
        Field::TimestampMillis(number) => timestamp_text(*number, 1_000, false),
        Field::TimestampMicros(number) => timestamp_text(*number, 1_000_000, false),
        Field::TimeMillis(number) => clock_text(i64::from(*number), 1_000),
        Field::TimeMicros(number) => clock_text(*number, 1_000_000),
        other => other.to_string(),
    }
}

/// Returns a time of day, to the millisecond.
fn clock_text(number: i64, units: i64) -> String {
    let (secs, rest) = (number.div_euclid(units), number.rem_euclid(units));
    let millis = rest * 1000 / units;
    let [hours, minutes, secs] = [secs / 3600, secs / 60 % 60, secs % 60];
    format!("{hours:02}:{minutes:02}:{secs:02}.{millis:03}")
}

/// Returns a date with a time of day, as [`clock`] reads them.
fn timestamp_text(number: i64, units: i64, is_utc: bool) -> String {
    let day = SECS_PER_DAY.saturating_mul(units);
    let date = clock::date_text(number.div_euclid(day));
    match (is_utc, number.rem_euclid(day)) {
        // The time may have a column of its own.
        (false, 0) => date,
        (false, rest) => format!("{date} {}", clock_text(rest, units)),
        (true, rest) => format!("{date}T{}Z", clock_text(rest, units)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::file::Table;

    /// Written by pyarrow 26 with Snappy: texts, a number with an empty cell, timestamps in
    /// nanoseconds without a zone, others in milliseconds, a decimal number.
    const DAY: &[u8] = include_bytes!("../../tests/data/day.parquet");

    #[test]
    fn a_table_of_parquet_is_read_as_the_same_table() {
        let text = csv_of(DAY.to_vec()).expect("a table");
        let table = Table::parse_sheet(&text).expect("a table");
        let same = "order,from,to,release,due,weight\n\
                    4500017,Goods in 1,Lager Süd,2026-11-26 06:15:00,2026-11-26 06:45:00,3.50\n\
                    4500018,17,C D,2026-11-26 07:15:00.500,,\n\
                    4500019,B,,2026-11-26 08:00:00,,1.25\n";
        assert_eq!(table.orders, Table::parse(same).expect("a table").orders, "{text}");
        assert_eq!(table.orders.len(), 2);
        let [problem] = &table.problems[..] else { panic!("{:?}", table.problems) };
        assert_eq!((problem.line, problem.reason.as_str()), (4, "the station `to` is missing"));
    }

    #[test]
    fn what_is_no_table_of_parquet_is_told() {
        assert!(csv_of(b"name,from,to\n".to_vec()).expect_err("CSV").contains("as .csv"));
        for length in (0..DAY.len()).step_by(31) {
            assert!(csv_of(DAY[..length].to_vec()).is_err(), "cut off after {length} bytes");
        }
        let nested = include_bytes!("../../tests/data/nested.parquet");
        let reason = csv_of(nested.to_vec()).expect_err("nested");
        assert!(reason.contains("the column `stops` is nested"), "{reason}");
    }

    #[test]
    fn damaged_files_are_no_panic() {
        for at in 0..DAY.len() {
            for bit in [0x01, 0x80, 0xff] {
                let mut damaged = DAY.to_vec();
                damaged[at] ^= bit;
                let _ = csv_of(damaged);
            }
        }
    }

    #[test]
    fn times_have_the_unit_of_their_column() {
        let millis = Kind::Timestamp { units: 1_000, is_utc: true };
        assert_eq!(text_of(&Field::Long(-1), millis), "1969-12-31T23:59:59.999Z");
        let nanos = Kind::Clock { units: 1_000_000_000 };
        assert_eq!(text_of(&Field::Long(30_600_500_000_000), nanos), "08:30:00.500");
        assert_eq!(text_of(&Field::Long(17), Kind::Plain), "17");
        assert_eq!(text_of(&Field::Double(17.0), Kind::Plain), "17");
        assert_eq!(text_of(&Field::Double(f64::NAN), Kind::Plain), "");
        assert_eq!(text_of(&Field::Date(20_783), Kind::Plain), "2026-11-26");
    }
}
