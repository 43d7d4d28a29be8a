//! Scans the pairs of group code and value of a DXF file, and copies those that the reader uses.
//!
//! The crate `dxf` silently drops the rest of a section after a value that it can't read. It also
//! recurses into nested application data, and decodes preview pictures. So it gets only entities
//! and groups that are used, with checked values.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;

use crate::model::finding::Report;
use crate::read::file::{Ignored, SyntaxError};

/// The largest number of entities, vertices of old polylines included: each takes about a kilobyte.
const MAX_ENTITIES: usize = 500_000;

/// The largest number of bytes of the name of a layer or a block, as in AutoCAD. Each line has a
/// copy of the name.
const MAX_NAME: usize = 255;

/// The groups with the layer of an entity: in a file, and in the text for the crate `dxf`. It looks
/// each layer up among all layers before, which takes a time that grows with the square of their
/// number. The name of a colour is only kept.
const LAYER: i32 = 8;
const COLOUR_NAME: i32 = 430;

/// The content of a file that the reader uses.
#[derive(Debug, Default)]
pub struct Scan {
    /// A DXF file of the blocks and entities that are used. Their layers are names of colours.
    pub text: String,
    /// The byte offset of each entity outside blocks.
    pub offsets: Vec<u32>,
    /// The number of each entity in each block.
    pub block_sizes: Vec<usize>,
    /// The header's `$INSUNITS`.
    pub units: Option<i16>,
    /// The layers that are switched off or frozen, in upper case.
    pub hidden_layers: BTreeSet<String>,
    /// The layers of the table, in upper case, with their names as written.
    pub layers: BTreeMap<String, String>,
}

/// A group code with its value.
#[derive(Clone, Copy, Debug)]
struct Pair<'text> {
    code: i32,
    value: &'text str,
    /// The byte offset of the value.
    at: u32,
}

/// Reads a file.
///
/// # Errors
/// If it doesn't consist of pairs, or has too many entities.
pub fn scan(
    text: &str,
    ignored: &mut Ignored,
    report: &mut Report<'_>,
) -> Result<Scan, SyntaxError> {
    let mut scanner = Scanner::new(ignored, report);
    let mut lines = text.split('\n');
    let (mut at, mut line) = (0, 1);
    while let Some(code) = lines.next() {
        let value_at = at + code.len() + 1;
        let Some(value) = lines.next() else { break };
        let Ok(number) = code.trim().parse() else {
            let message = format!(
                "`{}` isn't a group code: DXF alternates codes and values",
                super::shorten(code)
            );
            return Err(SyntaxError::new(line, message));
        };
        let pair = Pair { code: number, value: value.trim(), at: value_at as u32 };
        if pair.code == 0 && pair.value == "EOF" {
            break;
        }
        scanner.pair(pair);
        if scanner.entities > MAX_ENTITIES {
            return Err(SyntaxError::new(
                line,
                format!("more than {MAX_ENTITIES} entities: split the drawing"),
            ));
        }
        at = value_at + value.len() + 1;
        line += 2;
    }
    Ok(scanner.finish())
}

/// The part of a file that the scanner is in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Section {
    Header,
    Tables,
    Blocks,
    Entities,
    Other,
}

/// The kinds of values of groups that are used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Value {
    Text,
    Whole,
    Real,
}

struct Scanner<'a, 'text> {
    found: Scan,
    ignored: &'a mut Ignored,
    report: &'a mut Report<'text>,
    section: Section,
    /// Whether the last pair was `SECTION`, whose name follows.
    starts_section: bool,
    /// The last value of group 0 if it is used; empty otherwise.
    kind: &'static str,
    /// Whether the last variable of the header is `$INSUNITS`.
    is_units: bool,
    /// The entry of the table of layers that is being read: its name and whether it is hidden.
    layer: Option<(String, bool)>,
    blocks: String,
    outside_blocks: String,
    in_block: bool,
    /// Whether vertices belong to a polyline.
    in_polyline: bool,
    entities: usize,
}

impl<'a, 'text> Scanner<'a, 'text> {
    fn new(ignored: &'a mut Ignored, report: &'a mut Report<'text>) -> Self {
        Self {
            found: Scan::default(),
            ignored,
            report,
            section: Section::Other,
            starts_section: false,
            kind: "",
            is_units: false,
            layer: None,
            blocks: String::new(),
            outside_blocks: String::new(),
            in_block: false,
            in_polyline: false,
            entities: 0,
        }
    }

    fn pair(&mut self, pair: Pair<'_>) {
        if std::mem::take(&mut self.starts_section) && pair.code == 2 {
            self.section = section(pair.value);
            return;
        }
        match (pair.code, self.section) {
            (999, _) => {}
            (0, _) => self.start(pair),
            (9, Section::Header) => self.is_units = pair.value == "$INSUNITS",
            (70, Section::Header) if self.is_units => self.found.units = pair.value.parse().ok(),
            (_, Section::Tables) => self.layer_value(pair),
            (_, Section::Blocks | Section::Entities) if !self.kind.is_empty() => self.value(pair),
            _ => {}
        }
    }

    /// Starts the section, block or entity of a pair of group 0.
    fn start(&mut self, pair: Pair<'_>) {
        self.end_layer();
        self.kind = "";
        match (pair.value, self.section) {
            ("SECTION", _) => self.starts_section = true,
            ("ENDSEC", _) => self.section = Section::Other,
            ("LAYER", Section::Tables) => self.layer = Some((String::new(), false)),
            ("BLOCK", Section::Blocks) => self.start_block(),
            ("ENDBLK", Section::Blocks) => self.end_block(),
            (_, Section::Entities) => self.start_entity(pair),
            (_, Section::Blocks) if self.in_block => self.start_entity(pair),
            _ => {}
        }
    }

    fn start_block(&mut self) {
        self.end_block();
        self.in_block = true;
        self.kind = "BLOCK";
        self.blocks.push_str("0\nBLOCK\n");
        self.found.block_sizes.push(0);
        self.entities += 1;
    }

    fn end_block(&mut self) {
        if std::mem::take(&mut self.in_block) {
            self.blocks.push_str("0\nENDBLK\n");
        }
        self.in_polyline = false;
    }

    fn start_entity(&mut self, pair: Pair<'_>) {
        let known = USED.iter().find(|&&kind| kind == pair.value);
        let orphan = pair.value == "VERTEX" && !self.in_polyline;
        let Some(kind) = known.filter(|_| !orphan) else {
            self.in_polyline &= pair.value == "VERTEX";
            // These only close or label other entities.
            if !["SEQEND", "ATTRIB", "VIEWPORT"].contains(&pair.value) {
                self.ignored.add(pair.at, format!("entity {}", super::shorten(pair.value)));
            }
            return;
        };
        self.kind = kind;
        self.in_polyline = ["POLYLINE", "VERTEX"].contains(kind);
        self.entities += 1;
        if *kind != "VERTEX" {
            self.count(pair.at);
        }
        let _infallible = writeln!(self.output(), "0\n{kind}");
    }

    fn count(&mut self, at: u32) {
        match (self.section, self.found.block_sizes.last_mut()) {
            (Section::Blocks, Some(size)) => *size += 1,
            _ => self.found.offsets.push(at),
        }
    }

    fn output(&mut self) -> &mut String {
        if self.section == Section::Blocks { &mut self.blocks } else { &mut self.outside_blocks }
    }

    /// Copies a value of an entity or a block if it is used.
    fn value(&mut self, pair: Pair<'_>) {
        let Pair { code, value, .. } = pair;
        let Some(expected) = used(self.kind, code) else { return };
        let copy = match expected {
            Value::Text if value.len() > MAX_NAME => {
                return self.wrong(pair, "a name of at most 255 bytes");
            }
            Value::Text => escaped(value),
            Value::Whole => {
                match value.parse::<f64>().ok().filter(|number| number.abs() <= f64::from(i16::MAX))
                {
                    Some(number) => (number as i16).to_string(),
                    None => return self.wrong(pair, "a whole number"),
                }
            }
            Value::Real => match value.parse::<f64>().ok().filter(|number| number.is_finite()) {
                Some(_) => value.to_owned(),
                None => return self.wrong(pair, "a number"),
            },
        };
        let copied_code = if code == LAYER { COLOUR_NAME } else { code };
        let _infallible = writeln!(self.output(), "{copied_code}\n{copy}");
        // The crate `dxf` drops points of splines without a height.
        if self.kind == "SPLINE" && (code == 20 || code == 21) {
            let _infallible = writeln!(self.output(), "{}\n0", code + 10);
        }
    }

    fn wrong(&mut self, pair: Pair<'_>, expected: &str) {
        let (value, kind) = (super::shorten(pair.value), self.kind);
        let message =
            format!("`{value}` isn't {expected}: group {} of an entity {kind}", pair.code);
        self.report.file_error(pair.at, message);
    }

    fn layer_value(&mut self, pair: Pair<'_>) {
        let Some((name, hidden)) = &mut self.layer else { return };
        let number = pair.value.parse::<i32>().unwrap_or_default();
        match pair.code {
            2 => *name = unescaped(pair.value),
            // A negative colour: switched off. The lowest bit of the flags: frozen.
            62 => *hidden |= number < 0,
            70 => *hidden |= number & 1 != 0,
            _ => {}
        }
    }

    fn end_layer(&mut self) {
        let Some((name, hidden)) = self.layer.take() else { return };
        let key = name.to_uppercase();
        if hidden {
            self.found.hidden_layers.insert(key.clone());
        }
        self.found.layers.insert(key, name);
    }

    fn finish(mut self) -> Scan {
        self.end_layer();
        self.end_block();
        let (blocks, entities) = (self.blocks, self.outside_blocks);
        self.found.text = format!(
            "0\nSECTION\n2\nBLOCKS\n{blocks}0\nENDSEC\n\
             0\nSECTION\n2\nENTITIES\n{entities}0\nENDSEC\n\
             0\nEOF\n"
        );
        self.found
    }
}

fn section(name: &str) -> Section {
    match name {
        "HEADER" => Section::Header,
        "TABLES" => Section::Tables,
        "BLOCKS" => Section::Blocks,
        "ENTITIES" => Section::Entities,
        _ => Section::Other,
    }
}

/// The entities that are used.
const USED: [&str; 9] =
    ["LINE", "ARC", "CIRCLE", "ELLIPSE", "LWPOLYLINE", "POLYLINE", "VERTEX", "SPLINE", "INSERT"];

/// Returns the kind of value of a group that is used of an entity or a block.
fn used(kind: &str, code: i32) -> Option<Value> {
    match code {
        2 => (kind == "BLOCK" || kind == "INSERT").then_some(Value::Text),
        LAYER => Some(Value::Text),
        30 | 31 if kind == "SPLINE" => None,
        10 | 11 | 20 | 21 | 30 | 31 | 40..=45 | 50 | 51 | 210 | 220 | 230 => Some(Value::Real),
        60 | 67 if kind != "BLOCK" => Some(Value::Whole),
        70 if kind != "BLOCK" => Some(Value::Whole),
        71 if ["SPLINE", "INSERT"].contains(&kind) => Some(Value::Whole),
        _ => None,
    }
    .filter(|_| kind != "BLOCK" || [2, 10, 20].contains(&code))
}

/// Returns a text with escapes for letters beyond ASCII, because the crate `dxf` assumes the
/// encoding of old files.
fn escaped(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for letter in text.chars() {
        if letter.is_ascii() {
            escaped.push(letter);
        } else {
            let _infallible = write!(escaped, "\\U+{:04X}", (letter as u32).min(0xffff));
        }
    }
    escaped
}

/// Returns a text whose escapes for letters beyond ASCII, such as `\U+00FC`, are resolved.
fn unescaped(text: &str) -> String {
    let mut parts = text.split("\\U+");
    let mut unescaped = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let code = part.get(..4).and_then(|digits| u32::from_str_radix(digits, 16).ok());
        match code.and_then(char::from_u32) {
            Some(letter) => {
                unescaped.push(letter);
                unescaped.push_str(&part[4..]);
            }
            None => {
                unescaped.push_str("\\U+");
                unescaped.push_str(part);
            }
        }
    }
    unescaped
}
