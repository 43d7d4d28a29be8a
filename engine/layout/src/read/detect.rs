//! The format of a file by its content.

use super::csv::named_separator;
use crate::model::format::Format;
use crate::read::file::SyntaxError;

/// The number of bytes at the start of a text that are searched for a format's words.
const HEAD: usize = 64 << 10;

impl Format {
    /// Returns the format of a text by its content; [`Format::Regatta`] if no other format matches.
    pub fn detect(text: &str) -> Self {
        let head = &text[..text.floor_char_boundary(HEAD)];
        let start = head.trim_start();
        if start.starts_with('<') {
            return Format::OpenTcs;
        }
        if start.starts_with('{') {
            return json(text);
        }
        if is_moving_ai(start) {
            return Format::MovingAi;
        }
        if is_dxf(start) {
            return Format::Dxf;
        }
        if let Some(format) = yaml(head) {
            return format;
        }
        if is_csv(start) { Format::Csv } else { Format::Regatta }
    }
}

/// Returns an error for a file of another kind that is easily taken for a layout, and isn't read.
pub(crate) fn reject_unread(text: &str) -> Result<(), SyntaxError> {
    match unread(text) {
        Some((kind, remedy)) => {
            Err(SyntaxError::new(1, format!("this is {kind}, which isn't read: {remedy}")))
        }
        None => Ok(()),
    }
}

/// Whether a text is of a kind that isn't read, though it describes places or roads.
pub fn is_unread(text: &str) -> bool {
    unread(text).is_some()
}

/// Returns the kind of a text that isn't read, and what to give instead.
fn unread(text: &str) -> Option<(&'static str, &'static str)> {
    let start = text.trim_start();
    let head = &start[..start.floor_char_boundary(HEAD)];
    if start.starts_with('<') {
        let root = root_element(head)?;
        return UNREAD_XML
            .iter()
            .find(|(name, ..)| *name == root)
            .map(|(_, kind, remedy)| (*kind, *remedy));
    }
    let unread = UNREAD_JSON
        .iter()
        .filter(|_| start.starts_with('{'))
        .find(|(keys, ..)| keys.iter().all(|key| text.contains(&format!("\"{key}\""))));
    unread.map(|(_, kind, remedy)| (*kind, *remedy))
}

/// Kinds of XML by their outermost element.
const UNREAD_XML: [(&str, &str, &str); 5] = [
    ("net", "a road network of SUMO", TABLES),
    ("osm", "a map of OpenStreetMap", TABLES),
    ("graphml", "a graph in GraphML", TABLES),
    ("svg", "a picture in SVG", "save the drawing as DXF in ASCII"),
    ("kml", "a map in KML", TABLES),
];

/// Kinds of JSON by some of their keys.
const UNREAD_JSON: [(&[&str], &str, &str); 2] = [
    (
        &["format_version", "anchors", "navigation"],
        "a site of Open-RMF's site editor",
        "export the navigation graph (`*.nav.yaml`) there",
    ),
    (
        &["mapFile", "agentFile", "teamSize"],
        "a problem of the League of Robot Runners",
        "give the map that its `mapFile` names",
    ),
];

const TABLES: &str = "convert it to tables of nodes and edges (CSV), in metres";

/// Returns the name of the outermost element of an XML text, without a prefix.
fn root_element(text: &str) -> Option<&str> {
    let mut rest = text;
    loop {
        let (_, tag) = rest.split_once('<')?;
        let end = match tag.as_bytes().first()? {
            b'?' => "?>",
            b'!' if tag.starts_with("!--") => "-->",
            b'!' => ">",
            _ => {
                let name = tag.split([' ', '\t', '\r', '\n', '>', '/']).next()?;
                return Some(name.rsplit_once(':').map_or(name, |(_, name)| name));
            }
        };
        rest = tag.split_once(end)?.1;
    }
}

/// Our own format may be written as JSON too.
fn json(text: &str) -> Format {
    // The order of the keys of a JSON object is arbitrary, so the words may come late.
    if text.contains("\"FeatureCollection\"") {
        Format::Nav2
    } else if text.contains("\"layouts\"") || text.contains("\"metaInformation\"") {
        Format::Lif
    } else {
        Format::Regatta
    }
}

fn is_moving_ai(start: &str) -> bool {
    let first = start.lines().next().unwrap_or_default().trim();
    ["type ", "height ", "width "].iter().any(|key| first.starts_with(key))
        || first.strip_prefix("version ").is_some_and(|number| number.trim().parse::<f64>().is_ok())
}

/// A DXF file consists of pairs of lines: a group code and a value. It starts with a section or a
/// comment.
fn is_dxf(start: &str) -> bool {
    // Binary drawings count too: the reader reports how to convert them.
    if start.starts_with("AutoCAD Binary DXF") {
        return true;
    }
    let mut lines = start.lines().map(str::trim);
    matches!((lines.next(), lines.next()), (Some("0"), Some("SECTION")) | (Some("999"), Some(_)))
}

/// Returns the format of YAML by its keys at the outermost level.
fn yaml(head: &str) -> Option<Format> {
    if ["image", "resolution", "origin"]
        .iter()
        .all(|key| head.lines().any(|line| is_key(line, key)))
    {
        return Some(Format::RosMap);
    }
    if !head.lines().any(|line| is_key(line, "levels")) {
        return None;
    }
    let is_building = head.lines().any(|line| {
        ["coordinate_system", "reference_level_name"].iter().any(|key| is_key(line, key))
            || ["measurements", "walls"].iter().any(|key| is_key(line.trim_start(), key))
    });
    Some(if is_building { Format::OpenRmfBuilding } else { Format::OpenRmf })
}

fn is_key(line: &str, key: &str) -> bool {
    line.strip_prefix(key).is_some_and(|rest| rest.starts_with(':'))
}

/// Tables start with a line of column names.
fn is_csv(start: &str) -> bool {
    let mut lines =
        start.lines().map(str::trim).filter(|line| !line.is_empty() && !line.starts_with('#'));
    let Some(mut header) = lines.next() else { return false };
    if named_separator(header).is_some() {
        header = lines.next().unwrap_or_default();
    }
    let separator =
        [',', ';', '\t'].into_iter().max_by_key(|separator| header.matches(*separator).count());
    let Some(separator) = separator.filter(|separator| header.contains(*separator)) else {
        return false;
    };
    header.split(separator).all(is_name)
}

fn is_name(cell: &str) -> bool {
    let cell = cell.trim().trim_matches('"');
    !cell.is_empty()
        && cell.chars().all(|letter| letter.is_alphanumeric() || " _-()[]/.".contains(letter))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kinds_that_are_not_read_are_named() {
        for (text, kind) in [
            ("<?xml version=\"1.0\"?>\n<!-- <model> -->\n<net version=\"1.20\"/>", "SUMO"),
            ("<svg:svg xmlns:svg=\"http://www.w3.org/2000/svg\"></svg:svg>", "SVG"),
            (
                "{\"format_version\": \"0.1\", \"anchors\": {}, \"navigation\": {}}",
                "site of Open-RMF",
            ),
            ("{\"mapFile\": \"a\", \"agentFile\": \"b\", \"teamSize\": 3}", "Robot Runners"),
        ] {
            let error = reject_unread(text).expect_err(text);
            assert!(error.message.contains(kind), "{text}: {}", error.message);
        }
        for text in ["<model/>", "<", "<?xml", "{}", "", "id,x,y\n"] {
            assert!(!is_unread(text), "{text}");
        }
    }

    #[test]
    fn formats_are_told_by_their_content() {
        let cases = [
            ("\u{feff}Vertices:\n- {Id: 1}\n", Format::Regatta),
            ("{\"Edges\": [], \"Vertices\": []}", Format::Regatta),
            ("# a comment\nEdges:\n", Format::Regatta),
            ("{\"metaInformation\": {}, \"layouts\": []}", Format::Lif),
            ("{\n \"type\": \"FeatureCollection\", \"features\": []}", Format::Nav2),
            ("<?xml version=\"1.0\"?>\n<model/>", Format::OpenTcs),
            ("building_name: hotel\nlevels:\n  L1:\n    vertices: []\n", Format::OpenRmf),
            (
                "coordinate_system: reference_image\nlevels:\n  L1:\n    measurements: []\n",
                Format::OpenRmfBuilding,
            ),
            ("type octile\nheight 2\n", Format::MovingAi),
            ("version 1\n0\tmap\t", Format::MovingAi),
            ("height 1\nwidth 3\nmap\n...\n", Format::MovingAi),
            ("sep=;\r\nid;x;y\r\n", Format::Csv),
            ("  0\r\nSECTION\r\n  2\r\n", Format::Dxf),
            ("id,x,y\n1,0,0\n", Format::Csv),
            ("\"Edge ID\";\"From\";\"To\"\n1;2;3\n", Format::Csv),
            ("image: map.pgm\nresolution: 0.05\norigin: [0, 0, 0]\n", Format::RosMap),
        ];
        for (text, format) in cases {
            assert_eq!(
                Format::detect(text.strip_prefix('\u{feff}').unwrap_or(text)),
                format,
                "{text}"
            );
        }
    }
}
