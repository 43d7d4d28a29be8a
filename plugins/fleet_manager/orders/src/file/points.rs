//! Numbers with a point in a table whose other numbers have decimal commas: `3.000` are three
//! thousand there, unless other numbers have decimal points.

use csv::StringRecord;
use regatta_base::{Decimal, yaml};

use super::columns::{Columns, Meaning};
use super::table::line_of;

/// The columns whose cells may be numbers.
const TIMES: [Meaning; 3] = [Meaning::Time, Meaning::Earliest, Meaning::Deadline];

/// The ways in which a table writes its numbers.
#[derive(Debug, Default)]
pub(super) struct Points {
    has_comma: bool,
    /// The first number with a decimal point, if there is one.
    decimal: Option<Cell>,
    /// The first number whose point separates thousands.
    thousands: Option<Cell>,
    /// The number of these.
    count: usize,
}

/// A cell of a number.
#[derive(Clone, Debug)]
struct Cell {
    line: usize,
    column: &'static str,
    text: String,
    number: f64,
}

impl Points {
    /// Looks at the numbers of all records: at those of columns without a meaning, too, for
    /// decimal commas.
    pub fn of(columns: &Columns, records: impl Iterator<Item = StringRecord>) -> Self {
        let mut points = Self::default();
        for record in records {
            points.has_comma |= columns.unused_cells(&record).any(Decimal::has_comma);
            for (meaning, text) in times_of(columns, &record) {
                points.has_comma |= Decimal::has_comma(text);
                if let (None, Some(number @ Decimal::Point(_))) =
                    (&points.decimal, Decimal::parse(text))
                {
                    points.decimal = Some(Cell::new(&record, meaning, text, number));
                }
            }
        }
        points
    }

    /// Returns a record without points between thousands.
    ///
    /// # Errors
    /// If a number may be read in two ways.
    pub fn without_thousands(
        &mut self,
        columns: &Columns,
        mut record: StringRecord,
    ) -> Result<StringRecord, yaml::Error> {
        if !self.has_comma {
            return Ok(record);
        }
        let mut cells: Vec<String> = record.iter().map(str::to_owned).collect();
        let mut has_changed = false;
        for (meaning, text) in times_of(columns, &record) {
            let Some(number) = Decimal::parse(text).filter(|_| text.contains('.')) else {
                continue;
            };
            if let Decimal::Grouped(_) = number {
                let cell = Cell::new(&record, meaning, text, number);
                self.check(&cell)?;
                self.count += 1;
                self.thousands.get_or_insert(cell);
            }
            if let Some(at) = columns.find(meaning) {
                cells[at] = number.number().to_string();
                has_changed = true;
            }
        }
        check_stops(columns, &record)?;
        if has_changed {
            let position = record.position().cloned();
            record = StringRecord::from(cells);
            record.set_position(position);
        }
        Ok(record)
    }

    /// Refuses a number such as `3.000` in a table with decimal points.
    fn check(&self, cell: &Cell) -> Result<(), yaml::Error> {
        let Some(decimal) = &self.decimal else { return Ok(()) };
        let reason = format!(
            "{}; line {} has `{}`, and other numbers have a decimal comma: write one kind of \
             numbers",
            cell.doubt(),
            decimal.line,
            decimal.text
        );
        Err(yaml::Error { line: cell.line, reason })
    }

    /// The sentences that tell how numbers with points are read.
    pub fn notes(&self) -> Vec<String> {
        if !self.has_comma {
            return Vec::new();
        }
        let times =
            if self.count > 1 { format!(" ({} such numbers)", self.count) } else { String::new() };
        let thousands = self.thousands.iter().map(|Cell { line, column, text, number }| {
            format!(
                "line {line}: the {column} `{text}` is read as {number}, as other numbers have a \
                 decimal comma{times}"
            )
        });
        let decimal = self.decimal.iter().map(|Cell { line, column, text, number }| {
            format!(
                "line {line}: the {column} `{text}` is read as {number}, though other numbers \
                 have a decimal comma"
            )
        });
        thousands.chain(decimal).collect()
    }
}

impl Cell {
    fn new(record: &StringRecord, meaning: Meaning, text: &str, number: Decimal) -> Self {
        let (line, text) = (line_of(record), text.escape_debug().to_string());
        Self { line, column: meaning.name(), text, number: number.number() }
    }

    fn doubt(&self) -> String {
        let Self { column, text, number, .. } = self;
        let decimal: f64 = text.parse().unwrap_or_default();
        format!("column {column}: `{text}` may be {decimal} or {number}")
    }
}

/// Refuses dwell times of stops such as `A:pick:3.000`.
fn check_stops(columns: &Columns, record: &StringRecord) -> Result<(), yaml::Error> {
    let stops = columns.cell(record, Meaning::Stops).unwrap_or_default();
    for text in stops.split_whitespace().filter_map(|stop| stop.splitn(3, ':').nth(2)) {
        if let Some(number @ Decimal::Grouped(_)) = Decimal::parse(text) {
            let cell = Cell::new(record, Meaning::Stops, text, number);
            let reason = format!("{}: write it without a point", cell.doubt());
            return Err(yaml::Error { line: cell.line, reason });
        }
    }
    Ok(())
}

/// The cells of a record that may be times in seconds.
fn times_of<'a>(
    columns: &'a Columns,
    record: &'a StringRecord,
) -> impl Iterator<Item = (Meaning, &'a str)> {
    TIMES.into_iter().filter_map(|meaning| Some((meaning, columns.cell(record, meaning)?)))
}

#[cfg(test)]
mod tests {
    use crate::file::Table;

    fn secs(text: &str) -> Vec<f64> {
        let table = Table::parse(text).expect(text);
        assert!(table.problems.is_empty(), "{text}: {:?}", table.problems);
        table.orders.iter().map(|order| order.secs).collect()
    }

    #[test]
    fn points_separate_thousands_where_other_numbers_have_commas() {
        let text = "from;to;time;amount\nA;B;3,5;1\nA;B;3.000;1\nA;B;1.234,5;1\nA;B;1.234.567;1\n";
        assert_eq!(secs(text), [3.5, 3000.0, 1234.5, 1_234_567.0]);
        let told = Table::parse(text).expect("a table").notes;
        assert_eq!(told.len(), 1, "{told:?}");
        assert!(told[0].starts_with("line 3: the time `3.000` is read as 3000"), "{told:?}");
        let amounts = "from;to;time;amount\nA;B;3.000;1,5\nA;B;4.000;1\n";
        assert_eq!(secs(amounts), [3000.0, 4000.0]);
        let told = Table::parse(amounts).expect("a table").notes;
        assert!(told[0].ends_with("(2 such numbers)"), "{told:?}");
    }

    #[test]
    fn points_stay_decimal_without_commas() {
        for text in ["from;to;time\nA;B;3.000\n", "from,to,time\nA,B,3.000\n"] {
            assert_eq!(secs(text), [3.0]);
            assert!(Table::parse(text).expect("a table").notes.is_empty());
        }
        assert_eq!(secs("from;to;time\nA,5;B;3.000\n1,5;B;4.000\n"), [3.0, 4.0], "names");
    }

    #[test]
    fn a_number_that_may_be_two_is_refused() {
        let text = "from;to;time\nA;B;3,5\nA;B;3.5\nA;B;3.000\n";
        let table = Table::parse(text).expect("a table");
        let problem = table.problems[0].to_string();
        assert!(problem.starts_with("line 4: column time: `3.000` may be 3 or 3000"), "{problem}");
        assert_eq!((table.problems.len(), table.orders.len()), (1, 2));
        assert!(table.notes[0].starts_with("line 3: the time `3.5` is read as 3.5"));
        let stops = Table::parse("stops;time\nA:pick:3.000 B;1,5\n").expect("a table");
        assert!(stops.problems[0].reason.contains("may be 3 or 3000"), "{:?}", stops.problems);
    }
}
