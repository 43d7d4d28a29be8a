//! Workbooks of Excel (Office Open XML, ECMA-376): the table of a sheet as a text of CSV, so that
//! it is read as any other table.

use std::io::Cursor;

use calamine::{DataRef, ExcelDateTime, Reader, SheetType, SheetVisible, Xlsx, XlsxError};

use super::hidden::hidden_rows;
use super::rows::{self, MOST_COLUMNS, Rows};

const SECS_PER_DAY: f64 = 86_400.0;
/// The note on a formula that no program has worked out since it was written.
pub(super) const WITHOUT_VALUE: &str =
    "a formula without a value: save the file with a spreadsheet program";

/// A sheet of a workbook.
pub(super) struct Sheet {
    /// The table as CSV, with a line for each row. Lines above the table are empty: it begins at
    /// the first row with two cells, if there is one.
    pub csv: String,
    /// The names of the other sheets that have cells, too: those behind it, and hidden ones.
    pub others: Vec<String>,
    /// The number of rows with cells below the header that the sheet hides.
    pub hidden: usize,
}

/// Returns the first visible sheet with cells.
///
/// # Errors
/// The reason if it isn't a workbook, or has no such sheet.
pub(super) fn sheet_of(bytes: &[u8]) -> Result<Sheet, String> {
    let mut workbook = Xlsx::new(Cursor::new(bytes)).map_err(reason_of)?;
    let sheets = workbook.sheets_metadata().iter();
    let sheets = sheets
        .filter(|sheet| sheet.typ == SheetType::WorkSheet)
        .map(|sheet| (sheet.name.clone(), sheet.visible == SheetVisible::Visible));
    let (mut csv, mut others, mut hidden) = (None, Vec::new(), 0);
    for (name, is_visible) in sheets.collect::<Vec<_>>() {
        if !has_cells(&mut workbook, &name)? {
            continue;
        }
        match csv {
            None if is_visible => {
                let rows = rows_of(&mut workbook, &name)?;
                csv = Some(rows::to_csv(&rows)?);
                hidden = hidden_orders(&rows, &hidden_rows(bytes, &name));
            }
            _ => others.push(name),
        }
    }
    let csv = csv.ok_or_else(|| "no visible sheet of the workbook has cells".to_owned())?;
    Ok(Sheet { csv, others, hidden })
}

/// The number of hidden rows with cells below the header.
fn hidden_orders(rows: &Rows, hidden: &[usize]) -> usize {
    let header = rows::header_of(rows);
    let below = hidden.iter().filter(|row| **row > header).filter_map(|row| rows.get(*row));
    below.filter(|row| rows::count(row) > 0).count()
}

fn reason_of(error: XlsxError) -> String {
    format!("it can't be read as a workbook of Excel ({error}): save it as .xlsx or .csv")
}

/// Whether a sheet has a cell that isn't empty: a value or a formula.
fn has_cells(workbook: &mut Xlsx<Cursor<&[u8]>>, name: &str) -> Result<bool, String> {
    let mut cells = workbook.worksheet_cells_reader(name).map_err(reason_of)?;
    while let Some(cell) = cells.next_cell().map_err(reason_of)? {
        if !text_of(cell.get_value()).is_empty() {
            return Ok(true);
        }
    }
    drop(cells);
    let mut formulas = workbook.worksheet_cells_reader(name).map_err(reason_of)?;
    while let Some(cell) = formulas.next_formula().map_err(reason_of)? {
        if !cell.get_value().is_empty() {
            return Ok(true);
        }
    }
    Ok(false)
}

/// Reads the cells one by one: a sheet with a single cell far away takes little memory for those
/// between. A formula whose value the file doesn't have is told as the text of its cell: nothing
/// here can work it out, and as an empty cell it would be lost.
fn rows_of(workbook: &mut Xlsx<Cursor<&[u8]>>, name: &str) -> Result<Rows, String> {
    let mut rows = Rows::new();
    let mut cells = workbook.worksheet_cells_reader(name).map_err(reason_of)?;
    while let Some(cell) = cells.next_cell().map_err(reason_of)? {
        put(&mut rows, cell.get_position(), text_of(cell.get_value()))?;
    }
    drop(cells);
    let mut formulas = workbook.worksheet_cells_reader(name).map_err(reason_of)?;
    while let Some(cell) = formulas.next_formula().map_err(reason_of)? {
        let (position @ (row, column), formula) = (cell.get_position(), cell.get_value());
        let known = rows.get(row as usize).and_then(|row| row.get(column as usize));
        if !formula.is_empty() && known.is_none_or(String::is_empty) {
            put(&mut rows, position, format!("`={formula}`, {WITHOUT_VALUE}"))?;
        }
    }
    Ok(rows)
}

/// Puts a text into a cell, given its row and its column from 0 on.
fn put(rows: &mut Rows, (row, column): (u32, u32), text: String) -> Result<(), String> {
    if text.is_empty() {
        return Ok(());
    }
    if column >= MOST_COLUMNS {
        return Err(format!("row {} has more than {MOST_COLUMNS} columns", row + 1));
    }
    rows.resize(rows.len().max(row as usize + 1), Vec::new());
    let row = &mut rows[row as usize];
    row.resize(row.len().max(column as usize + 1), String::new());
    row[column as usize] = text;
    Ok(())
}

/// Returns the text of a cell on one line.
fn text_of(cell: &DataRef<'_>) -> String {
    let text = match cell {
        DataRef::Empty => String::new(),
        DataRef::Int(number) => number.to_string(),
        DataRef::Float(number) => number.to_string(),
        DataRef::Bool(is_true) => is_true.to_string(),
        DataRef::Error(error) => error.to_string(),
        DataRef::SharedString(text) => (*text).to_owned(),
        DataRef::String(text) | DataRef::DateTimeIso(text) | DataRef::DurationIso(text) => {
            text.clone()
        }
        DataRef::DateTime(time) => time_text(*time),
    };
    text.replace(['\r', '\n'], " ")
}

/// Returns a date, a time of day or both, as [`clock`](super::clock) reads them. Durations are
/// times of day: the hours of those of a day and more don't exist there.
fn time_text(time: ExcelDateTime) -> String {
    let days = time.as_f64();
    if time.is_duration() || days < 1.0 {
        let millis = (days * SECS_PER_DAY * 1000.0).round() as i64;
        let (hours, minutes) = (millis / 3_600_000, millis / 60_000 % 60);
        return format!("{hours:02}:{minutes:02}:{:06.3}", (millis % 60_000) as f64 / 1000.0);
    }
    let (year, month, day, hour, minute, secs, millis) = time.to_ymd_hms_milli();
    let date = format!("{year}-{month:02}-{day:02}");
    match (hour, minute, secs, millis) {
        // The time may have a column of its own.
        (0, 0, 0, 0) => date,
        _ => format!("{date} {hour:02}:{minute:02}:{secs:02}.{millis:03}"),
    }
}

#[cfg(test)]
mod tests {
    use calamine::ExcelDateTimeType;
    use regatta_base::yaml;

    use super::*;
    use crate::file::Table;

    /// Written by openpyxl 3.1: an empty sheet, then one with a title, a table from row 4 on whose
    /// row 7 is empty, numbers, dates, times, a line break and a formula without a value.
    const DAY: &[u8] = include_bytes!("../../tests/data/day.xlsx");

    #[test]
    fn a_workbook_is_read_as_the_same_table() {
        let sheet = sheet_of(DAY).expect("a workbook");
        let table = Table::parse_sheet(&sheet.csv).expect("a table");
        assert!(sheet.others.is_empty(), "{:?}", sheet.others);
        let same = "\n\n\nAuftragsnr.;Quelle;Ziel;Datum;Uhrzeit;Fällig;Menge\n\
                    4500017;Goods in 1;Lager Süd;26.11.2026;06:15;26.11.2026 06:45;3,5\n\
                    4500018;17;C D;26.11.2026;07:15:00,5;;\n;;;;;;\n4500019;B;;26.11.2026;08:00;;\n";
        let told = "the column `Ziel` is `=1/0`, a formula without a value: save the file with a \
                    spreadsheet program";
        let problems = vec![yaml::Error { line: 8, reason: told.to_owned() }];
        let expected = Table { problems, ..Table::parse(same).expect("a table") };
        assert_eq!(table, expected);
        assert_eq!(
            table.orders.iter().map(|order| order.secs).collect::<Vec<_>>(),
            [900.0, 4500.5]
        );
    }

    /// Written by openpyxl 3.1: two sheets with cells, the second one with more columns than a table
    /// may have, and a time that is a formula without a value.
    const SHEETS: &[u8] = include_bytes!("../../tests/data/sheets.xlsx");

    #[test]
    fn what_a_workbook_has_besides_is_told() {
        let sheet = sheet_of(SHEETS).expect("a workbook");
        assert_eq!(sheet.others, ["Tuesday"]);
        let table = Table::parse_sheet(&sheet.csv).expect("a table");
        let told = "the column `time` is `=D2+1/24`, a formula without a value: save the file with \
                    a spreadsheet program";
        assert_eq!(table.problems, [yaml::Error { line: 3, reason: told.to_owned() }]);
        assert_eq!(table.orders.len(), 1);
    }

    /// The workbook `DAY`, with the hidden rows 1 and 2 above the table, and 6 and 8 in it.
    const FILTERED: &[u8] = include_bytes!("../../tests/data/filtered.xlsx");

    #[test]
    fn hidden_rows_of_the_table_are_counted_and_read() {
        let [day, filtered] = [DAY, FILTERED].map(|bytes| sheet_of(bytes).expect("a workbook"));
        assert_eq!((day.hidden, filtered.hidden), (0, 2));
        assert_eq!(day.csv, filtered.csv);
    }

    #[test]
    fn what_is_no_workbook_is_told() {
        let reason = sheet_of(b"name,from,to\n").err().expect("CSV");
        assert!(reason.contains("save it as .xlsx"), "{reason}");
        for length in (0..DAY.len()).step_by(97) {
            assert!(sheet_of(&DAY[..length]).is_err(), "cut off after {length} bytes");
        }
    }

    #[test]
    fn times_are_written_as_files_have_them() {
        let text = |value: f64, kind| time_text(ExcelDateTime::new(value, kind, false));
        for (days, kind, expected) in [
            (46_352.0, ExcelDateTimeType::DateTime, "2026-11-26"),
            (46_352.25, ExcelDateTimeType::DateTime, "2026-11-26 06:00:00.000"),
            (0.343_75, ExcelDateTimeType::DateTime, "08:15:00.000"),
            (1.25, ExcelDateTimeType::TimeDelta, "30:00:00.000"),
        ] {
            assert_eq!(text(days, kind), expected);
        }
    }
}
