//! Tables of orders: CSV as people and warehouses write it.

use std::borrow::Cow;
use std::collections::BTreeMap;

use csv::StringRecord;
use encoding_rs::{Encoding, WINDOWS_1252};
use regatta_base::yaml;

use super::clock::{self, FileTime};
use super::columns::{Columns, Meaning, names};
use super::points::Points;
use super::workbook::WITHOUT_VALUE;
use super::{TimedDraft, csv_stop};
use crate::draft::{DraftError, Label, MAX_STOPS, OrderDraft, StopDraft, secs};
use crate::order::Action;

/// The separators of columns.
const SEPARATORS: [u8; 4] = *b",;\t|";
/// Times of day and dates begin at a full hour.
const HOUR_SECS: f64 = 3600.0;
/// The longest time between dates of a file that are numbers of days.
const MOST_DAYS: f64 = 366.0;
/// The most columns, rows, and stops of all rows: each takes up to 700 times its bytes in memory.
const MOST_COLUMNS: usize = 1_000;
const MOST_ROWS: usize = 1_000_000;
const MOST_STOPS: usize = 3_000_000;

/// A table of orders as far as it can be read.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    /// The orders of the rows without a problem.
    pub orders: Vec<TimedDraft>,
    /// The columns.
    pub columns: Columns,
    /// The rows that can't be read, in their order.
    pub problems: Vec<yaml::Error>,
    /// The time at which simulated time begins, if the file has dates or times of day: seconds
    /// since midnight or since 1970.
    pub begin: Option<FileTime>,
    /// The line from which on times of day are those of the next day, if there is one: see
    /// [`clock::midnight`].
    pub midnight_line: Option<usize>,
    /// Whether a row has a time.
    pub has_times: bool,
    /// The names of the sheets of a workbook that have cells, too, and aren't read.
    pub unread_sheets: Vec<String>,
    /// The number of rows that a workbook hides, by a filter or by hand: they are read as all others.
    pub hidden_rows: usize,
    /// Sentences that tell how numbers with points were read, if others have decimal commas.
    pub notes: Vec<String>,
}

/// A row whose times aren't seconds of simulated time yet.
struct Row {
    line: usize,
    draft: OrderDraft,
    time: Option<FileTime>,
    earliest: Option<FileTime>,
    deadline: Option<FileTime>,
}

impl Row {
    fn times(&mut self) -> [&mut Option<FileTime>; 3] {
        [&mut self.time, &mut self.earliest, &mut self.deadline]
    }

    /// Gives times of day their days: all from the line behind a midnight on are those of the next
    /// day, as are deadlines that would be long before the order's time; beside an order's date,
    /// they are times of that day or the next one.
    fn set_days(&mut self, midnight_line: Option<usize>) {
        if midnight_line.is_some_and(|line| self.line >= line) {
            for time in self.times() {
                *time = time.map(FileTime::next_day);
            }
        }
        if let Some(time) = self.time {
            self.earliest = self.earliest.map(|earliest| clock::on_day_of(earliest, time));
            self.deadline = self.deadline.map(|deadline| clock::due_after(deadline, time));
        }
    }
}

/// Whether the times of a workbook are dates without a date's format: numbers of days since 1900.
/// Seconds of a simulation don't all begin ten hours after its start within minutes, with parts.
fn are_dates(rows: &[Row]) -> bool {
    let (mut first, mut last, mut has_parts) = (f64::INFINITY, f64::NEG_INFINITY, false);
    for time in rows.iter().filter_map(|row| row.time) {
        let FileTime::Secs(number) = time else { return false };
        (first, last) = (first.min(number), last.max(number));
        has_parts |= number.fract() != 0.0;
    }
    has_parts && clock::SERIALS.contains(&first) && last - first <= MOST_DAYS
}

/// Returns the text of a file: UTF-8, UTF-16 with a byte order mark, or else Windows-1252.
pub fn text_of(bytes: &[u8]) -> Cow<'_, str> {
    match (Encoding::for_bom(bytes), std::str::from_utf8(bytes)) {
        (None, Ok(text)) => Cow::Borrowed(text),
        (Some((encoding, _)), _) => encoding.decode(bytes).0,
        (None, Err(_)) => WINDOWS_1252.decode(bytes).0,
    }
}

impl Table {
    /// Reads a text of CSV.
    ///
    /// # Errors
    /// [`yaml::Error`] if the header is missing or can't be understood, or the table is too large.
    pub fn parse(text: &str) -> Result<Self, yaml::Error> {
        // The reader counts lines by their feeds, and one too few after each pair of both.
        let text = text.strip_prefix('\u{feff}').unwrap_or(text).replace("\r\n", "\n");
        let mut builder = csv::ReaderBuilder::new();
        builder.comment(Some(b'#')).delimiter(separator(&text));
        let points = Self::points(&mut builder, &text)?;
        let (mut table, rows) = Self::read(&mut builder, &text, points)?;
        table.add(rows);
        Ok(table)
    }

    /// Reads a sheet of a workbook, as [`workbook`](super::workbook) returns it.
    pub(super) fn parse_sheet(text: &str) -> Result<Self, yaml::Error> {
        let mut builder = csv::ReaderBuilder::new();
        let (mut table, mut rows) = Self::read(&mut builder, text, Points::default())?;
        if are_dates(&rows) {
            for time in rows.iter_mut().flat_map(Row::times) {
                *time = time.map(FileTime::from_serial);
            }
        }
        table.add(rows);
        Ok(table)
    }

    /// Looks at the numbers of all rows.
    fn points(builder: &mut csv::ReaderBuilder, text: &str) -> Result<Points, yaml::Error> {
        let mut reader = builder.trim(csv::Trim::All).flexible(true).from_reader(text.as_bytes());
        let header = reader.headers().map_err(csv_error)?;
        let line = line_of(header);
        let columns = Columns::of(header).map_err(|reason| yaml::Error { line, reason })?;
        Ok(Points::of(&columns, reader.records().map_while(Result::ok).take(MOST_ROWS)))
    }

    /// Reads the rows that can be read, and finds problems of the others.
    fn read(
        builder: &mut csv::ReaderBuilder,
        text: &str,
        mut points: Points,
    ) -> Result<(Self, Vec<Row>), yaml::Error> {
        builder.trim(csv::Trim::All).flexible(true);
        let mut reader = builder.from_reader(text.as_bytes());
        let header = reader.headers().map_err(csv_error)?;
        let line = line_of(header);
        check_count(line, header.len(), MOST_COLUMNS, "columns: remove some")?;
        let columns = Columns::of(header).map_err(|reason| yaml::Error { line, reason })?;
        let (mut rows, mut table) = (Vec::new(), Self { columns, ..Self::default() });
        let mut stops = 0;
        for (record, count) in reader.records().zip(1..) {
            let record = record.map_err(csv_error);
            let record = record.and_then(|record| points.without_thousands(&table.columns, record));
            match record.and_then(|record| table.row(&record)) {
                Ok(Some(row)) => {
                    stops += row.draft.destinations.len();
                    check_count(row.line, stops, MOST_STOPS, "stops: split the file")?;
                    rows.push(row);
                }
                Ok(None) => {}
                Err(problem) => table.problems.push(problem),
            }
            check_count(count + 1, count, MOST_ROWS, "rows: split the file")?;
        }
        table.notes = points.notes();
        Ok((table, rows))
    }

    /// Adds the orders of rows.
    fn add(&mut self, rows: Vec<Row>) {
        self.set_times(rows);
        self.find_repeated_names();
        self.problems.sort_by_key(|problem| problem.line);
    }

    /// Returns all orders.
    ///
    /// # Errors
    /// The first problem.
    pub fn into_orders(self) -> Result<Vec<TimedDraft>, yaml::Error> {
        match self.problems.into_iter().next() {
            Some(problem) => Err(problem),
            None => Ok(self.orders),
        }
    }

    /// Reads a row; `None` if all of its cells are empty.
    fn row(&self, record: &StringRecord) -> Result<Option<Row>, yaml::Error> {
        let line = line_of(record);
        if record.iter().all(str::is_empty) {
            return Ok(None);
        }
        let row = self.read_row(line, record);
        row.map(Some).map_err(|reason| yaml::Error { line, reason })
    }

    fn read_row(&self, line: usize, record: &StringRecord) -> Result<Row, String> {
        let (columns, expected) = (record.len(), self.columns.len());
        if columns != expected {
            return Err(format!("{columns} columns instead of {expected}"));
        }
        let mut used = self.columns.used_cells(record);
        if let Some((header, cell)) = used.find(|(_, cell)| cell.ends_with(WITHOUT_VALUE)) {
            return Err(format!("the column `{header}` is {cell}"));
        }
        let priority = match self.columns.cell(record, Meaning::Priority) {
            Some(text) => {
                let shown = text.escape_debug();
                text.parse().map_err(|_| format!("`{shown}` isn't a priority from 0 to 255"))?
            }
            None => 0,
        };
        let [robot, types] =
            [Meaning::Robot, Meaning::RobotTypes].map(|meaning| self.columns.cell(record, meaning));
        let draft = OrderDraft {
            name: self.columns.cell(record, Meaning::Name).map(str::to_owned),
            destinations: self.stops(record)?,
            priority,
            intended_vehicle: robot.map(|text| Label::Name(text.to_owned())),
            robot_types: types.map(names).unwrap_or_default(),
            ..OrderDraft::default()
        };
        Ok(Row {
            line,
            draft,
            time: self.time(record)?,
            earliest: self.time_in(record, Meaning::Earliest)?,
            deadline: self.time_in(record, Meaning::Deadline)?,
        })
    }

    fn stops(&self, record: &StringRecord) -> Result<Vec<StopDraft>, String> {
        if let Some(stops) = self.columns.cell(record, Meaning::Stops) {
            return match stops.split_whitespace().count() {
                0..=MAX_STOPS => stops.split_whitespace().map(csv_stop).collect(),
                count => Err(DraftError::Stops(count).to_string()),
            };
        }
        if self.columns.have(Meaning::Stops) {
            return Err("the stops are missing".to_owned());
        }
        let ends = [(Meaning::From, Action::Pick), (Meaning::To, Action::Drop)];
        let stops = ends.map(|(meaning, operation)| match self.columns.cell(record, meaning) {
            Some(name) => {
                let location_name = Label::Name(name.to_owned());
                Ok(StopDraft { location_name, operation, dwell: 0.0 })
            }
            None => Err(format!("the station `{}` is missing", meaning.name())),
        });
        stops.into_iter().collect()
    }

    /// Returns the time of creation, of which the date may have a column of its own.
    fn time(&self, record: &StringRecord) -> Result<Option<FileTime>, String> {
        let [date, time] =
            [Meaning::Date, Meaning::Time].map(|meaning| self.columns.cell(record, meaning));
        match (date, time) {
            (Some(date), Some(time)) => time_of(Meaning::Time, &format!("{date} {time}")).map(Some),
            (date, time) => time.or(date).map(|text| time_of(Meaning::Time, text)).transpose(),
        }
    }

    fn time_in(&self, record: &StringRecord, meaning: Meaning) -> Result<Option<FileTime>, String> {
        self.columns.cell(record, meaning).map(|text| time_of(meaning, text)).transpose()
    }

    /// Turns the times of rows into seconds of simulated time, which begins at the full hour before
    /// the first time of day or date.
    fn set_times(&mut self, mut rows: Vec<Row>) {
        let times = rows.iter().filter_map(|row| Some((row.line, row.time?)));
        self.midnight_line = clock::midnight(times);
        for row in &mut rows {
            row.set_days(self.midnight_line);
        }
        let first = rows.iter().find_map(|row| Some((row.line, row.time?)));
        self.has_times = first.is_some();
        let earliest = rows.iter().filter_map(|row| row.time).map(FileTime::secs);
        let begin_secs = match first {
            None | Some((_, FileTime::Secs(_))) => 0.0,
            Some(_) => (earliest.fold(f64::INFINITY, f64::min) / HOUR_SECS).floor() * HOUR_SECS,
        };
        self.begin = match first {
            Some((_, FileTime::Clock(_))) => Some(FileTime::Clock(begin_secs)),
            Some((_, FileTime::Local(_))) => Some(FileTime::Local(begin_secs)),
            Some((_, FileTime::Instant(_))) => Some(FileTime::Instant(begin_secs)),
            _ => None,
        };
        let form = Form { first, begin_secs };
        for row in rows {
            let line = row.line;
            match form.timed(row) {
                Ok(order) => self.orders.push(order),
                Err(reason) => self.problems.push(yaml::Error { line, reason }),
            }
        }
    }

    /// Finds orders with the name of one before: they are problems.
    fn find_repeated_names(&mut self) {
        let mut lines: BTreeMap<String, usize> = BTreeMap::new();
        for TimedDraft { line, draft, .. } in &self.orders {
            let Some(name) = &draft.name else { continue };
            match lines.get(name) {
                Some(first) => {
                    let name = name.escape_debug();
                    let reason = format!(
                        "there are two orders `{name}`, the first in line {first}: give each a \
                         name of its own"
                    );
                    self.problems.push(yaml::Error { line: *line, reason });
                }
                None => drop(lines.insert(name.clone(), *line)),
            }
        }
    }
}

/// The line and the form of the first time of a file, and the start of simulated time.
#[derive(Clone, Copy)]
struct Form {
    first: Option<(usize, FileTime)>,
    begin_secs: f64,
}

impl Form {
    /// Returns the simulated time of a cell, if it has the form of the first one.
    fn secs_of(self, meaning: Meaning, time: Option<FileTime>) -> Result<Option<f64>, String> {
        let Some(time) = time else { return Ok(None) };
        match self.first {
            Some((line, first)) if first.kind() != time.kind() => Err(format!(
                "`{}` is {}, and the time in line {line} is {}: write all in one form",
                meaning.name(),
                time.kind(),
                first.kind()
            )),
            _ => Ok(Some(time.secs() - self.begin_secs)),
        }
    }

    /// Returns the order of a row.
    fn timed(self, row: Row) -> Result<TimedDraft, String> {
        let created = self.secs_of(Meaning::Time, row.time)?;
        match (created, self.first) {
            // Orders without a time come at the beginning, where times are those of the simulation.
            (Some(_), _) | (None, None | Some((_, FileTime::Secs(_)))) => {}
            (None, Some((line, _))) => {
                return Err(format!("the time is missing, which line {line} has"));
            }
        }
        let created = secs("time", created.unwrap_or(0.0)).map_err(|error| error.to_string())?;
        let earliest = self.secs_of(Meaning::Earliest, row.earliest)?;
        let deadline = self.secs_of(Meaning::Deadline, row.deadline)?;
        if deadline.is_some_and(|deadline| deadline < created) {
            return Err("the deadline is before the time of creation".to_owned());
        }
        let earliest_start = earliest.map(|secs| secs.max(0.0));
        let draft = OrderDraft { earliest_start, deadline, ..row.draft };
        Ok(TimedDraft { line: row.line, secs: created, draft })
    }
}

fn time_of(meaning: Meaning, text: &str) -> Result<FileTime, String> {
    clock::parse(text)
        .map_err(|error| format!("column {}: `{}` {error}", meaning.name(), text.escape_debug()))
}

/// Returns the separator of columns: that which the header has most often.
fn separator(text: &str) -> u8 {
    let header = text.lines().find(|line| !line.trim().is_empty() && !line.starts_with('#'));
    let header = header.unwrap_or_default().as_bytes();
    // The comma is the last of equals.
    let counted = SEPARATORS
        .into_iter()
        .rev()
        .max_by_key(|separator| header.iter().filter(|byte| *byte == separator).count());
    counted.unwrap_or(b',')
}

/// Returns the line of a record, from 1.
pub(super) fn line_of(record: &StringRecord) -> usize {
    record.position().map_or(1, |position| position.line() as usize)
}

/// Checks that there are no more things than can be read.
fn check_count(line: usize, count: usize, most: usize, things: &str) -> Result<(), yaml::Error> {
    if count <= most {
        return Ok(());
    }
    Err(yaml::Error { line, reason: format!("more than {most} {things}") })
}

fn csv_error(error: csv::Error) -> yaml::Error {
    let line = error.position().map_or(1, |position| position.line() as usize);
    yaml::Error { line, reason: error.to_string() }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(text: &str) -> Table {
        Table::parse(text).expect(text)
    }

    fn rows(table: &Table) -> Vec<(f64, Option<f64>, [String; 2])> {
        let orders = table.orders.iter();
        let stops = |draft: &OrderDraft| {
            [0, 1].map(|stop| draft.destinations[stop].location_name.to_string())
        };
        orders.map(|order| (order.secs, order.draft.deadline, stops(&order.draft))).collect()
    }

    #[test]
    fn exports_of_warehouses_are_read() {
        let expected = vec![
            (900.0, Some(2700.0), ["Goods in 1".to_owned(), "Lager Süd".to_owned()]),
            (4500.5, None, ["B".to_owned(), "C".to_owned()]),
        ];
        for text in [
            "id,from,to,time,due\n1,Goods in 1,Lager Süd,900,2700\n2,B,C,4500.5,\n",
            "\u{feff}Nr;Auftrag;Von;Nach;Zeit;Fällig\n7;1;Goods in 1;Lager Süd;900;2700\n8;2;B;C;4500,5;\n;;;;;\n",
            "order\tsource\tdestination\trelease\tdeadline\n1\tGoods in 1\tLager Süd\t06:15\t06:45\n\
             2\tB\tC\t07:15:00.5\t\n",
            "Quelle;Ziel;Datum;Uhrzeit;Termin\nGoods in 1;Lager Süd;26.11.2026;06:15;26.11.26 06:45\n\
             B;C;26.11.2026;07:15:00,5;\n",
            "from|to|created|due\nGoods in 1|Lager Süd|2026-11-26T06:15:00+01:00|2026-11-26T05:45:00Z\n\
             B|C|2026-11-26T07:15:00.5+01:00|\n",
        ] {
            let table = table(text);
            assert_eq!((rows(&table), &table.problems), (expected.clone(), &Vec::new()), "{text}");
        }
    }

    #[test]
    fn a_night_shift_goes_on_after_midnight() {
        let night = table(
            "from,to,time,due\nA,B,22:00,22:30\nA,B,23:50,00:20\nA,B,00:05,00:35\nA,B,05:00,\n",
        );
        let times: Vec<_> = rows(&night).iter().map(|row| (row.0, row.1)).collect();
        let minutes = |minutes: f64| minutes * 60.0;
        let expected = [
            (0.0, Some(minutes(30.0))),
            (minutes(110.0), Some(minutes(140.0))),
            (minutes(125.0), Some(minutes(155.0))),
            (minutes(420.0), None),
        ];
        assert_eq!((times.as_slice(), night.midnight_line), (&expected[..], Some(4)));
        // Two lists below each other, a row in the wrong place, and one that isn't sorted.
        for times in ["06:00 22:00 06:10 21:00", "10:00 11:00 09:00", "23:00 01:00 23:30 02:00"] {
            let text: String = times.split(' ').map(|time| format!("A,B,{time}\n")).collect();
            assert_eq!(table(&format!("from,to,time\n{text}")).midnight_line, None, "{times}");
        }
    }

    #[test]
    fn a_time_of_day_beside_a_date_is_of_that_day_or_the_next() {
        let table = table(
            "from,to,time,notbefore,due\nA,B,2026-11-26 08:00,08:10,09:00\n\
             A,B,2026-11-26 23:30,,00:15\nA,B,2026-11-27 22:00,06:00,06:30\n\
             A,B,2026-11-27 10:00,,2026-11-27 11:00\nA,B,2026-11-27 10:00,,600\n",
        );
        let times: Vec<_> = table
            .orders
            .iter()
            .map(|order| (order.secs, order.draft.earliest_start, order.draft.deadline))
            .collect();
        let hour = 3600.0;
        let expected = [
            (0.0, Some(600.0), Some(hour)),
            (15.5 * hour, None, Some(16.25 * hour)),
            (38.0 * hour, Some(46.0 * hour), Some(46.5 * hour)),
            (26.0 * hour, None, Some(27.0 * hour)),
        ];
        assert_eq!(times, expected, "{:?}", table.problems);
        assert_eq!(table.problems.len(), 1, "seconds beside dates");
        let zone = "from,to,time,due\nA,B,2026-11-26T08:00+01:00,09:00\n";
        let problem = &Table::parse(zone).expect("a table").problems[0].reason;
        assert!(problem.contains("`deadline` is a time of day"), "the zone isn't known: {problem}");
    }

    #[test]
    fn a_table_that_would_fill_the_memory_is_refused() {
        let columns = ",a".repeat(MOST_COLUMNS);
        let rows = "A\n".repeat(MOST_ROWS + 1);
        let stops = format!("{}\n", "A ".repeat(MAX_STOPS)).repeat(MOST_STOPS / MAX_STOPS + 1);
        for (text, reason) in [
            (format!("stops{columns}\n"), "line 1: more than 1000 columns"),
            (format!("stops\n{rows}"), "line 1000002: more than 1000000 rows"),
            (format!("stops\n{stops}"), "line 3002: more than 3000000 stops"),
        ] {
            let error = Table::parse(&text).expect_err(reason).to_string();
            assert!(error.starts_with(reason), "{error}");
        }
    }

    #[test]
    fn dates_of_a_workbook_without_a_format_are_dates() {
        let rows = "from,to,time,due\nA,B,46082.25,46082.375\nA,B,46082.5,\n";
        let table = Table::parse_sheet(rows).expect("a table");
        let times: Vec<_> = table.orders.iter().map(|o| (o.secs, o.draft.deadline)).collect();
        assert_eq!(times, [(0.0, Some(10_800.0)), (21_600.0, None)]);
        assert_eq!(table.begin.map(|begin| begin.to_string()).as_deref(), Some("2026-03-01 06:00"));
        for seconds in ["46082\nA,B,46100", "46082.5\nA,B,50000", "3600.5\nA,B,3700"] {
            let text = format!("from,to,time\nA,B,{seconds}\n");
            assert_eq!(Table::parse_sheet(&text).expect("a table").begin, None, "{seconds}");
        }
    }

    #[test]
    fn a_row_without_stops_is_told_as_such() {
        let table = table("name,stops\na,A B\nb,\n");
        assert_eq!((table.orders.len(), &*table.problems[0].reason), (1, "the stops are missing"));
    }

    #[test]
    fn lines_are_those_of_an_editor() {
        for text in ["from,to,time\nA,B,1\nA,B,x\n", "from,to,time\r\nA,B,1\r\nA,B,x\r\n"] {
            assert_eq!(table(text).problems[0].line, 3, "{text:?}");
        }
    }

    #[test]
    fn windows_and_utf_16_are_decoded() {
        let text = "Quelle;Ziel\nSüd – 1;Öl €\n";
        let (windows, ..) = WINDOWS_1252.encode(text);
        assert_eq!(text_of(&windows), text);
        let utf_16: Vec<u8> =
            [0xfeff].into_iter().chain(text.encode_utf16()).flat_map(u16::to_le_bytes).collect();
        assert_eq!(text_of(&utf_16), text);
        assert_eq!(text_of(text.as_bytes()), text);
    }

    #[test]
    fn each_bad_row_is_a_line_and_the_others_are_read() {
        let table = table(
            "id,from,to,time,due,prio\n1,A,B,08:00,09:00,\n2,A,B,25:00,,\n3,A,,08:10,,\n\
             4,A,B,08:20,08:10,\n1,A,B,08:30,,\n5,A,B,2026-11-26 09:00,,\n6,A,B,,,\n\
             7,A,B,08:40,600,\n8,A,B,08:50,,300\n9,A,B\n",
        );
        let problems: Vec<String> = table.problems.iter().map(ToString::to_string).collect();
        let expected = [
            "line 3: column time: `25:00` has an hour",
            "line 4: the station `to` is missing",
            "line 5: the deadline is before",
            "line 6: there are two orders `1`, the first in line 2",
            "line 7: `time` is a date without a zone, and the time in line 2 is a time of day",
            "line 8: the time is missing, which line 2 has",
            "line 9: `deadline` is seconds, and the time in line 2 is a time of day",
            "line 10: `300` isn't a priority",
            "line 11: 3 columns instead of 6",
        ];
        assert_eq!(problems.len(), expected.len(), "{problems:#?}");
        for (problem, expected) in problems.iter().zip(expected) {
            assert!(problem.contains(expected), "{problem}");
        }
    }
}
