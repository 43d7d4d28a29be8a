//! `mkdir -p fuzz/corpus/recording; cargo +nightly fuzz run recording fuzz/corpus/recording
//! fuzz/corpora/recording -- -max_total_time=600`

#![no_main]

mod recordings;

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| recordings::read(bytes));
