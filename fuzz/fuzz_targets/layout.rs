//! The fuzz targets of layouts: no text makes a reader panic, hang or exhaust memory, and
//! every accepted graph can be compiled and written.

use regatta_engine::arc_length;
use regatta_layout::{Format, Millimetres, ReadOptions, parse, write};

/// Reads a text as a layout of a format.
pub fn read(text: &str, format: Format) {
    let options = ReadOptions {
        format: Some(format),
        skeleton: Some(Millimetres(300)),
        ..ReadOptions::default()
    };
    let Ok((graph, _)) = parse(text, "fuzzed", &options) else { return };
    // Commands refuse what doesn't fit the machine before they compile it.
    if arc_length::least_pieces(&graph) > 300_000 {
        return;
    }
    let tracks = arc_length::compile(&graph);
    assert!(
        tracks.pieces().iter().all(|piece| piece
            .x
            .iter()
            .chain(&piece.y)
            .all(|value| value.is_finite()))
    );
    for format in [Format::Regatta, Format::Lif, Format::Nav2, Format::OpenTcs] {
        let _written = write(&graph, format);
    }
}
