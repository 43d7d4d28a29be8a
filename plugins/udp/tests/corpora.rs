//! The seeds of the fuzz target of datagrams, and parts of them, on a stable toolchain.

use std::fs;
use std::path::Path;

#[path = "../../../fuzz/fuzz_targets/datagrams.rs"]
mod datagrams;

#[test]
fn no_datagram_of_the_seeds_makes_the_plugins_panic() {
    let seeds = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/seeds-udp");
    let mut read = 0;
    for entry in fs::read_dir(seeds).expect("a folder") {
        let bytes = fs::read(entry.expect("an entry").path()).expect("a file");
        for (end, options) in (0..=bytes.len()).zip((0..4).cycle()) {
            datagrams::read(options, &bytes[..end]);
            datagrams::read(options, &bytes[end..]);
            read += 1;
        }
    }
    assert!(read > 100, "{read} inputs");
}
