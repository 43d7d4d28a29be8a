//! The corpus of the fuzz target of recordings, and parts of it, on a stable toolchain.

use std::path::Path;

#[path = "../../../fuzz/fuzz_targets/recordings.rs"]
mod recordings;
#[path = "../../../fuzz/replay.rs"]
mod replay;

#[test]
fn nothing_in_the_corpus_makes_a_reader_panic_or_hang() {
    let fuzz = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz");
    replay::replay(&fuzz.join("corpora/recording"), recordings::read);
}
