//! The columns of a table of orders: their meanings are guessed from their headers.

use csv::StringRecord;

/// The meaning of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Meaning {
    /// The name of the order.
    Name,
    /// The date of its creation, where it has a column of its own.
    Date,
    /// The time of its creation.
    Time,
    /// The priority, from 0 to 255.
    Priority,
    /// The time before which no robot gets it.
    Earliest,
    /// The time at which it should be finished.
    Deadline,
    /// All stops, separated by spaces.
    Stops,
    /// The only robot that may get it.
    Robot,
    /// The types of robots that may get it, separated by commas.
    RobotTypes,
    /// The station to pick at.
    From,
    /// The station to drop at.
    To,
}

impl Meaning {
    /// The meanings, and the headers that have them: small letters and digits alone. The first one
    /// is the name that our own files have.
    const HEADERS: [(Self, &str); 11] = [
        (Self::Name, "name id order orderid orderno ordernumber auftrag auftragsnr auftragsnummer"),
        (Self::Date, "date day datum tag"),
        (
            Self::Time,
            "time at start release released releasetime releasedat created createdat timestamp \
             datetime starttime zeit uhrzeit zeitpunkt zeitstempel erstellt erstelltam freigabe \
             startzeit",
        ),
        (Self::Priority, "priority prio priorität prioritaet"),
        (Self::Earliest, "earliest earlieststart notbefore frühestens fruehestens"),
        (
            Self::Deadline,
            "deadline due dueat duedate duetime latest fällig faellig termin spätestens \
             spaetestens",
        ),
        (Self::Stops, "stops destinations halte"),
        (Self::Robot, "robot vehicle fahrzeug"),
        (
            Self::RobotTypes,
            "robottypes robottype vehicletype vehicletypes fahrzeugtyp fahrzeugtypen",
        ),
        (
            Self::From,
            "from pick pickup pickat source origin fromstation von quelle quellplatz abholort",
        ),
        (
            Self::To,
            "to drop dropoff dropat destination dest target tostation nach ziel zielplatz senke",
        ),
    ];

    fn of(header: &str) -> Option<Self> {
        let plain: String =
            header.to_lowercase().chars().filter(|letter| letter.is_alphanumeric()).collect();
        let mut headers = Self::HEADERS.iter();
        let found = headers.find(|(_, names)| names.split(' ').any(|name| name == plain));
        found.map(|(meaning, _)| *meaning)
    }

    /// The header that our own files have.
    pub fn name(self) -> &'static str {
        let mut headers = Self::HEADERS.iter();
        let names = headers.find(|(meaning, _)| *meaning == self).map_or("", |(_, names)| names);
        names.split(' ').next().unwrap_or_default()
    }
}

/// The columns of a table: their headers and meanings.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Columns(Vec<(String, Option<Meaning>)>);

impl Columns {
    /// Returns the columns of a header.
    ///
    /// # Errors
    /// If stops have no column, or two columns have the same meaning.
    pub(super) fn of(header: &StringRecord) -> Result<Self, String> {
        let cells = header.iter().map(|cell| (cell.to_owned(), Meaning::of(cell)));
        let columns = Self(cells.collect());
        for (index, (header, meaning)) in columns.0.iter().enumerate() {
            let mut before = columns.0[..index].iter();
            let same = meaning.and_then(|_| before.find(|(_, other)| other == meaning));
            if let (Some((other, _)), Some(meaning)) = (same, meaning) {
                let name = meaning.name();
                return Err(format!(
                    "the columns `{other}` and `{header}` may both be the {name}; rename one of \
                     them"
                ));
            }
        }
        columns.check_stops()?;
        Ok(columns)
    }

    fn check_stops(&self) -> Result<(), String> {
        let [stops, from, to] =
            [Meaning::Stops, Meaning::From, Meaning::To].map(|meaning| self.have(meaning));
        match (stops, from, to) {
            (true, false, false) | (false, true, true) => Ok(()),
            (true, ..) => Err("give either the column `stops` or `from` and `to`".to_owned()),
            (false, true, false) => Err("the column `to` is missing".to_owned()),
            (false, false, true) => Err("the column `from` is missing".to_owned()),
            (false, false, false) => {
                let headers: Vec<&str> = self.0.iter().map(|(header, _)| header.as_str()).collect();
                Err(format!(
                    "no column has the stops of orders; name two of them `from` and `to`, or one \
                     `stops`; there are: {}",
                    headers.join(", ").escape_debug()
                ))
            }
        }
    }

    pub(super) fn find(&self, meaning: Meaning) -> Option<usize> {
        self.0.iter().position(|(_, of_column)| *of_column == Some(meaning))
    }

    /// The number of columns.
    pub(super) fn len(&self) -> usize {
        self.0.len()
    }

    /// Returns the cell of a row with a meaning, unless it is empty.
    pub(super) fn cell<'row>(
        &self,
        row: &'row StringRecord,
        meaning: Meaning,
    ) -> Option<&'row str> {
        row.get(self.find(meaning)?).filter(|cell| !cell.is_empty())
    }

    /// The headers and what they were guessed to mean.
    pub fn guessed(&self) -> impl Iterator<Item = (&str, Meaning)> {
        self.0.iter().filter_map(|(header, meaning)| Some((header.as_str(), (*meaning)?)))
    }

    /// Whether a column has a meaning.
    pub(super) fn have(&self, meaning: Meaning) -> bool {
        self.find(meaning).is_some()
    }

    /// Whether a column has the times of the orders.
    pub fn have_times(&self) -> bool {
        self.have(Meaning::Time)
    }

    /// The cells of a row in columns that are used, with their headers.
    pub(super) fn used_cells<'a>(
        &'a self,
        record: &'a StringRecord,
    ) -> impl Iterator<Item = (&'a str, &'a str)> {
        let cells = self.0.iter().zip(record).filter(|((_, meaning), _)| meaning.is_some());
        cells.map(|((header, _), cell)| (header.as_str(), cell))
    }

    /// The cells of a row in columns that aren't used.
    pub(super) fn unused_cells<'a>(
        &'a self,
        record: &'a StringRecord,
    ) -> impl Iterator<Item = &'a str> {
        let cells = self.0.iter().zip(record);
        cells.filter(|((_, meaning), _)| meaning.is_none()).map(|(_, cell)| cell)
    }

    /// The headers that aren't used.
    pub fn unused(&self) -> impl Iterator<Item = &str> {
        self.0.iter().filter(|(_, meaning)| meaning.is_none()).map(|(header, _)| header.as_str())
    }
}

/// Returns the names in a cell that has several.
pub(super) fn names(cell: &str) -> Vec<String> {
    cell.split(',').map(|name| name.trim().to_owned()).filter(|name| !name.is_empty()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn columns(header: &[&str]) -> Result<Columns, String> {
        Columns::of(&StringRecord::from(header.to_vec()))
    }

    #[test]
    fn headers_of_warehouses_are_known() {
        let columns = columns(&["Auftrags-Nr.", "Quelle", "Ziel", "Uhrzeit", "Fällig", "Artikel"]);
        let columns = columns.expect("columns");
        let guessed: Vec<Meaning> = columns.guessed().map(|(_, meaning)| meaning).collect();
        let expected =
            [Meaning::Name, Meaning::From, Meaning::To, Meaning::Time, Meaning::Deadline];
        assert_eq!(guessed, expected);
        assert_eq!(columns.unused().collect::<Vec<_>>(), ["Artikel"]);
        for (meaning, names) in Meaning::HEADERS {
            assert!(names.split(' ').all(|name| Meaning::of(name) == Some(meaning)), "{meaning:?}");
        }
    }

    #[test]
    fn a_table_without_stops_or_with_two_of_a_kind_is_refused() {
        for (header, reason) in [
            (&["name", "time"][..], "no column has the stops"),
            (&["from", "time"], "the column `to` is missing"),
            (&["to"], "the column `from` is missing"),
            (&["from", "to", "stops"], "give either"),
            (&["from", "source", "to"], "the columns `from` and `source` may both be the from"),
        ] {
            let error = columns(header).expect_err("refused");
            assert!(error.contains(reason), "{header:?}: {error}");
        }
    }
}
