//! UDP sockets that send and receive many datagrams per system call where the system supports it:
//! with generic segmentation offload, `recvmmsg` and generic receive offload.

use std::io::{self, ErrorKind, IoSliceMut};
use std::net::{Ipv4Addr, Ipv6Addr, SocketAddr, ToSocketAddrs, UdpSocket};
use std::str::FromStr;
use std::time::Duration;

use quinn_udp::{RecvMeta, Transmit, UdpSocketState};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use socket2::SockRef;

use crate::packer::MAX_DATAGRAM_BYTES;

/// The requested size of the system's socket buffers. The system may grant less
/// (`net.core.rmem_max` on Linux).
const KERNEL_BUFFER_BYTES: usize = 8 << 20;
/// The number of buffers. Each receives one datagram, or on Linux up to 64 that arrived together.
const BUFFERS: usize = 16;
const BUFFER_BYTES: usize = 1 << 16;
/// The longest wait for room in the send buffer.
const SEND_TIMEOUT: Duration = Duration::from_millis(20);

/// A UDP socket that either sends or receives.
#[derive(Debug)]
pub struct Socket {
    socket: UdpSocket,
    state: UdpSocketState,
}

/// The buffers of one call of [`Socket::receive`].
#[derive(Debug)]
pub struct Buffers(Vec<u8>);

impl Default for Buffers {
    fn default() -> Self {
        Self(vec![0; BUFFERS * BUFFER_BYTES])
    }
}

impl Socket {
    /// Opens a socket that receives at an address of this machine.
    ///
    /// # Errors
    /// Returns [`SocketError::Resolve`] or [`SocketError::Listen`].
    pub fn listen(address: &Listen) -> Result<Self, SocketError> {
        let address = resolve(&address.0)?;
        let socket = Self::bind(address);
        let socket = socket.map_err(|reason| SocketError::Listen { address, reason })?;
        // The system may grant less, which `receive_buffer_bytes` returns.
        let _ = SockRef::from(&socket.socket).set_recv_buffer_size(KERNEL_BUFFER_BYTES);
        Ok(socket)
    }

    fn bind(address: SocketAddr) -> io::Result<Self> {
        let socket = UdpSocket::bind(address)?;
        Ok(Self { state: UdpSocketState::new((&socket).into())?, socket })
    }

    /// Opens a socket that sends to one address.
    ///
    /// # Errors
    /// Returns [`SocketError::Send`].
    pub fn towards(address: SocketAddr) -> Result<Self, SocketError> {
        Self::connect(address).map_err(|reason| SocketError::Send { address, reason })
    }

    fn connect(address: SocketAddr) -> io::Result<Self> {
        let socket = UdpSocket::bind(source_of(address))?;
        socket.set_broadcast(true)?;
        // On a connected socket, Linux reports that no program receives at the address. Other
        // systems don't accept the destination that each send call gives for a connected socket.
        if cfg!(target_os = "linux") {
            socket.connect(address)?;
        }
        let state = UdpSocketState::new((&socket).into())?;
        let _ = SockRef::from(&socket).set_send_buffer_size(KERNEL_BUFFER_BYTES);
        Ok(Self { socket, state })
    }

    /// Returns the socket's own address. If port 0 was requested, it has the port that the system
    /// chose.
    ///
    /// # Errors
    /// Returns the system's error.
    pub fn local_address(&self) -> io::Result<SocketAddr> {
        self.socket.local_addr()
    }

    /// Returns the size of the receive buffer in bytes, as the system counts them (with its own
    /// overhead).
    pub fn receive_buffer_bytes(&self) -> usize {
        SockRef::from(&self.socket).recv_buffer_size().unwrap_or(0)
    }

    /// Sends contiguous datagrams, each `datagram_bytes` long except the last, in as few calls as
    /// the system allows. Returns false if the system has reported that no program receives at the
    /// address.
    ///
    /// # Errors
    /// Returns the system's error. The rest of the datagrams is then not sent.
    pub fn send(&self, to: SocketAddr, bytes: &[u8], datagram_bytes: usize) -> io::Result<bool> {
        let together =
            (MAX_DATAGRAM_BYTES / datagram_bytes).clamp(1, self.state.max_gso_segments());
        let mut reachable = true;
        for part in bytes.chunks(together * datagram_bytes) {
            match self.send_together(to, part, datagram_bytes) {
                // The network path doesn't support segmentation offload. The state remembers that,
                // and the datagrams are sent one by one.
                Err(_) if together > 1 && self.state.max_gso_segments() == 1 => {
                    for one in part.chunks(datagram_bytes) {
                        reachable &= self.send_together(to, one, datagram_bytes)?;
                    }
                }
                outcome => reachable &= outcome?,
            }
        }
        Ok(reachable)
    }

    fn send_together(
        &self,
        to: SocketAddr,
        bytes: &[u8],
        datagram_bytes: usize,
    ) -> io::Result<bool> {
        let transmit = Transmit {
            destination: to,
            ecn: None,
            contents: bytes,
            segment_size: Some(datagram_bytes),
            src_ip: None,
        };
        let mut reachable = true;
        match self.state.try_send((&self.socket).into(), &transmit) {
            Ok(()) => return Ok(true),
            Err(error) if error.kind() == ErrorKind::WouldBlock => {
                self.wait(PollFlags::OUT, SEND_TIMEOUT);
            }
            // The error belongs to an earlier datagram, but this one was not sent.
            Err(error) if error.kind() == ErrorKind::ConnectionRefused => reachable = false,
            Err(error) => return Err(error),
        }
        self.state.try_send((&self.socket).into(), &transmit)?;
        Ok(reachable)
    }

    /// Waits until a datagram has arrived, but not longer than `timeout`. Returns whether one may
    /// have arrived.
    pub fn wait_to_receive(&self, timeout: Duration) -> bool {
        self.wait(PollFlags::IN, timeout)
    }

    fn wait(&self, event: PollFlags, timeout: Duration) -> bool {
        let timeout = Timespec::try_from(timeout).ok();
        // The only error is an interrupting signal, after which the callers wait again.
        poll(&mut [PollFd::new(&self.socket, event)], timeout.as_ref()).is_ok_and(|ready| ready > 0)
    }

    /// Calls `each` with the datagrams that have arrived, up to a limit. Returns whether there were
    /// any.
    ///
    /// # Errors
    /// Returns the system's error.
    pub fn receive(&self, buffers: &mut Buffers, mut each: impl FnMut(&[u8])) -> io::Result<bool> {
        let mut rest = buffers.0.chunks_exact_mut(BUFFER_BYTES);
        let mut slices: [IoSliceMut<'_>; BUFFERS] =
            std::array::from_fn(|_| IoSliceMut::new(rest.next().unwrap_or_default()));
        let mut metas = [RecvMeta::default(); BUFFERS];
        let received = match self.state.recv((&self.socket).into(), &mut slices, &mut metas) {
            Ok(received) => received,
            Err(error) if is_transient(&error) => return Ok(false),
            Err(error) => return Err(error),
        };
        for (slice, meta) in slices.iter().zip(&metas[..received]) {
            // An empty datagram has no stride.
            slice[..meta.len].chunks(meta.stride.max(1)).for_each(&mut each);
        }
        Ok(received > 0)
    }

    /// Returns the number of packets that the system has dropped because the receive buffer was
    /// full, since the socket was opened. Up to 64 datagrams that arrive together count as one
    /// packet. `None` on systems that don't report it.
    pub fn dropped(&self) -> Option<u64> {
        #[cfg(target_os = "linux")]
        {
            let inode = rustix::fs::fstat(&self.socket).ok()?.st_ino.to_string();
            let table = if self.socket.local_addr().ok()?.is_ipv4() {
                "/proc/net/udp"
            } else {
                "/proc/net/udp6"
            };
            let table = std::fs::read_to_string(table).ok()?;
            let row = table.lines().map(|row| row.split_ascii_whitespace().collect::<Vec<_>>());
            row.into_iter().find(|row| row.get(9) == Some(&inode.as_str()))?.last()?.parse().ok()
        }
        #[cfg(not(target_os = "linux"))]
        None
    }
}

/// Whether an error only means that no datagram has arrived. Windows also reports a closed port of
/// a peer.
fn is_transient(error: &io::Error) -> bool {
    matches!(
        error.kind(),
        ErrorKind::WouldBlock | ErrorKind::Interrupted | ErrorKind::ConnectionReset
    )
}

/// The error of opening a socket.
#[derive(Debug, thiserror::Error)]
pub enum SocketError {
    /// The address can't be resolved.
    #[error("can't resolve '{address}': {reason}; give HOST:PORT, for example 127.0.0.1:9001")]
    Resolve {
        /// The requested address.
        address: String,
        /// The system's reason.
        reason: io::Error,
    },
    /// The receiver's address has port 0.
    #[error("'{0}' has port 0, at which no program can receive; give the receiver's port")]
    NoPort(String),
    /// The address can't be listened on.
    #[error(
        "can't listen on {address}: {reason}; is another program listening there? choose another \
         port"
    )]
    Listen {
        /// The requested address.
        address: SocketAddr,
        /// The system's reason.
        reason: io::Error,
    },
    /// The address can't be sent to.
    #[error("can't send to {address}: {reason}")]
    Send {
        /// The requested address.
        address: SocketAddr,
        /// The system's reason.
        reason: io::Error,
    },
}

/// An address to receive at: `HOST:PORT`, or only a port for the loopback interface.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Listen(String);

impl Listen {
    /// Returns a port of the loopback interface; 0 stands for any free port.
    pub fn loopback(port: u16) -> Self {
        Self(format!("127.0.0.1:{port}"))
    }
}

impl FromStr for Listen {
    type Err = core::convert::Infallible;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let is_number = text.bytes().all(|byte| byte.is_ascii_digit());
        Ok(match text.parse() {
            Ok(port) if is_number => Self::loopback(port),
            _ => Self(text.to_owned()),
        })
    }
}

/// Resolves the address of a receiver.
///
/// # Errors
/// Returns [`SocketError::Resolve`] if there is no such address, and [`SocketError::NoPort`] if its
/// port is 0.
pub fn resolve_receiver(address: &str) -> Result<SocketAddr, SocketError> {
    let found = resolve(address)?;
    if found.port() == 0 { Err(SocketError::NoPort(address.to_owned())) } else { Ok(found) }
}

/// Resolves a host name and port.
///
/// # Errors
/// Returns [`SocketError::Resolve`] if there is no such address.
pub fn resolve(address: &str) -> Result<SocketAddr, SocketError> {
    let mut found = address.to_socket_addrs();
    match found.as_mut().map(Iterator::next) {
        Ok(Some(found)) => Ok(found),
        _ => {
            let reason = found.err().unwrap_or(ErrorKind::AddrNotAvailable.into());
            Err(SocketError::Resolve { address: address.to_owned(), reason })
        }
    }
}

/// Returns the local address for sending to `address`, with any free port. The source of a loopback
/// address is a loopback address.
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
