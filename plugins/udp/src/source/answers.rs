//! Answers, as the dissertation's visualiser gives them.

use std::net::SocketAddr;

use crate::line::{LineFormat, PoseLine};
use crate::packer::Packer;
use crate::socket::{Socket, SocketError};

/// Sends a line `id x y theta` back for each line that was used, with positions as drawn: the offset added.
#[derive(Debug)]
pub struct Answers {
    socket: Socket,
    to: SocketAddr,
    packer: Packer,
    /// Lines sent.
    pub sent: u64,
    /// Lines that the system didn't take.
    pub refused: u64,
}

impl Answers {
    /// Answers to that address.
    ///
    /// # Errors
    /// [`SocketError::Send`].
    pub fn open(to: SocketAddr, format: LineFormat, datagram_bytes: usize) -> Result<Self, SocketError> {
        let packer = Packer::new(format, datagram_bytes);
        Ok(Self { socket: Socket::towards(to)?, to, packer, sent: 0, refused: 0 })
    }

    /// Answers a line, when there are enough of them or when [`flush`](Self::flush) is called.
    pub fn push(&mut self, line: &PoseLine) {
        let Self { socket, to, packer, sent, refused } = self;
        packer.push(line, |batch| match socket.send(*to, batch.bytes, batch.datagram_bytes) {
            Ok(_) => *sent += batch.lines,
            Err(_) => *refused += batch.lines,
        });
    }

    /// Sends what is left.
    pub fn flush(&mut self) {
        let Self { socket, to, packer, sent, refused } = self;
        packer.flush(|batch| match socket.send(*to, batch.bytes, batch.datagram_bytes) {
            Ok(_) => *sent += batch.lines,
            Err(_) => *refused += batch.lines,
        });
    }
}
