//! Collects the log of a fleet on a thread, from its events, contacts and frames ([`watch`]).

mod entries;
mod health;
mod standing;
pub mod watch;

#[cfg(test)]
mod tests;
