//! A small MQTT broker (3.1.1) within the plugin, so that a fleet works without another program.
//!
//! It knows what VDA 5050 needs: topics with wildcards, messages that are kept, last wills, user
//! and password, quality of service 0 and 1 (2 counts as 1). It keeps no sessions: a client that
//! comes back subscribes again. A client that reads too slowly misses messages.

mod hub;

use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;

use bytes::BytesMut;
use parking_lot::Mutex;
use rumqttc::mqttbytes::Error as PacketError;
use rumqttc::{
    ConnAck, Connect, ConnectAuth, ConnectReturnCode, LastWill, Packet, PubAck, PubComp, PubRec,
    Publish, QoS, SubAck, Subscribe, SubscribeReasonCode, UnsubAck, valid_filter,
};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::mpsc::{Receiver, channel};

use hub::{Hub, lower};

/// The largest message, in bytes.
const MOST_BYTES: usize = 16 << 20;
/// Messages that may wait for a client.
const QUEUE: usize = 4096;
/// The most connections.
const MOST_CLIENTS: usize = 50_000;
/// The time in which a client has to say who it is.
const GREETING: Duration = Duration::from_secs(10);
/// The silence of a client that wants no limit.
const ENDLESS: Duration = Duration::from_secs(365 * 24 * 3600);
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
    loop {
        let Ok((stream, _)) = listener.accept().await else {
            tokio::time::sleep(ERROR_PAUSE).await;
            continue;
        };
        if hub.lock().len() < MOST_CLIENTS {
            let peer = Peer { stream, input: BytesMut::new(), hub: Arc::clone(&hub) };
            tokio::spawn(peer.serve(Arc::clone(&access)));
        }
    }
}

/// The end of a connection.
enum End {
    /// The client has said so.
    Farewell,
    /// It is gone, or sends what it may not.
    Broken,
}

/// A client.
struct Peer {
    stream: TcpStream,
    input: BytesMut,
    hub: Arc<Mutex<Hub>>,
}

impl Peer {
    async fn serve(mut self, access: Arc<Access>) {
        let greeting = tokio::time::timeout(GREETING, self.read()).await;
        let Ok(Some(Packet::Connect(connect))) = greeting else { return };
        if !access.admits(&connect) {
            let code = ConnectReturnCode::BadUserNamePassword;
            // The connection ends in any case.
            let _ = self.write(Packet::ConnAck(ConnAck::new(code, false))).await;
            return;
        }
        let (sender, messages) = channel(QUEUE);
        let will = connect.last_will.clone().map(publish_of);
        let number = self.hub.lock().join(&connect.client_id, will, sender);
        let end = self.talk(number, messages, &connect).await;
        let mut hub = self.hub.lock();
        if let (Some(will), End::Broken) = (hub.leave(number), end) {
            hub.publish(will);
        }
    }

    /// Passes messages on, in both directions.
    async fn talk(&mut self, number: u64, mut messages: Receiver<Publish>, it: &Connect) -> End {
        let silence = match it.keep_alive {
            0 => ENDLESS,
            seconds => Duration::from_secs(u64::from(seconds)).mul_f32(1.5),
        };
        let welcome = ConnAck::new(ConnectReturnCode::Success, false);
        if self.write(Packet::ConnAck(welcome)).await.is_none() {
            return End::Broken;
        }
        loop {
            let next = tokio::select! {
                packet = tokio::time::timeout(silence, self.read()) => {
                    let Ok(Some(packet)) = packet else { return End::Broken };
                    if packet == Packet::Disconnect {
                        return End::Farewell;
                    }
                    self.answer(number, packet)
                }
                message = messages.recv() => match message {
                    Some(message) => Ok(Some(Packet::Publish(message))),
                    // Another client with the same name has taken its place.
                    None => return End::Broken,
                },
            };
            let written = match next {
                Ok(Some(packet)) => self.write(packet).await,
                Ok(None) => Some(()),
                Err(()) => None,
            };
            if written.is_none() {
                return End::Broken;
            }
        }
    }

    /// Returns the answer to a packet, if there is one; an error for one that may not be sent.
    fn answer(&self, number: u64, packet: Packet) -> Result<Option<Packet>, ()> {
        Ok(match packet {
            Packet::Publish(message) => self.pass_on(message),
            Packet::PubRel(release) => Some(Packet::PubComp(PubComp::new(release.pkid))),
            Packet::Subscribe(subscribe) => Some(self.subscribe(number, subscribe)),
            Packet::Unsubscribe(it) => {
                self.hub.lock().unsubscribe(number, &it.topics);
                Some(Packet::UnsubAck(UnsubAck::new(it.pkid)))
            }
            Packet::PingReq => Some(Packet::PingResp),
            Packet::PubAck(_) | Packet::PubRec(_) | Packet::PubComp(_) => None,
            _ => return Err(()),
        })
    }

    fn pass_on(&self, message: Publish) -> Option<Packet> {
        let (number, quality) = (message.pkid, message.qos);
        self.hub.lock().publish(message);
        match quality {
            QoS::AtMostOnce => None,
            QoS::AtLeastOnce => Some(Packet::PubAck(PubAck::new(number))),
            QoS::ExactlyOnce => Some(Packet::PubRec(PubRec::new(number))),
        }
    }

    fn subscribe(&self, number: u64, subscribe: Subscribe) -> Packet {
        let mut hub = self.hub.lock();
        let codes = subscribe.filters.into_iter().map(|filter| {
            if !valid_filter(&filter.path) {
                return SubscribeReasonCode::Failure;
            }
            let quality = lower(filter.qos, QoS::AtLeastOnce);
            match hub.subscribe(number, filter.path, quality) {
                true => SubscribeReasonCode::Success(quality),
                false => SubscribeReasonCode::Failure,
            }
        });
        let codes = codes.collect();
        Packet::SubAck(SubAck::new(subscribe.pkid, codes))
    }

    /// Reads a packet; `None` at the end of the connection, and for what is no packet.
    async fn read(&mut self) -> Option<Packet> {
        loop {
            match Packet::read(&mut self.input, MOST_BYTES) {
                Ok(packet) => return Some(packet),
                Err(PacketError::InsufficientBytes(_)) => {}
                Err(_) => return None,
            }
            match self.stream.read_buf(&mut self.input).await {
                Ok(0) | Err(_) => return None,
                Ok(_) => {}
            }
        }
    }

    async fn write(&mut self, packet: Packet) -> Option<()> {
        let mut output = BytesMut::new();
        packet.write(&mut output, MOST_BYTES).ok()?;
        self.stream.write_all(&output).await.ok()
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

fn publish_of(will: LastWill) -> Publish {
    let mut publish = Publish::new(will.topic, will.qos, will.message.to_vec());
    publish.retain = will.retain;
    publish
}

/// Compares in a time that depends on the lengths alone.
fn is_same(one: &[u8], other: &[u8]) -> bool {
    let difference = one.iter().zip(other).fold(0, |sum, (one, other)| sum | (one ^ other));
    one.len() == other.len() && difference == 0
}

#[cfg(test)]
mod tests;
