//! A small MQTT broker (3.1.1) within the plugin, so that a fleet works without another program.
//!
//! It knows what VDA 5050 needs: topics with wildcards, messages that are kept, last wills, user
//! and password, quality of service 0 and 1 (2 counts as 1). It keeps no sessions: a client that
//! comes back subscribes again. A client that reads too slowly misses messages, and one that reads
//! nothing is cut off.
//!
//! Clients can't exhaust its memory: messages that wait or are kept have a budget, few clients may
//! send a large message at the same time, and one that hasn't said who it is has little room and
//! time.

mod hub;
mod peer;
mod stream;

use std::collections::VecDeque;
use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;

use parking_lot::Mutex;
use rumqttc::{Connect, ConnectAuth};
use tokio::net::TcpListener;
use tokio::sync::Semaphore;
use tokio::task::AbortHandle;

use hub::Hub;
use peer::Peer;
use stream::{MOST_LARGE, Stream};

/// The most clients that haven't said who they are.
const MOST_STRANGERS: usize = 512;
/// The pause after an error of the listener, such as too many open files.
const ERROR_PAUSE: Duration = Duration::from_millis(100);

/// The user and the password that clients need.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Login {
    /// The name of the user.
    pub user: String,
    /// The password.
    pub password: String,
}

/// The clients that may connect.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Access {
    /// Those who know user and password.
    Login(Login),
    /// All.
    Anonymous,
}

/// A broker that listens.
#[derive(Debug)]
pub struct Server {
    address: SocketAddr,
}

impl Server {
    /// Listens at an address, until the process ends. Port 0 is any free one.
    ///
    /// # Errors
    /// If the address can't be listened at.
    pub fn start(address: SocketAddr, access: Access) -> std::io::Result<Self> {
        let socket = std::net::TcpListener::bind(address)?;
        socket.set_nonblocking(true)?;
        let address = socket.local_addr()?;
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
        std::thread::Builder::new().name("broker".to_owned()).spawn(move || {
            runtime.block_on(async {
                match TcpListener::from_std(socket) {
                    Ok(listener) => serve(listener, Arc::new(access)).await,
                    Err(error) => regatta_plugin::tell!("vda5050: broker: {error}"),
                }
            });
        })?;
        Ok(Self { address })
    }

    /// The address.
    pub fn address(&self) -> SocketAddr {
        self.address
    }
}

async fn serve(listener: TcpListener, access: Arc<Access>) {
    let hub = Arc::new(Mutex::new(Hub::default()));
    let large = Arc::new(Semaphore::new(MOST_LARGE));
    let mut strangers = Strangers::default();
    loop {
        let Ok((stream, _)) = listener.accept().await else {
            strangers.close_oldest();
            tokio::time::sleep(ERROR_PAUSE).await;
            continue;
        };
        let peer = Peer::new(Stream::new(stream, Arc::clone(&large)), Arc::clone(&hub));
        strangers.add(tokio::spawn(peer.serve(Arc::clone(&access))).abort_handle());
    }
}

/// The clients that have not named themselves yet, from the oldest on. The oldest makes room.
#[derive(Default)]
struct Strangers(VecDeque<AbortHandle>);

impl Strangers {
    fn add(&mut self, stranger: AbortHandle) {
        self.forget_finished();
        if self.0.len() >= MOST_STRANGERS {
            self.close_oldest();
        }
        self.0.push_back(stranger);
    }

    fn close_oldest(&mut self) {
        self.forget_finished();
        if let Some(oldest) = self.0.pop_front() {
            oldest.abort();
        }
    }

    fn forget_finished(&mut self) {
        self.0.retain(|stranger| !stranger.is_finished());
    }
}

impl Access {
    /// Whether a client may connect.
    fn admits(&self, connect: &Connect) -> bool {
        match (self, &connect.auth) {
            (Self::Anonymous, _) => true,
            (Self::Login(login), ConnectAuth::UsernamePassword { username, password }) => {
                is_same(login.user.as_bytes(), username.as_bytes())
                    & is_same(login.password.as_bytes(), password)
            }
            _ => false,
        }
    }
}

/// Compares in a time that depends on the lengths alone.
fn is_same(one: &[u8], other: &[u8]) -> bool {
    let difference = one.iter().zip(other).fold(0, |sum, (one, other)| sum | (one ^ other));
    one.len() == other.len() && difference == 0
}

#[cfg(test)]
mod tests;
