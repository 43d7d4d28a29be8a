//! Plain data that crosses processes: the samples of a fleet's services, byte for byte.
//!
//! A record has a fixed layout (`#[repr(C)]`, no padding, every bit pattern is a value), no
//! pointers and no ids that mean something on one host only. A change here is a change of the
//! contract: raise [`frame::CONTRACT_VERSION`] and write `plugins/python/regatta/layout.json` again
//! (see `tests/contract/layout.rs`).

/// Defines an enum of the numbers that a field of a record may have.
macro_rules! numbered {
    (
        $(#[$meta:meta])*
        pub enum $name:ident: $number:ty {
            $($(#[$variant_meta:meta])* $variant:ident = $value:literal,)*
        }
    ) => {
        $(#[$meta])*
        #[repr($number)]
        pub enum $name {
            $($(#[$variant_meta])* $variant = $value,)*
        }

        impl $name {
            /// All values, by number.
            pub const ALL: [Self; [$($value),*].len()] = [$(Self::$variant),*];

            /// Returns the value with a number; `None` if this contract doesn't know it.
            pub fn from_number(number: $number) -> Option<Self> {
                Self::ALL.into_iter().find(|value| *value as $number == number)
            }
        }
    };
}

/// Plain data that ports carry.
pub trait Record: bytemuck::AnyBitPattern + core::fmt::Debug + Shareable {}

impl<T: bytemuck::AnyBitPattern + core::fmt::Debug + Shareable> Record for T {}

/// The header of a sample: the record that comes before its slice.
pub trait Header: Record + Default {}

impl<T: Record + Default> Header for T {}

#[cfg(not(feature = "shared-memory"))]
use core::any::Any as Shareable;
#[cfg(feature = "shared-memory")]
use iceoryx2::prelude::ZeroCopySend as Shareable;

pub mod activity;
pub mod closure;
pub mod column;
pub mod command;
pub mod command_log;
pub mod contact;
pub mod control;
pub mod event;
pub mod facility;
pub mod frame;
pub mod history;
pub mod lockstep;
pub mod manager;
pub mod name;
pub mod order;
pub mod recording;
pub mod route;
pub mod sequence;
pub mod traffic;
pub mod work;
pub mod world;

/// Returns the text in a field of UTF-8 that is padded with zeros, up to the first byte that is not
/// UTF-8.
pub(crate) fn text(bytes: &[u8]) -> &str {
    let bytes = bytes.split(|byte| *byte == 0).next().unwrap_or_default();
    match core::str::from_utf8(bytes) {
        Ok(text) => text,
        Err(error) => core::str::from_utf8(&bytes[..error.valid_up_to()]).unwrap_or_default(),
    }
}

/// Returns `text` as a padded field, cut after the last whole character that fits.
pub(crate) fn padded<const N: usize>(text: &str) -> [u8; N] {
    let cut = cut(text, N);
    let mut bytes = [0; N];
    bytes[..cut.len()].copy_from_slice(cut.as_bytes());
    bytes
}

/// Returns the longest prefix of `text` of at most `bytes` bytes.
pub(crate) fn cut(text: &str, bytes: usize) -> &str {
    &text[..text.floor_char_boundary(bytes)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_fields_are_cut_at_whole_characters() {
        assert_eq!(text(&padded::<4>("abcdef")), "abcd");
        assert_eq!(text(&padded::<4>("abcé")), "abc");
        assert_eq!(text(&padded::<4>("")), "");
        assert_eq!(text(&[b'a', 0xff, b'b']), "a");
    }
}
