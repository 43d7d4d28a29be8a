//! A macro that declares the operations of an instruction set, one per line.

/// Declares inlined functions that all need the same instructions.
macro_rules! ops {
    (#$feature:tt $($(#[$doc:meta])* fn $name:ident($($arg:ident: $type:ty),*) -> $result:ty $body:block)*) => {$(
        $(#[$doc])*
        #[inline]
        #$feature
        pub fn $name($($arg: $type),*) -> $result $body
    )*};
}

pub(super) use ops;
