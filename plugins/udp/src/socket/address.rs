//! Addresses on the command line, and the errors of opening a socket.

use std::io::{self, ErrorKind};
use std::net::{Ipv4Addr, Ipv6Addr, SocketAddr, ToSocketAddrs};
use std::str::FromStr;

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
        "can't listen on {address}: {reason}; is another program listening there? choose another port"
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
pub struct Listen(pub(super) String);

impl Listen {
    /// Returns a port of the loopback interface; 0 stands for any free port.
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
    let failed = |reason| SocketError::Resolve { address: address.to_owned(), reason };
    let mut found = address.to_socket_addrs().map_err(failed)?;
    found.next().ok_or_else(|| failed(io::Error::from(ErrorKind::AddrNotAvailable)))
}

/// Returns the local address for sending to `address`, with any free port. The source of a loopback
/// address is a loopback address.
pub(super) fn source_of(address: SocketAddr) -> SocketAddr {
    let ip = match (address, address.ip().is_loopback()) {
        (SocketAddr::V4(_), true) => Ipv4Addr::LOCALHOST.into(),
        (SocketAddr::V4(_), false) => Ipv4Addr::UNSPECIFIED.into(),
        (SocketAddr::V6(_), true) => Ipv6Addr::LOCALHOST.into(),
        (SocketAddr::V6(_), false) => Ipv6Addr::UNSPECIFIED.into(),
    };
    SocketAddr::new(ip, 0)
}
