//! The format of a file by its content.

use crate::model::format::Format;

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
    first.starts_with("type ")
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
    let Some(header) = lines.next() else { return false };
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
