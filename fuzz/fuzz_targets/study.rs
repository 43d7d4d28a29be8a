//! `mkdir -p fuzz/corpus/study; cargo +nightly fuzz run study fuzz/corpus/study
//! fuzz/corpora/study -- -max_total_time=600`

#![no_main]

mod studies;

use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| studies::read(text));
