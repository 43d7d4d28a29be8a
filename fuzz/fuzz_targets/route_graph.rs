//! No text makes the graph reader panic, hang or exhaust memory; every accepted graph has legs and
//! can be compiled.
//!
//! `cargo +nightly fuzz run route_graph fuzz/seeds -- -max_total_time=600`

#![no_main]

use libfuzzer_sys::fuzz_target;
use regatta_engine::arc_length;
use regatta_layout::{NodeIndex, ReadOptions, parse};

fuzz_target!(|text: &str| {
    let Ok((graph, _)) = parse(text, "fuzzed.yaml", &ReadOptions::default()) else { return };
    let legs: usize =
        (0..graph.nodes().len() as u32).map(|node| graph.departures(NodeIndex(node)).len()).sum();
    assert!(legs >= graph.edges().len());
    let tracks = arc_length::compile(&graph);
    assert!(
        tracks.pieces().iter().all(|piece| piece
            .x
            .iter()
            .chain(&piece.y)
            .all(|value| value.is_finite()))
    );
});
