//! UDP sockets: many datagrams a call out (generic segmentation offload) and in (`recvmmsg` and generic receive
//! offload), where the system has them.

use std::io::{self, ErrorKind, IoSliceMut};
use std::net::{Ipv4Addr, Ipv6Addr, SocketAddr, ToSocketAddrs, UdpSocket};
use std::str::FromStr;
use std::time::Duration;

use quinn_udp::{RecvMeta, Transmit, UdpSocketState};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use socket2::SockRef;

use crate::packer::MAX_DATAGRAM_BYTES;

/// Size of the buffers in the system that is asked for; it may grant less (`net.core.rmem_max` on Linux).
const KERNEL_BUFFER_BYTES: usize = 8 << 20;
/// Each holds one datagram, or on Linux up to 64 that came together.
const BUFFERS: usize = 16;
const BUFFER_BYTES: usize = 1 << 16;
/// How long a full send buffer is waited for.
const SEND_PATIENCE: Duration = Duration::from_millis(20);

/// Why there is no socket.
#[derive(Debug, thiserror::Error)]
pub enum SocketError {
    /// The name has no address.
    #[error("can't find '{address}': {reason}; give HOST:PORT, 127.0.0.1:9001 say")]
    Resolve {
        /// What was asked for.
        address: String,
        /// The system's reason.
        reason: io::Error,
    },
    /// Nobody can listen at port 0.
    #[error("'{0}' has port 0, which nobody can listen at; give the receiver's port")]
    NoPort(String),
    /// The address can't be listened on.
    #[error("can't listen on {address}: {reason}; is another program listening there? choose another port")]
    Listen {
        /// What was asked for.
        address: SocketAddr,
        /// The system's reason.
        reason: io::Error,
    },
    /// The address can't be sent to.
    #[error("can't send to {address}: {reason}")]
    Send {
        /// What was asked for.
        address: SocketAddr,
        /// The system's reason.
        reason: io::Error,
    },
}

/// Where to listen: `HOST:PORT`, or a port alone for one of this machine's own (loopback).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Listen(String);

impl Listen {
    /// A port of this machine's own (loopback); any free one for 0.
    pub fn loopback(port: u16) -> Self {
        Self(format!("127.0.0.1:{port}"))
    }
}

impl FromStr for Listen {
    type Err = core::convert::Infallible;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let is_port = !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
        let port = if is_port { text.parse().ok() } else { None };
        Ok(port.map_or_else(|| Self(text.to_owned()), Self::loopback))
    }
}

/// The address of somebody to send to.
///
/// # Errors
/// [`SocketError::Resolve`], or [`SocketError::NoPort`].
pub fn resolve_receiver(address: &str) -> Result<SocketAddr, SocketError> {
    let found = resolve(address)?;
    if found.port() == 0 { Err(SocketError::NoPort(address.to_owned())) } else { Ok(found) }
}

/// The address of a name and port.
///
/// # Errors
/// [`SocketError::Resolve`].
pub fn resolve(address: &str) -> Result<SocketAddr, SocketError> {
    let failed = |reason| SocketError::Resolve { address: address.to_owned(), reason };
    let mut found = address.to_socket_addrs().map_err(failed)?;
    found.next().ok_or_else(|| failed(io::Error::from(ErrorKind::AddrNotAvailable)))
}

/// A socket for one direction.
#[derive(Debug)]
pub struct Socket {
    socket: UdpSocket,
    state: UdpSocketState,
}

/// Room for what one call receives.
#[derive(Debug)]
pub struct Buffers(Vec<u8>);

impl Default for Buffers {
    fn default() -> Self {
        Self(vec![0; BUFFERS * BUFFER_BYTES])
    }
}

impl Socket {
    /// A socket that receives at an address of this machine.
    ///
    /// # Errors
    /// [`SocketError::Resolve`] and [`SocketError::Listen`].
    pub fn listen(address: &Listen) -> Result<Self, SocketError> {
        let address = resolve(&address.0)?;
        let open = || {
            let socket = UdpSocket::bind(address)?;
            let state = UdpSocketState::new((&socket).into())?;
            // As much as the system grants: see `receive_buffer_bytes`.
            let _ = SockRef::from(&socket).set_recv_buffer_size(KERNEL_BUFFER_BYTES);
            Ok(Self { socket, state })
        };
        open().map_err(|reason| SocketError::Listen { address, reason })
    }

    /// A socket that sends to one address, and receives from nowhere else.
    ///
    /// # Errors
    /// [`SocketError::Send`].
    pub fn towards(address: SocketAddr) -> Result<Self, SocketError> {
        let open = || {
            let socket = UdpSocket::bind(source_of(address))?;
            socket.set_broadcast(true)?;
            // Then the system tells when nobody listens there. Elsewhere, a connected socket takes no address.
            if cfg!(target_os = "linux") {
                socket.connect(address)?;
            }
            let state = UdpSocketState::new((&socket).into())?;
            let _ = SockRef::from(&socket).set_send_buffer_size(KERNEL_BUFFER_BYTES);
            Ok(Self { socket, state })
        };
        open().map_err(|reason| SocketError::Send { address, reason })
    }

    /// The address that it listens on; with the port that the system chose, if it was to choose one.
    ///
    /// # Errors
    /// Whatever the system says.
    pub fn local_address(&self) -> io::Result<SocketAddr> {
        self.socket.local_addr()
    }

    /// The size of the receive buffer that the system granted, in bytes as it counts them (with its own overhead).
    pub fn receive_buffer_bytes(&self) -> usize {
        SockRef::from(&self.socket).recv_buffer_size().unwrap_or(0)
    }

    /// Sends datagrams that lie end to end, each `datagram_bytes` long but the last, in as few calls as the system
    /// allows. On an error, the rest of them is not sent. Whether somebody listened there a moment ago, as far as
    /// the system knows.
    ///
    /// # Errors
    /// Whatever the system says.
    pub fn send(&self, to: SocketAddr, bytes: &[u8], datagram_bytes: usize) -> io::Result<bool> {
        let together = (MAX_DATAGRAM_BYTES / datagram_bytes).clamp(1, self.state.max_gso_segments());
        let mut heard = true;
        for part in bytes.chunks(together * datagram_bytes) {
            match self.send_together(to, part, datagram_bytes) {
                // The way there can't take them together: it is remembered, and they go one by one.
                Err(_) if together > 1 && self.state.max_gso_segments() == 1 => {
                    for one in part.chunks(datagram_bytes) {
                        heard &= self.send_together(to, one, datagram_bytes)?;
                    }
                }
                outcome => heard &= outcome?,
            }
        }
        Ok(heard)
    }

    fn send_together(&self, to: SocketAddr, bytes: &[u8], datagram_bytes: usize) -> io::Result<bool> {
        let transmit =
            Transmit { destination: to, ecn: None, contents: bytes, segment_size: Some(datagram_bytes), src_ip: None };
        let send = || self.state.try_send((&self.socket).into(), &transmit);
        match send() {
            Err(error) if error.kind() == ErrorKind::WouldBlock => {
                self.wait(PollFlags::OUT, SEND_PATIENCE);
                send().map(|()| true)
            }
            // What an earlier datagram met with; this one was not sent.
            Err(error) if error.kind() == ErrorKind::ConnectionRefused => send().map(|()| false),
            outcome => outcome.map(|()| true),
        }
    }

    /// Waits until there is something to receive, for `timeout` at most; whether there may be.
    pub fn wait_to_receive(&self, timeout: Duration) -> bool {
        self.wait(PollFlags::IN, timeout)
    }

    fn wait(&self, what: PollFlags, timeout: Duration) -> bool {
        let timeout = Timespec::try_from(timeout).ok();
        // An error is an interrupting signal: whoever waits looks around and waits again.
        poll(&mut [PollFd::new(&self.socket, what)], timeout.as_ref()).is_ok_and(|ready| ready > 0)
    }

    /// Hands over datagrams that have come, a bounded number of them. Whether there were any.
    ///
    /// # Errors
    /// Whatever the system says.
    pub fn receive(&self, buffers: &mut Buffers, mut each: impl FnMut(&[u8])) -> io::Result<bool> {
        let mut rest = buffers.0.chunks_exact_mut(BUFFER_BYTES);
        let mut slices: [IoSliceMut<'_>; BUFFERS] =
            std::array::from_fn(|_| IoSliceMut::new(rest.next().unwrap_or_default()));
        let mut metas = [RecvMeta::default(); BUFFERS];
        let received = match self.state.recv((&self.socket).into(), &mut slices, &mut metas) {
            Ok(received) => received,
            Err(error) if is_nothing(&error) => return Ok(false),
            Err(error) => return Err(error),
        };
        for (slice, meta) in slices.iter().zip(&metas[..received]) {
            // An empty datagram has no stride.
            slice[..meta.len].chunks(meta.stride.max(1)).for_each(&mut each);
        }
        Ok(received > 0)
    }

    /// Packets that the system threw away because the receive buffer was full, since the socket was opened; up to
    /// 64 datagrams that came together are one packet. `None` where it doesn't say.
    pub fn dropped(&self) -> Option<u64> {
        #[cfg(target_os = "linux")]
        {
            let inode = rustix::fs::fstat(&self.socket).ok()?.st_ino.to_string();
            let table = if self.socket.local_addr().ok()?.is_ipv4() { "/proc/net/udp" } else { "/proc/net/udp6" };
            let table = std::fs::read_to_string(table).ok()?;
            let row = table.lines().map(|row| row.split_ascii_whitespace().collect::<Vec<_>>());
            row.into_iter().find(|row| row.get(9) == Some(&inode.as_str()))?.last()?.parse().ok()
        }
        #[cfg(not(target_os = "linux"))]
        None
    }
}

/// Nothing is there; or a peer is gone that something was sent to, which Windows tells the receiver.
fn is_nothing(error: &io::Error) -> bool {
    matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted | ErrorKind::ConnectionReset)
}

/// Any port, of an address of the same kind: loopback stays on loopback.
fn source_of(address: SocketAddr) -> SocketAddr {
    let ip = match (address, address.ip().is_loopback()) {
        (SocketAddr::V4(_), true) => Ipv4Addr::LOCALHOST.into(),
        (SocketAddr::V4(_), false) => Ipv4Addr::UNSPECIFIED.into(),
        (SocketAddr::V6(_), true) => Ipv6Addr::LOCALHOST.into(),
        (SocketAddr::V6(_), false) => Ipv6Addr::UNSPECIFIED.into(),
    };
    SocketAddr::new(ip, 0)
}

#[cfg(test)]
mod tests;
