//! Lists of contacts are decoded bit for bit as they were encoded.

use std::path::Path;

use bytemuck::Zeroable;
use proptest::prelude::*;
use regatta_plugin::contact::{ContactHeader, ContactRecord};

use super::{ContactDecoder, ContactEncoder, ContactList, key};
use crate::reading::{ReadingError, Recording};
use crate::schema::Topic;

/// The bits of any number, often those of a negative zero, which protocol buffers may leave out.
fn bits() -> impl Strategy<Value = u32> {
    prop_oneof![any::<u32>(), Just((-0.0_f32).to_bits())]
}

/// A pair whose numbers are any bits. Few ids, so that pairs stay in the list from time to time.
fn pair() -> impl Strategy<Value = ContactRecord> {
    let numbers = (0_u32..6, 6_u32..9, 1_u32..3, 0_u32..3, [bits(), bits(), bits()], 0_u64..3);
    numbers.prop_map(|(robot, other, level, edge, bits, since)| {
        let [x, y, relative_speed] = bits.map(f32::from_bits);
        let (since_tick, since_nanos) = (since, since * 10);
        ContactRecord {
            since_tick,
            since_nanos,
            robots: [robot, other],
            level,
            edge,
            x,
            y,
            relative_speed,
            reserved: 0,
        }
    })
}

fn list(tick: u64, mut pairs: Vec<ContactRecord>) -> ContactList {
    pairs.sort_by_key(key);
    pairs.dedup_by_key(|pair| key(pair));
    let touching = pairs.iter().filter(|pair| pair.level == 2).count() as u32;
    let header = ContactHeader {
        run_id: 3,
        tick,
        sim_time_nanos: tick * 10,
        touching,
        ..ContactHeader::zeroed()
    };
    ContactList { header, pairs }
}

/// Two lists are equal bit for bit. (Numbers that are NaN are never equal.)
fn same(decoder: &ContactDecoder, list: &ContactList) -> bool {
    let (header, pairs) = decoder.list().expect("a list");
    *header == list.header
        && bytemuck::cast_slice::<_, u8>(pairs) == bytemuck::cast_slice::<_, u8>(&list.pairs)
}

proptest! {
    #[test]
    fn any_lists_are_decoded_bit_for_bit(lists in prop::collection::vec(prop::collection::vec(pair(), 0..12), 1..8)) {
        let (mut encoder, mut decoder) = (ContactEncoder::default(), ContactDecoder::default());
        for (tick, pairs) in lists.into_iter().enumerate() {
            let list = list(tick as u64, pairs);
            let (topic, message) = encoder.encode(tick as u64, list.clone());
            prop_assert!(decoder.decode(&topic, &message).unwrap());
            prop_assert!(same(&decoder, &list), "tick {tick} on {topic:?}");
        }
    }

    #[test]
    fn a_damaged_update_is_rejected_or_decoded(cut in any::<prop::sample::Index>(), bit in 0..8) {
        let (mut encoder, mut decoder) = (ContactEncoder::default(), ContactDecoder::default());
        let (_, whole) = encoder.encode(0, moving(0));
        let (topic, mut update) = encoder.encode(1, moving(1));
        prop_assert_eq!(&topic, &Topic::ContactUpdates);
        decoder.decode(&Topic::Contacts, &whole).unwrap();
        let at = cut.index(update.len());
        update[at] ^= 1_u8 << bit;
        let _ = decoder.decode(&topic, &update);
        let _ = decoder.decode(&topic, &update[..at]);
    }
}

/// A list of pairs that move evenly, at a speed of some centimetres per tick.
fn moving(tick: u64) -> ContactList {
    let pair = |robot: u32| ContactRecord {
        robots: [robot, robot + 1],
        level: 1,
        x: 50.0 + robot as f32 + tick as f32 * 0.015,
        y: 20.0 - tick as f32 * 0.007,
        relative_speed: 1.5,
        ..ContactRecord::zeroed()
    };
    list(tick, (0..1000).map(pair).collect())
}

#[test]
fn an_update_of_pairs_that_move_evenly_is_a_tenth_of_the_list() {
    let mut encoder = ContactEncoder::default();
    let messages: Vec<_> = (0..10).map(|tick| encoder.encode(tick, moving(tick))).collect();
    let bytes: Vec<_> = messages.iter().map(|(_, message)| message.len()).collect();
    assert!(bytes[9] < bytes[0] / 8, "{bytes:?}");
}

#[test]
fn readers_can_start_at_whole_lists_and_continue_there_after_a_loss() {
    let (mut encoder, mut decoder) = (ContactEncoder::default(), ContactDecoder::default());
    let messages: Vec<_> = (0..205).map(|tick| encoder.encode(tick, moving(tick))).collect();
    let whole: Vec<_> = (0..205).filter(|tick| messages[*tick].0 == Topic::Contacts).collect();
    assert_eq!(whole, [0, 101, 202]);
    let decoded = |decoder: &mut ContactDecoder, tick: usize| {
        let (topic, message) = &messages[tick];
        decoder.decode(topic, message).unwrap() && same(decoder, &moving(tick as u64))
    };
    for tick in (0..205).filter(|tick| *tick != 40) {
        assert_eq!(decoded(&mut decoder, tick), !(40..101).contains(&tick), "tick {tick}");
    }
    assert!(decoded(&mut decoder, 101) && !decoded(&mut decoder, 103) && decoder.list().is_none());
}

#[test]
fn the_time_between_whole_lists_is_limited_and_a_list_that_is_not_sorted_is_whole() {
    let mut encoder = ContactEncoder::default();
    let times = [0, 9_000_000_000, 10_000_000_000, 11_000_000_000, 10_500_000_000];
    let topics = times.map(|time| encoder.encode(time, moving(time)).0 == Topic::Contacts);
    assert_eq!(topics, [true, false, true, false, true], "the last one goes back in time");
    let mut unsorted = moving(1);
    unsorted.pairs.reverse();
    let mut decoder = ContactDecoder::default();
    for list in [unsorted, moving(2)] {
        let (topic, message) = encoder.encode(12_000_000_000, list.clone());
        assert_eq!(topic, Topic::Contacts);
        assert!(decoder.decode(&topic, &message).unwrap() && same(&decoder, &list));
    }
    encoder.restart();
    assert_eq!(encoder.encode(12_000_000_000, moving(3)).0, Topic::Contacts);
}

/// Regatta recorded whole lists only, until it recorded changes. This recording has the ticks 0 to
/// 20 of 250 robots.
#[test]
fn recordings_of_whole_lists_are_still_read() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/whole-contacts.mcap");
    let recording = Recording::open(&path).unwrap();
    let mut lists = Vec::new();
    let read = recording.contacts(|_, header, pairs| -> Result<(), ReadingError> {
        assert_eq!((header.touching + header.possible) as usize, pairs.len());
        lists.push((header.tick, pairs.len()));
        Ok(())
    });
    read.unwrap();
    assert!(
        lists.iter().map(|(tick, _)| *tick).eq(0..=20) && lists.iter().any(|(_, pairs)| *pairs > 0),
        "{lists:?}"
    );
}
