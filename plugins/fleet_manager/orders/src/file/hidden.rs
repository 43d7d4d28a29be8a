//! Rows of a workbook's sheet that it hides, by a filter or by hand (ECMA-376, part 1, 18.3.1.73).

use std::io::{BufReader, Cursor, Read};

use quick_xml::XmlVersion;
use quick_xml::events::{BytesStart, Event};
use quick_xml::reader::Reader;
use zip::ZipArchive;

const WORKBOOK: &str = "xl/workbook.xml";
const RELATIONS: &str = "xl/_rels/workbook.xml.rels";
/// The folder of the names in the relations.
const FOLDER: &str = "xl/";
/// The largest size in bytes of the two files above.
const MAX_BYTES: u64 = 4 << 20;

/// Returns the hidden rows of a sheet, from 0 on; none if they can't be found.
pub(super) fn hidden_rows(bytes: &[u8], sheet: &str) -> Vec<usize> {
    rows(bytes, sheet).unwrap_or_default()
}

fn rows(bytes: &[u8], sheet: &str) -> Option<Vec<usize>> {
    let mut archive = ZipArchive::new(Cursor::new(bytes)).ok()?;
    let workbook = archive.by_name(WORKBOOK).ok()?.take(MAX_BYTES);
    let id = find(workbook, "sheet", ("name", sheet), "id")?;
    let relations = archive.by_name(RELATIONS).ok()?.take(MAX_BYTES);
    let target = find(relations, "Relationship", ("Id", &id), "Target")?;
    let path = match target.strip_prefix('/') {
        Some(path) => path.to_owned(),
        None => format!("{FOLDER}{target}"),
    };
    let mut rows = Vec::new();
    let mut next = 0;
    each(archive.by_name(&path).ok()?, |element| {
        if element.local_name().into_inner() != "row" {
            return;
        }
        // A row without a number is that after the one before.
        let number = attribute(element, "r").and_then(|number| number.parse().ok());
        let row = number.map_or(next, |number: usize| number.saturating_sub(1));
        next = row + 1;
        if attribute(element, "hidden").is_some_and(|hidden| hidden == "1" || hidden == "true") {
            rows.push(row);
        }
    });
    Some(rows)
}

/// Returns an attribute of the first element with a name and with the value of another attribute.
fn find(text: impl Read, name: &str, (key, value): (&str, &str), wanted: &str) -> Option<String> {
    let mut found = None;
    each(text, |element| {
        let is_it = element.local_name().into_inner() == name
            && attribute(element, key).is_some_and(|given| given == value);
        if is_it && found.is_none() {
            found = attribute(element, wanted);
        }
    });
    found
}

/// Calls a function with each element of an XML text, up to its end or an error.
fn each(text: impl Read, mut element: impl FnMut(&BytesStart<'_>)) {
    let mut reader = Reader::from_reader(BufReader::new(text));
    let mut part = Vec::new();
    loop {
        match reader.read_event_into(&mut part) {
            Ok(Event::Start(start) | Event::Empty(start)) => element(&start),
            Ok(Event::Eof) | Err(_) => return,
            Ok(_) => {}
        }
        part.clear();
    }
}

/// Returns the value of an attribute, whatever its prefix.
fn attribute(element: &BytesStart<'_>, name: &str) -> Option<String> {
    let mut attributes = element.attributes();
    let mut attributes = attributes.with_checks(false).map_while(Result::ok);
    let found = attributes.find(|attribute| attribute.key.local_name().into_inner() == name)?;
    found.normalized_value(XmlVersion::Implicit1_0).ok().map(String::from)
}
