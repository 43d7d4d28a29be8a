//! [`Error`], which the functions of plugins and producers return. Every other error is a closed
//! enum per operation.

use core::fmt;

/// The result of a plugin's functions: `Result` alone is `Result<(), Error>`.
pub type Result<T = (), E = Error> = core::result::Result<T, E>;

/// Any error, as one line: the message, then each cause after a colon.
///
/// Every error type turns into it with `?`. `fn main() -> regatta_plugin::Result` prints it as
/// `Error: …`, without quotes or a backtrace, and exits with code 1.
pub struct Error(Box<dyn core::error::Error + Send + Sync>);

impl Error {
    /// Creates an error with a message that names the fault, its place and the remedy.
    pub fn new(message: impl fmt::Display) -> Self {
        Self(message.to_string().into())
    }

    /// The wrapped error, to inspect or to downcast.
    pub fn get_ref(&self) -> &(dyn core::error::Error + Send + Sync + 'static) {
        &*self.0
    }
}

impl<E: core::error::Error + Send + Sync + 'static> From<E> for Error {
    fn from(error: E) -> Self {
        Self(error.into())
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.0)?;
        let mut cause = self.0.source();
        while let Some(error) = cause {
            write!(f, ": {error}")?;
            cause = error.source();
        }
        Ok(())
    }
}

/// The same as `Display`, because `main` prints errors by `Debug`.
impl fmt::Debug for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, thiserror::Error)]
    #[error("outer")]
    struct Outer(#[source] std::io::Error);

    #[test]
    fn an_error_prints_as_one_line_with_its_causes() {
        let error = Error::from(Outer(std::io::Error::other("inner")));
        assert_eq!(format!("{error:?}"), "outer: inner");
        assert_eq!(format!("{:?}", Error::new("plain")), "plain");
    }
}
