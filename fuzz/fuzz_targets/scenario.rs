//! `mkdir -p fuzz/corpus/scenario; cargo +nightly fuzz run scenario fuzz/corpus/scenario
//! fuzz/corpora/scenario -- -max_total_time=600`

#![no_main]

mod scenarios;

use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| scenarios::read(text));
