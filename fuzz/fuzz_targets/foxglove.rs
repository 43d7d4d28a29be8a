//! No message of a client makes the plugin foxglove panic, hang or exhaust memory.
//!
//! `mkdir -p fuzz/corpus/foxglove; cargo +nightly fuzz run foxglove fuzz/corpus/foxglove
//! fuzz/corpora/foxglove -- -max_total_time=600`

#![no_main]

mod foxglove_messages;

use libfuzzer_sys::fuzz_target;

fuzz_target!(|message: &[u8]| foxglove_messages::read(message));
