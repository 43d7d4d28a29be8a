//! Tables of binary files as a text of CSV, so that they are read as any other table.

/// The most columns that are read: those of the widest table.
pub(super) const MOST_COLUMNS: u32 = 1_000;
/// The most cells of a table that are read, the empty ones of its rows included.
pub(super) const MOST_CELLS: usize = 20_000_000;

/// The rows of a table from the first on, each with its cells from the first column on.
pub(super) type Rows = Vec<Vec<String>>;

/// The number of cells that aren't empty.
pub(super) fn count(row: &[String]) -> usize {
    row.iter().filter(|cell| !cell.is_empty()).count()
}

/// Returns the row at which the table begins: the first one with two cells, if there is one.
pub(super) fn header_of(rows: &Rows) -> usize {
    let header = rows.iter().position(|row| count(row) > 1);
    header.or_else(|| rows.iter().position(|row| count(row) > 0)).unwrap_or(0)
}

/// Writes rows of the same width, and an empty line for each row above the table.
pub(super) fn to_csv(rows: &Rows) -> Result<String, String> {
    let header = header_of(rows);
    let table = &rows[header..];
    let width = table.iter().map(Vec::len).max().unwrap_or(0);
    if table.len() * width > MOST_CELLS {
        return Err(format!(
            "the table has more than {MOST_CELLS} cells up to the last one: remove cells far away, \
             or split the file"
        ));
    }
    let mut writer = csv::Writer::from_writer(vec![b'\n'; header]);
    for row in table {
        let empty = std::iter::repeat_n("", width - row.len());
        // Writing to memory never fails.
        let _ = writer.write_record(row.iter().map(String::as_str).chain(empty));
    }
    Ok(String::from_utf8(writer.into_inner().unwrap_or_default()).unwrap_or_default())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_far_away_are_told_before_they_take_memory() {
        let mut rows = vec![Vec::new(); 1_000_000];
        rows[0] = vec!["from".to_owned(), "to".to_owned()];
        rows[999_999] = vec!["note".to_owned()];
        assert_eq!(to_csv(&rows).expect("few cells").lines().count(), 1_000_000);
        rows[999_999] = vec![String::new(); 1_000];
        assert!(to_csv(&rows).expect_err("many cells").contains("remove cells far away"));
    }
}
