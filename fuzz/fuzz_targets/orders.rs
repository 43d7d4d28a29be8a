//! `mkdir -p fuzz/corpus/orders; cargo +nightly fuzz run orders fuzz/corpus/orders
//! fuzz/corpora/orders -- -max_total_time=600`

#![no_main]

mod order_texts;

use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| order_texts::read(text));
