//! Plain data that crosses processes: the samples of a fleet's services, byte for byte.
//!
//! A record has a fixed layout (`#[repr(C)]`, no padding, every bit pattern is a value), no
//! pointers and no ids that mean something on one host only. A change here is a change of the
//! contract: raise [`frame::CONTRACT_VERSION`] and write `plugins/python/regatta/layout.json` again
//! (see `tests/layout.rs`).

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

pub mod activity;
pub mod closure;
pub mod column;
pub mod contact;
pub mod control;
pub mod event;
pub mod frame;
pub mod history;
pub mod lockstep;
pub mod manager;
pub mod name;
pub mod order;
pub mod order_log;
pub mod recording;
pub mod route;
pub mod sequence;
pub mod task;
mod text;
pub mod traffic;
pub mod world;

pub(crate) use text::{cut, padded, text};
