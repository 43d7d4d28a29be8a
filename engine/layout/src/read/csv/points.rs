//! Numbers with a point in a file whose other numbers have decimal commas: none is read in a way
//! that isn't told.

use regatta_base::Decimal;

use crate::model::finding::Report;
use crate::model::value::shorten;

/// The largest number of errors.
const MAX_ERRORS: usize = 100;

/// Numbers with a point of a file.
#[derive(Debug, Default)]
pub(super) struct Points {
    /// Numbers such as `3.000`, up to [`MAX_ERRORS`].
    grouped: Vec<Cell>,
    /// The number of these.
    count: usize,
    /// The first number such as `3.5`.
    decimal: Option<Cell>,
}

/// A cell of a number.
#[derive(Debug)]
struct Cell {
    at: u32,
    column: String,
    text: String,
    number: f64,
}

impl Points {
    /// Adds a number, given its place, the name of its column and its text.
    pub fn add(&mut self, at: u32, column: &str, text: &str, number: Decimal) {
        let is_kept = match number {
            Decimal::Plain(_) => return,
            Decimal::Grouped(_) => self.grouped.len() < MAX_ERRORS,
            Decimal::Point(_) => self.decimal.is_none(),
        };
        self.count += usize::from(matches!(number, Decimal::Grouped(_)));
        if !is_kept {
            return;
        }
        let (column, text) = (shorten(column).to_string(), shorten(text).to_string());
        let cell = Cell { at, column, text, number: number.number() };
        match number {
            Decimal::Point(_) => self.decimal = Some(cell),
            _ => self.grouped.push(cell),
        }
    }

    /// Tells how points are read: an error where they may be both.
    pub fn report(self, report: &mut Report<'_>) {
        match &self.decimal {
            Some(decimal) => {
                for cell in &self.grouped {
                    report.file_error(cell.at, cell.doubt(decimal));
                }
                report.file_warning(decimal.at, decimal.mixed());
            }
            None => {
                if let Some(first) = self.grouped.first() {
                    report.file_warning(first.at, first.thousands(self.count));
                }
            }
        }
    }
}

impl Cell {
    fn thousands(&self, count: usize) -> String {
        let Self { column, text, number, .. } = self;
        let times = if count == 1 { String::new() } else { format!(" ({count} such numbers)") };
        format!(
            "`{column}` is `{text}`, which is read as {number}: other numbers of the file have a \
             decimal comma, so its point separates thousands{times}"
        )
    }

    fn doubt(&self, other: &Self) -> String {
        let Self { column, text, number, .. } = self;
        format!(
            "`{column}` is `{text}`, which may be {number} or {}: other numbers of the file have a \
             decimal comma, and `{}` a decimal point; write one kind of numbers",
            text.parse::<f64>().unwrap_or_default(),
            other.text
        )
    }

    fn mixed(&self) -> String {
        let Self { column, text, number, .. } = self;
        format!(
            "`{column}` is `{text}`, which is read as {number}: other numbers of the file have a \
             decimal comma; write one kind of numbers"
        )
    }
}
