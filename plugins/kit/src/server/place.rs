//! The places where a server listens: an address over TCP, or a Unix socket that only this user can
//! open.

use std::fmt;
use std::io;
use std::net::SocketAddr;
use std::path::PathBuf;

use regatta_plugin::FleetName;
use tokio::net::TcpListener;

use super::ServeError;
use super::guard::Peer;
use super::stream::Io;
use crate::private;

/// A place where a server listens.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Place {
    /// A Unix socket, which only this user can open.
    Socket(PathBuf),
    /// An address, which any user of this machine can reach, at least.
    Tcp(SocketAddr),
}

impl Place {
    /// The address over TCP.
    pub fn address(&self) -> Option<SocketAddr> {
        match self {
            Self::Tcp(address) => Some(*address),
            Self::Socket(_) => None,
        }
    }
}

impl fmt::Display for Place {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Socket(path) => write!(formatter, "{}", path.display()),
            Self::Tcp(address) => write!(formatter, "http://{address}"),
        }
    }
}

/// Returns the Unix socket of a service of a fleet, in this user's directory.
///
/// # Errors
/// If this user has no directory that others can't write to, or its name is too long for a socket.
pub fn socket_path(fleet: &FleetName, service: &str) -> io::Result<PathBuf> {
    let path = private::directory()?.join(format!("{fleet}.{service}"));
    match path.as_os_str().len() {
        0..MAX_SOCKET_BYTES => Ok(path),
        _ => Err(io::Error::other(format!(
            "{} is too long for the name of a socket: set {} to a shorter directory, or give the \
             fleet a shorter name",
            path.display(),
            regatta_plugin::RUNTIME_DIR_VARIABLE
        ))),
    }
}

/// The longest name of a Unix socket that all systems know, with its end.
const MAX_SOCKET_BYTES: usize = 104;

/// An open place.
pub(super) struct Listener {
    place: Place,
    port: Port,
}

enum Port {
    Tcp(TcpListener),
    #[cfg(unix)]
    Socket(tokio::net::UnixListener),
}

impl Listener {
    /// Opens a place. It needs the context of a runtime.
    pub(super) fn bind(place: &Place) -> Result<Self, ServeError> {
        Self::open(place).map_err(|reason| ServeError { place: place.clone(), reason })
    }

    fn open(place: &Place) -> io::Result<Self> {
        match place {
            Place::Tcp(address) => {
                let listener = std::net::TcpListener::bind(address)?;
                listener.set_nonblocking(true)?;
                bound_buffers(&listener);
                let place = Place::Tcp(listener.local_addr()?);
                Ok(Self { place, port: Port::Tcp(TcpListener::from_std(listener)?) })
            }
            #[cfg(unix)]
            Place::Socket(path) => {
                let listener = bind_socket(path)?;
                listener.set_nonblocking(true)?;
                let port = Port::Socket(tokio::net::UnixListener::from_std(listener)?);
                Ok(Self { place: place.clone(), port })
            }
            #[cfg(not(unix))]
            Place::Socket(_) => Err(io::ErrorKind::Unsupported.into()),
        }
    }

    pub(super) fn place(&self) -> &Place {
        &self.place
    }

    /// The other ends of its connections.
    pub(super) fn peer(&self) -> Peer {
        match &self.place {
            Place::Socket(_) => Peer::Socket,
            Place::Tcp(address) if address.ip().is_loopback() => Peer::Loopback,
            Place::Tcp(_) => Peer::Network,
        }
    }

    pub(super) async fn accept(&self) -> io::Result<Box<dyn Io>> {
        match &self.port {
            Port::Tcp(listener) => Ok(Box::new(listener.accept().await?.0)),
            #[cfg(unix)]
            Port::Socket(listener) => Ok(Box::new(listener.accept().await?.0)),
        }
    }
}

impl Drop for Listener {
    fn drop(&mut self) {
        if let Place::Socket(path) = &self.place {
            // If it has been removed already, there is nothing to do.
            let _ = std::fs::remove_file(path);
        }
    }
}

/// The bytes of an answer that the system keeps for a client that doesn't read them, in each
/// connection.
#[cfg(unix)]
const SEND_BUFFER_BYTES: usize = 128 << 10;

/// Bounds the buffers of a listener's connections: by default the system keeps megabytes for each.
#[cfg(unix)]
fn bound_buffers(listener: &std::net::TcpListener) {
    // If the system refuses, its own bounds hold.
    let _ = rustix::net::sockopt::set_socket_send_buffer_size(listener, SEND_BUFFER_BYTES);
}

#[cfg(not(unix))]
fn bound_buffers(_listener: &std::net::TcpListener) {}

/// Makes a socket that only this user can open, in place of one that a killed process left.
#[cfg(unix)]
fn bind_socket(path: &std::path::Path) -> io::Result<std::os::unix::net::UnixListener> {
    use std::os::unix::fs::PermissionsExt;
    use std::os::unix::net::{UnixListener, UnixStream};

    if UnixStream::connect(path).is_ok() {
        return Err(io::ErrorKind::AddrInUse.into());
    }
    let folder = path.parent().unwrap_or(std::path::Path::new("."));
    // It appears under its name with its rights.
    let new =
        tempfile::Builder::new().prefix(".").make_in(folder, |new| UnixListener::bind(new))?;
    std::fs::set_permissions(new.path(), std::fs::Permissions::from_mode(0o600))?;
    let (listener, new) = new.into_parts();
    new.persist(path)?;
    Ok(listener)
}
