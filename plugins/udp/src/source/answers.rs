//! Answers received lines like the dissertation's visualiser.

use std::net::SocketAddr;

use crate::line::{LineFormat, PoseLine};
use crate::outlet::Outlet;
use crate::packer::Packer;
use crate::socket::SocketError;

/// The sender of answers: a line `id x y theta` for each accepted line. Positions are those in the
/// fleet, with the offset added.
#[derive(Debug)]
pub struct Answers {
    packer: Packer,
    /// The sender of datagrams.
    pub outlet: Outlet,
}

impl Answers {
    /// Opens a socket that sends answers to `to`.
    ///
    /// # Errors
    /// Returns [`SocketError::Send`].
    pub fn open(
        to: SocketAddr,
        format: LineFormat,
        datagram_bytes: usize,
    ) -> Result<Self, SocketError> {
        Ok(Self {
            packer: Packer::new(format, datagram_bytes),
            outlet: Outlet::open("udp-source", to, 0.0)?,
        })
    }

    /// Adds an answer. Answers are sent when a batch is full, or by [`flush`](Self::flush).
    pub fn push(&mut self, line: &PoseLine) {
        let Self { packer, outlet } = self;
        packer.push(line, |batch| outlet.send(batch));
    }

    /// Sends the remaining answers.
    pub fn flush(&mut self) {
        let Self { packer, outlet } = self;
        packer.flush(|batch| outlet.send(batch));
    }
}
