//! How the lanes' files are written: one line per operation.

/// Declares inlined functions that all need the same instructions.
macro_rules! ops {
    (#$feature:tt $($(#[$doc:meta])* fn $name:ident($($arg:ident: $kind:ty),*) -> $result:ty $body:block)*) => {$(
        $(#[$doc])*
        #[inline]
        #$feature
        pub(super) fn $name($($arg: $kind),*) -> $result $body
    )*};
}

pub(super) use ops;
