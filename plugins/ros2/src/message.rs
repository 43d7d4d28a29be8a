//! The messages of ROS 2, with the fields of their definitions in their order: CDR has no names.
//!
//! Tests compare them with the definitions in packages of ROS.

pub mod display;
pub mod geometry;
pub mod navigation;
pub mod open_rmf;
pub mod simulation;

/// A message of a topic, with the name of its type.
pub trait Typed: ros2_client::Message {
    /// The package that defines it.
    const PACKAGE: &'static str;
    /// Its name in the package.
    const NAME: &'static str;
}

/// Declares messages: `package struct Name { field: Type, … }`.
macro_rules! messages {
    ($($(#[$meta:meta])* $package:ident struct $name:ident {
        $($(#[$field_meta:meta])* $field:ident: $kind:ty,)*
    })*) => { $(
        $(#[$meta])*
        #[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
        pub struct $name {
            $($(#[$field_meta])* pub $field: $kind,)*
        }

        impl ros2_client::Message for $name {}

        impl crate::message::Typed for $name {
            const PACKAGE: &'static str = stringify!($package);
            const NAME: &'static str = stringify!($name);
        }
    )* };
}
use messages;

#[cfg(test)]
mod tests;
