//! The corpus of the fuzz target of clients' messages, and parts of it, on a stable toolchain.

use std::path::Path;

#[path = "../../../fuzz/fuzz_targets/foxglove_messages.rs"]
mod foxglove_messages;
#[path = "../../../fuzz/replay.rs"]
mod replay;

#[test]
fn nothing_in_the_corpus_makes_the_reader_panic_or_hang() {
    let fuzz = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz");
    replay::replay(&fuzz.join("corpora/foxglove"), foxglove_messages::read);
}
