//! No datagram makes the UDP plugins panic, hang or exhaust memory: neither the source, which turns
//! datagrams into a fleet, nor the check of a visualiser's answers. A line that is parsed, written
//! and parsed again has the same values.
//!
//! `mkdir -p fuzz/corpus/udp_datagram; cargo +nightly fuzz run udp_datagram
//! fuzz/corpus/udp_datagram fuzz/seeds-udp -- -max_total_time=600`

#![no_main]

mod datagrams;

use libfuzzer_sys::fuzz_target;

// The input is one byte of options, and datagrams separated by zero bytes.
fuzz_target!(|input: (u8, &[u8])| datagrams::read(input.0, input.1));
