//! The corpus of the fuzz target of studies, and parts of it, on a stable toolchain.

use std::path::Path;

#[path = "../../fuzz/replay.rs"]
mod replay;
#[path = "../../fuzz/fuzz_targets/studies.rs"]
mod studies;

#[test]
fn nothing_in_the_corpus_makes_a_reader_panic_or_hang() {
    let fuzz = Path::new(env!("CARGO_MANIFEST_DIR")).join("../fuzz");
    replay::replay(&fuzz.join("corpora/study"), |bytes| {
        studies::read(&String::from_utf8_lossy(bytes))
    });
}
