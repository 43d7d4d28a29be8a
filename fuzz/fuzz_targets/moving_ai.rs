//! `cargo +nightly fuzz run moving_ai graphs/imported/movingai -- -max_total_time=600`

#![no_main]

mod layout;

use libfuzzer_sys::fuzz_target;
use regatta_layout::Format;

fuzz_target!(|text: &str| layout::read(text, Format::MovingAi));
