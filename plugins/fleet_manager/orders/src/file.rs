//! Files of orders with times: YAML, CSV, a workbook of Excel or Parquet.
//!
//! YAML is a list (or a map with the list `orders`) of `{name: …, time: 12.5, priority: 3,
//! earliest: 20, deadline: 600, stops: [{at: A1, action: pick, dwell: 5}, B2]}`, where only `stops`
//! must be there, and a stop without action and dwell time may be a name alone. `robot: 7` or
//! `robot_types: [forklift]` are the robots that may get it.
//!
//! CSV has a line of headers, in any case and order, from which the meanings of columns are guessed
//! ([`columns`]). Our own files have `name,time,priority,earliest,deadline,stops,robot,robottypes`,
//! of which only `stops` must be there, separated by spaces; each is `place`, `place:action` or
//! `place:action:dwell`; `%20`, `%3A` and `%25` in names are a space, a colon and a per cent sign. Other
//! files have `from` and `to`. Times are in seconds of simulated time, or as [`clock`] reads them.
//!
//! A workbook (XLSX) has the same table in its first sheet with cells; a file of Parquet has it in
//! flat columns.

pub mod clock;
pub mod columns;
mod hidden;
#[cfg(feature = "parquet")]
mod parquet;
mod points;
mod rows;
pub mod table;
mod workbook;

use std::borrow::Cow;
use std::path::{Path, PathBuf};

use regatta_base::file;
use regatta_base::yaml::{self, Node};

pub use clock::FileTime;
pub use table::Table;

use self::table::text_of as decoded;
use super::draft::{Label, OrderDraft, StopDraft, secs};
use super::order::{Action, UnknownAction};

/// An order of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct TimedDraft {
    /// The line, from 1.
    pub line: usize,
    /// The simulated time, in seconds, at which it is added to the pool.
    pub secs: f64,
    /// The order.
    pub draft: OrderDraft,
}

/// The error of reading a file of orders or a load.
#[derive(Debug, thiserror::Error)]
pub enum FileError {
    /// The file can't be read.
    #[error("can't read {} ({reason})", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The reason.
        reason: std::io::Error,
    },
    /// It has an error.
    #[error("{}, {error}", path.display())]
    Invalid {
        /// The file.
        path: PathBuf,
        /// The line and the reason.
        error: yaml::Error,
    },
}

/// The size of the largest file that is read.
const MAX_BYTES: u64 = 256 << 20;

/// The text of a file, read at once.
pub(super) fn text_of(path: &Path) -> Result<String, FileError> {
    file::read_text(path, MAX_BYTES)
        .map_err(|reason| FileError::Read { path: path.to_owned(), reason })
}

fn bytes_of(path: &Path) -> Result<Vec<u8>, FileError> {
    file::read(path, MAX_BYTES).map_err(|reason| FileError::Read { path: path.to_owned(), reason })
}

/// Reads a file of orders: a table by the ending of its name (`.csv`, `.tsv`, `.txt`, `.xlsx`,
/// `.xlsm`, with the feature `parquet` also `.parquet`), and YAML otherwise.
///
/// # Errors
/// [`FileError`] if it can't be read or has an error.
pub fn read_orders(path: &Path) -> Result<Vec<TimedDraft>, FileError> {
    let orders = read_table(path)?.into_orders();
    orders.map_err(|error| FileError::Invalid { path: path.to_owned(), error })
}

/// Reads a file of orders as far as it can be read: its rows with an error are told.
///
/// # Errors
/// [`FileError`] if it can't be read at all.
pub fn read_table(path: &Path) -> Result<Table, FileError> {
    let ending = path.extension().unwrap_or_default().to_ascii_lowercase();
    let table = match ending.to_str() {
        Some("csv" | "tsv" | "txt") => Table::parse(&decoded(&bytes_of(path)?)),
        Some("xlsx" | "xlsm") => workbook::sheet_of(&bytes_of(path)?)
            .map_err(|reason| yaml::Error { line: 1, reason })
            .and_then(|sheet| {
                let table = Table::parse_sheet(&sheet.csv)?;
                Ok(Table { unread_sheets: sheet.others, hidden_rows: sheet.hidden, ..table })
            }),
        #[cfg(feature = "parquet")]
        Some("parquet" | "pq") => parquet::csv_of(bytes_of(path)?)
            .map_err(|reason| yaml::Error { line: 1, reason })
            .and_then(|sheet| Table::parse_sheet(&sheet)),
        _ => parse_yaml(&text_of(path)?).map(|orders| Table { orders, ..Table::default() }),
    };
    table.map_err(|error| FileError::Invalid { path: path.to_owned(), error })
}

/// Returns orders as a text of CSV, which [`parse_csv`] reads.
pub fn to_csv(orders: &[TimedDraft]) -> String {
    let mut writer = csv::Writer::from_writer(Vec::new());
    // Writing to memory never fails.
    let _ = writer.write_record(HEADERS);
    for TimedDraft { line, secs, draft } in orders {
        let secs_or_none =
            |secs: Option<f64>| secs.map_or_else(String::new, |secs| secs.to_string());
        let stops: Vec<String> = draft.destinations.iter().map(csv_text).collect();
        let _ = writer.write_record([
            draft.name.clone().unwrap_or_else(|| format!("line-{line}")),
            secs.to_string(),
            draft.priority.to_string(),
            secs_or_none(draft.earliest_start),
            secs_or_none(draft.deadline),
            stops.join(" "),
            draft.intended_vehicle.as_ref().map(Label::to_string).unwrap_or_default(),
            draft.robot_types.join(","),
        ]);
    }
    String::from_utf8(writer.into_inner().unwrap_or_default()).unwrap_or_default()
}

/// The characters of names that separate stops and their parts, and how they are written there.
const ESCAPES: [(char, &str); 3] = [('%', "%25"), (' ', "%20"), (':', "%3A")];

fn csv_text(stop: &StopDraft) -> String {
    let mut text = stop.location_name.to_string();
    for (letter, escaped) in ESCAPES {
        text = text.replace(letter, escaped);
    }
    format!("{text}:{}:{}", stop.operation.name(), stop.dwell)
}

fn unescaped(text: &str) -> String {
    let mut text = text.to_owned();
    for (letter, escaped) in ESCAPES.iter().rev() {
        text = text.replace(escaped, &letter.to_string());
    }
    text
}

/// Parses a YAML text of orders.
///
/// # Errors
/// [`yaml::Error`] for the first thing that is wrong.
pub fn parse_yaml(text: &str) -> Result<Vec<TimedDraft>, yaml::Error> {
    let document = yaml::parse(text)?;
    let list = if document.is_map() {
        document.fields(&["orders"])?.required("orders")?
    } else {
        &document
    };
    list.list()?.iter().map(yaml_order).collect()
}

fn yaml_order(order: &Node) -> Result<TimedDraft, yaml::Error> {
    let fields = order.fields(&FIELDS)?;
    let stops = fields.required("stops")?.list()?;
    let draft = OrderDraft {
        name: fields.optional("name", Node::text)?.map(Cow::into_owned),
        destinations: stops.iter().map(yaml_stop).collect::<Result<_, _>>()?,
        priority: fields.optional("priority", |value| value.integer(255))?.unwrap_or(0) as u8,
        earliest_start: fields.optional("earliest", Node::non_negative)?,
        deadline: fields.optional("deadline", Node::non_negative)?,
        intended_vehicle: fields
            .optional("robot", Node::text)?
            .map(|name| Label::Name(name.into_owned())),
        robot_types: fields.optional("robot_types", texts)?.unwrap_or_default(),
    };
    let secs = fields.optional("time", yaml_secs)?.unwrap_or(0.0);
    Ok(TimedDraft { line: order.line, secs, draft })
}

/// Reads a text, or a list of them.
pub(super) fn texts(value: &Node) -> Result<Vec<String>, yaml::Error> {
    let Ok(list) = value.list() else { return Ok(vec![value.text()?.into_owned()]) };
    list.iter().map(|item| item.text().map(Cow::into_owned)).collect()
}

fn yaml_stop(stop: &Node) -> Result<StopDraft, yaml::Error> {
    if !stop.is_map() {
        return Ok(StopDraft {
            location_name: Label::Name(stop.text()?.into_owned()),
            ..StopDraft::default()
        });
    }
    let fields = stop.fields(&["at", "action", "dwell"])?;
    Ok(StopDraft {
        location_name: Label::Name(fields.required("at")?.text()?.into_owned()),
        operation: fields.optional("action", yaml_action)?.unwrap_or_default(),
        dwell: fields.optional("dwell", Node::non_negative)?.unwrap_or(0.0),
    })
}

fn yaml_secs(value: &Node) -> Result<f64, yaml::Error> {
    secs("time", value.non_negative()?).map_err(|error| value.error(error.to_string()))
}

fn yaml_action(value: &Node) -> Result<Action, yaml::Error> {
    value.text()?.parse().map_err(|error: UnknownAction| value.error(error.to_string()))
}

/// Parses a CSV text of orders.
///
/// # Errors
/// [`yaml::Error`] for the first thing that is wrong.
pub fn parse_csv(text: &str) -> Result<Vec<TimedDraft>, yaml::Error> {
    Table::parse(text)?.into_orders()
}

/// The headers of our own CSV files.
const HEADERS: [&str; 8] =
    ["name", "time", "priority", "earliest", "deadline", "stops", "robot", "robottypes"];
/// The fields of an order in YAML.
const FIELDS: [&str; 8] =
    ["name", "time", "priority", "earliest", "deadline", "stops", "robot", "robot_types"];

fn parse_secs(field: &str, text: &str) -> Result<f64, String> {
    let secs = text.parse().ok().filter(|secs: &f64| secs.is_finite() && *secs >= 0.0);
    secs.ok_or_else(|| format!("`{}` isn't a number of seconds for `{field}`", text.escape_debug()))
}

fn csv_stop(text: &str) -> Result<StopDraft, String> {
    let mut parts = text.splitn(3, ':');
    let location_name = Label::Name(unescaped(parts.next().unwrap_or("")));
    let operation = parts.next().map_or(Ok(Action::None), |text| {
        text.parse().map_err(|error: UnknownAction| error.to_string())
    })?;
    let dwell = parts.next().map_or(Ok(0.0), |text| parse_secs("dwell", text))?;
    Ok(StopDraft { location_name, operation, dwell })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn yaml_and_csv_say_the_same() {
        let yaml = "orders:\n- {name: a, time: 2.5, priority: 3, deadline: 60, robot: 4, stops: [{at: A, action: pick, dwell: 5}, B]}\n- {stops: [7]}\n";
        let csv = "Stops,NAME,Time,priority,deadline,Robot\nA:pick:5 B,a,2.5,3,60,4\n7,,,,,\n";
        let (yaml, csv) = (parse_yaml(yaml).expect("orders"), parse_csv(csv).expect("orders"));
        assert_eq!((yaml.len(), &yaml[0].draft, yaml[0].secs), (2, &csv[0].draft, csv[0].secs));
        assert_eq!((&yaml[1].draft, yaml[1].line, csv[1].line), (&csv[1].draft, 3, 3));
        assert_eq!((yaml[0].draft.priority, yaml[0].draft.deadline), (3, Some(60.0)));
        assert_eq!(yaml[0].draft.intended_vehicle, Some(Label::Name("4".into())));
        assert_eq!(yaml[0].draft.destinations[0].operation, Action::Pick);
    }

    #[test]
    fn orders_are_the_same_after_csv() {
        let yaml = "- {name: 'a,b', time: 2.5, priority: 3, earliest: 3, deadline: 60, robot: 4, \
                    stops: [{at: 'Dock 1: 100%', action: pick, dwell: 5}, B]}\n\
                    - {stops: [7], robot_types: [tow truck, lift]}\n";
        let orders = parse_yaml(yaml).expect("orders");
        let again = parse_csv(&to_csv(&orders)).expect("orders");
        assert_eq!((&again[0].draft, again[0].secs), (&orders[0].draft, 2.5));
        assert_eq!(again[1].draft.name.as_deref(), Some("line-2"));
        assert_eq!(again[1].draft.robot_types, ["tow truck", "lift"]);
    }

    #[test]
    fn errors_name_the_line() {
        for (text, message) in [
            ("- stops: [A]\n- {stops: [A], prio: 1}", "line 2: unknown field `prio`"),
            ("- name: x", "line 1: `stops` is missing"),
            ("- stops: [A]\n  priority: 256", "line 2: expected an integer"),
            ("- stops: [A]\n  time: -1", "line 2: -1 is below 0"),
            ("- stops: [A]\n  time: 1e300", "line 2: `time` is 1"),
            ("- stops: [{at: A, action: lift}]", "unknown action `lift`"),
            ("a: [", "line"),
        ] {
            let error = parse_yaml(text).expect_err(text).to_string();
            assert!(error.contains(message), "{text}: {error}");
        }
        for (text, message) in [
            ("name\nx\n", "line 1: no column has the stops"),
            ("stops,time\nA,1\nA,x\n", "line 3: column time: `x` isn't a time"),
            ("stops\nA:none:x\n", "line 2: `x` isn't a number of seconds for `dwell`"),
            ("stops,time\nA\n", "line 2: 1 columns instead of 2"),
            ("stops\nA:lift\n", "unknown action `lift`"),
            ("stops,Stops\nA,A\n", "the columns `stops` and `Stops` may both be the stops"),
            ("stops,priority\nA,300\n", "`300` isn't a priority"),
            ("stops,priority\nA,\"1\n2\"\n", "`1\\n2` isn't a priority"),
            ("stops,time\nA,0\nA,1e300\n", "line 3: `time` is 1"),
        ] {
            let error = parse_csv(text).expect_err(text).to_string();
            assert!(error.contains(message), "{text}: {error}");
        }
    }
}
