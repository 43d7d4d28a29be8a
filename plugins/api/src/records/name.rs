//! Names of fleets and of the columns that plugins publish.

use core::fmt;
use core::str::FromStr;

/// The longest name, in bytes.
pub const MAX_NAME_BYTES: usize = 64;

/// The name of a fleet. Fleets with different names share nothing, so any number of them run side
/// by side.
///
/// ```
/// use regatta_plugin::FleetName;
///
/// let name: FleetName = "harbour-2".parse().unwrap();
/// assert_eq!(name.as_str(), "harbour-2");
/// assert_eq!(FleetName::default().as_str(), "default");
/// assert!("harbour 2".parse::<FleetName>().is_err());
/// ```
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct FleetName(String);

/// The name of a column, as in `regatta/F/columns/NAME`: the same rules as for [`FleetName`].
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct ColumnName(String);

/// The error of parsing a [`FleetName`] or a [`ColumnName`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NameError {
    /// The text is empty.
    #[error(
        "a name can't be empty; give it 1 to {MAX_NAME_BYTES} letters, digits, '-', '_' or '.'"
    )]
    Empty,
    /// The text is too long.
    #[error("the name is {bytes} bytes long; at most {MAX_NAME_BYTES} are allowed")]
    TooLong {
        /// Its length in bytes.
        bytes: usize,
    },
    /// The text has a character that a service name can't have.
    #[error(
        "{character:?} in the name {name:?} is not allowed; use letters (a-z, A-Z), digits, '-', \
         '_' and '.'"
    )]
    Character {
        /// The whole text.
        name: String,
        /// The first character that is not allowed.
        character: char,
    },
}

fn check(text: &str) -> Result<(), NameError> {
    if text.is_empty() {
        return Err(NameError::Empty);
    }
    if text.len() > MAX_NAME_BYTES {
        return Err(NameError::TooLong { bytes: text.len() });
    }
    // A slash would make another service of it, and the rest keeps names readable in a shell.
    match text.chars().find(|c| !c.is_ascii_alphanumeric() && !"-_.".contains(*c)) {
        Some(character) => Err(NameError::Character { name: text.to_owned(), character }),
        None => Ok(()),
    }
}

/// Implements the methods and traits of a name.
macro_rules! name {
    ($name:ident) => {
        impl $name {
            /// The name as text.
            pub fn as_str(&self) -> &str {
                &self.0
            }
        }

        impl FromStr for $name {
            type Err = NameError;

            fn from_str(text: &str) -> Result<Self, NameError> {
                check(text).map(|()| Self(text.to_owned()))
            }
        }

        impl fmt::Display for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str(&self.0)
            }
        }
    };
}

name!(FleetName);
name!(ColumnName);

impl Default for FleetName {
    fn default() -> Self {
        Self("default".to_owned())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_accept_the_characters_of_service_names() {
        for good in ["default", "a", "A.b-c_9", &"x".repeat(MAX_NAME_BYTES)] {
            assert_eq!(good.parse::<FleetName>().unwrap().to_string(), good);
        }
        assert_eq!("".parse::<FleetName>(), Err(NameError::Empty));
        assert_eq!("x".repeat(65).parse::<FleetName>(), Err(NameError::TooLong { bytes: 65 }));
        for (bad, character) in [("a/b", '/'), ("a b", ' '), ("é", 'é'), ("a\0", '\0')] {
            let expected = NameError::Character { name: bad.to_owned(), character };
            assert_eq!(bad.parse::<FleetName>(), Err(expected.clone()));
            assert_eq!(bad.parse::<ColumnName>(), Err(expected));
        }
    }
}
