//! Answers, as the dissertation's visualiser gives them.

use std::net::SocketAddr;

use crate::line::{LineFormat, PoseLine};
use crate::outlet::Outlet;
use crate::packer::Packer;
use crate::socket::SocketError;

/// Sends a line `id x y theta` back for each line that was used, with positions as drawn: the offset added.
#[derive(Debug)]
pub struct Answers {
    packer: Packer,
    /// Where they go.
    pub outlet: Outlet,
}

impl Answers {
    /// Answers to that address.
    ///
    /// # Errors
    /// [`SocketError::Send`].
    pub fn open(to: SocketAddr, format: LineFormat, datagram_bytes: usize) -> Result<Self, SocketError> {
        Ok(Self { packer: Packer::new(format, datagram_bytes), outlet: Outlet::open("udp-source", to, 0.0)? })
    }

    /// Answers a line, when there are enough of them or when [`flush`](Self::flush) is called.
    pub fn push(&mut self, line: &PoseLine) {
        let Self { packer, outlet } = self;
        packer.push(line, |batch| outlet.send(batch));
    }

    /// Sends what is left.
    pub fn flush(&mut self) {
        let Self { packer, outlet } = self;
        packer.flush(|batch| outlet.send(batch));
    }
}
