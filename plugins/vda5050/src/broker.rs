//! Connections to an MQTT broker (3.1.1). This is the only file that knows the MQTT client.
//!
//! All connections live on one thread. They are made again when they are lost; what is published
//! meanwhile is left out, as quality of service 0 has it.

mod interference;

use core::fmt;
use core::str::FromStr;
use std::cell::RefCell;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant, SystemTime};

use rumqttc::{AsyncClient, Event, EventLoop, LastWill, MqttOptions, Outgoing, Packet};
use rumqttc::{PublishOptions, QoS};
use tokio::runtime::{Builder, Handle};
use tokio::sync::mpsc::{UnboundedReceiver, UnboundedSender, unbounded_channel};
use tokio::sync::{OwnedSemaphorePermit, Semaphore, oneshot};

use crate::disturb::Disturbances;
use crate::message::Topic;
use interference::Interference;

/// The port of brokers.
const PORT: u16 = 1883;
/// The time after which a broker counts as gone, in seconds.
const KEEP_ALIVE_SECS: u16 = 15;
/// The time before a lost connection is made again; connections are spread over as much again.
const RETRY: Duration = Duration::from_millis(500);
/// The time between the first connects of two connections.
const STAGGER: Duration = Duration::from_micros(200);
/// The largest message, in bytes.
const MOST_BYTES: usize = 16 << 20;
/// Messages that a connection may have to send.
const OUTGOING: usize = 256;
/// Messages that may wait to be taken, and their bytes; more are left out.
const INCOMING: usize = 65_536;
const INCOMING_BYTES: usize = 256 << 20;
/// The time that the last messages may take.
const FAREWELL: Duration = Duration::from_secs(3);

/// The address of a broker: `mqtt://[USER@]HOST[:PORT]`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BrokerUrl {
    /// The name of the user.
    pub user: Option<String>,
    /// The name or the address of the host.
    pub host: String,
    /// The port.
    pub port: u16,
}

/// The error of an address.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum UrlError {
    /// It is of another form.
    #[error("give mqtt://[USER@]HOST[:PORT], for example mqtt://127.0.0.1:1883")]
    Form,
    /// Others could read the password in the list of processes.
    #[error(
        "a password in an address can be read by others: give it by --password-file or the \
         environment variable {PASSWORD_VARIABLE}"
    )]
    Password,
    /// Connections aren't encrypted.
    #[error("mqtts:// isn't supported; connect over mqtt:// to a broker or a tunnel of this host")]
    Encrypted,
}

/// The environment variable with the password of the broker's user.
pub const PASSWORD_VARIABLE: &str = "REGATTA_MQTT_PASSWORD";
/// The largest file with a password, in bytes.
const MOST_PASSWORD_BYTES: u64 = 4096;

/// The error of reading a password from a file.
#[derive(Debug, thiserror::Error)]
#[error("can't read the password in {path}: {reason}")]
pub struct PasswordError {
    /// The file.
    path: PathBuf,
    /// The reason.
    reason: io::Error,
}

/// Returns the password of the broker's user: that in a file, without the end of its line, or else
/// that of the environment variable `REGATTA_MQTT_PASSWORD`, if it is set.
///
/// # Errors
/// [`PasswordError`] if the file can't be read, or is too large.
pub fn password(file: Option<&Path>) -> Result<Option<String>, PasswordError> {
    let Some(path) = file else { return Ok(std::env::var(PASSWORD_VARIABLE).ok()) };
    let text = regatta_base::file::read_text(path, MOST_PASSWORD_BYTES)
        .map_err(|reason| PasswordError { path: path.to_owned(), reason })?;
    Ok(Some(text.trim_end_matches(['\r', '\n']).to_owned()))
}

impl FromStr for BrokerUrl {
    type Err = UrlError;

    fn from_str(text: &str) -> Result<Self, UrlError> {
        if text.starts_with("mqtts://") {
            return Err(UrlError::Encrypted);
        }
        let rest = text.strip_prefix("mqtt://").ok_or(UrlError::Form)?;
        let (user, place) = match rest.rsplit_once('@') {
            Some((user, _)) if user.contains(':') => return Err(UrlError::Password),
            Some((user, place)) => (Some(user.to_owned()), place),
            None => (None, rest),
        };
        let place = place.trim_end_matches('/');
        let is_bare_address = place.ends_with(']');
        let (host, port) = match place.rsplit_once(':').filter(|_| !is_bare_address) {
            Some((host, port)) => (host, port.parse().map_err(|_| UrlError::Form)?),
            None => (place, PORT),
        };
        let host = host.trim_start_matches('[').trim_end_matches(']').to_owned();
        let is_form = !host.is_empty() && !host.contains('/') && user.as_deref() != Some("");
        if is_form { Ok(Self { user, host, port }) } else { Err(UrlError::Form) }
    }
}

impl BrokerUrl {
    /// The address with its user, as it is read.
    pub fn to_text(&self) -> String {
        let url = self.to_string();
        match &self.user {
            Some(user) => url.replacen("mqtt://", &format!("mqtt://{user}@"), 1),
            None => url,
        }
    }
}

/// Shows the address without its user.
impl fmt::Display for BrokerUrl {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.host.contains(':') {
            true => write!(f, "mqtt://[{}]:{}", self.host, self.port),
            false => write!(f, "mqtt://{}:{}", self.host, self.port),
        }
    }
}

/// A message that is kept by the broker for those who come later, or not.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Delivery {
    /// At most once, to those who are there.
    Now,
    /// At least once, and kept.
    Kept,
    /// At most once, and kept.
    NowAndKept,
}

impl Delivery {
    fn options(self) -> PublishOptions {
        match self {
            Self::Now => PublishOptions::new(QoS::AtMostOnce),
            Self::Kept => PublishOptions::new(QoS::AtLeastOnce).retained(),
            Self::NowAndKept => PublishOptions::new(QoS::AtMostOnce).retained(),
        }
    }
}

/// A connection to be made.
#[derive(Clone, Debug, Default)]
pub struct Session {
    /// Tells the connection from others of the broker.
    pub client_id: String,
    /// The topic and the message that the broker publishes if the connection is lost.
    pub will: Option<(String, Vec<u8>)>,
    /// The topics to listen to.
    pub topics: Vec<String>,
}

/// News from a broker.
#[derive(Clone, Debug)]
pub enum Incoming {
    /// A connection is there, also again.
    Connected {
        /// The number of the connection.
        link: usize,
    },
    /// A connection is lost, or couldn't be made.
    Lost {
        /// The number of the connection.
        link: usize,
        /// The reason.
        reason: String,
    },
    /// A message.
    Message {
        /// Its topic.
        topic: String,
        /// Its content.
        payload: Vec<u8>,
        /// The time when it came, before it waited to be taken.
        time: SystemTime,
    },
}

/// The connections to a broker.
#[derive(Debug)]
pub struct Broker {
    url: BrokerUrl,
    password: Option<String>,
    runtime: Handle,
    links: Vec<Link>,
    /// The bytes that may wait.
    room: Arc<Semaphore>,
    sender: SyncSender<Waiting>,
    receiver: Receiver<Waiting>,
    incoming: RefCell<Option<Interference<Incoming>>>,
    outgoing: RefCell<Option<Interference<Letter>>>,
    live: Arc<AtomicUsize>,
    end: Option<oneshot::Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

/// News that wait, with the part of the room for them.
type Waiting = (Incoming, OwnedSemaphorePermit);

/// A message on its way to the broker.
#[derive(Clone, Debug)]
struct Letter {
    link: usize,
    topic: String,
    message: Vec<u8>,
}

/// A connection.
#[derive(Debug)]
struct Link {
    client: AsyncClient,
    is_up: Arc<AtomicBool>,
    /// The times for which it is to be lost.
    cuts: UnboundedSender<Duration>,
}

impl Broker {
    /// Starts the thread of the connections.
    ///
    /// # Errors
    /// If the system gives no thread.
    pub fn start(url: BrokerUrl, password: Option<String>) -> std::io::Result<Self> {
        let runtime = Builder::new_current_thread().enable_all().build()?;
        let handle = runtime.handle().clone();
        let (end, ended) = oneshot::channel();
        let thread = std::thread::Builder::new().name("mqtt".to_owned()).spawn(move || {
            // An error means that the sender is gone: that is the end, too.
            let _ = runtime.block_on(ended);
        })?;
        let (sender, receiver) = sync_channel(INCOMING);
        Ok(Self {
            url,
            password,
            runtime: handle,
            links: Vec::new(),
            room: Arc::new(Semaphore::new(INCOMING_BYTES)),
            sender,
            receiver,
            incoming: RefCell::default(),
            outgoing: RefCell::default(),
            live: Arc::default(),
            end: Some(end),
            thread: Some(thread),
        })
    }

    /// Disturbs the transmission of messages that are sent at most once.
    pub fn disturbed(self, disturbances: &Disturbances) -> Self {
        Self {
            incoming: RefCell::new(Interference::new(disturbances, 0)),
            outgoing: RefCell::new(Interference::new(disturbances, 1)),
            ..self
        }
    }

    /// Makes a connection, and makes it again whenever it is lost. Returns its number.
    pub fn connect(&mut self, session: &Session) -> usize {
        let link = self.links.len();
        let options = self.options(session);
        let (client, events) = AsyncClient::builder(options).capacity(OUTGOING).build();
        let is_up = Arc::new(AtomicBool::new(false));
        let (cuts, to_cut) = unbounded_channel();
        self.links.push(Link { client: client.clone(), is_up: Arc::clone(&is_up), cuts });
        let task = Task {
            link,
            client,
            events,
            is_up,
            cuts: to_cut,
            topics: session.topics.clone(),
            room: Arc::clone(&self.room),
            sender: self.sender.clone(),
        };
        let live = Arc::clone(&self.live);
        live.fetch_add(1, Ordering::Relaxed);
        self.runtime.spawn(async move {
            tokio::time::sleep(STAGGER * link as u32).await;
            task.run().await;
            live.fetch_sub(1, Ordering::Relaxed);
        });
        link
    }

    fn options(&self, session: &Session) -> MqttOptions {
        let broker = (self.url.host.clone(), self.url.port);
        let mut options = MqttOptions::new(session.client_id.clone(), broker);
        options.set_keep_alive(KEEP_ALIVE_SECS).set_max_packet_size(MOST_BYTES, MOST_BYTES);
        if let Some(user) = &self.url.user {
            let password = self.password.clone().unwrap_or_default();
            options.set_credentials(user.clone(), password.into_bytes());
        }
        if let Some((topic, message)) = &session.will {
            let will = LastWill::new(topic.clone(), message.clone(), QoS::AtLeastOnce, true);
            options.set_last_will(will);
        }
        options
    }

    /// Whether a connection is there.
    pub fn is_up(&self, link: usize) -> bool {
        self.links.get(link).is_some_and(|link| link.is_up.load(Ordering::Relaxed))
    }

    /// Publishes a message on a connection, if it is there.
    pub fn publish(&self, link: usize, topic: &str, message: Vec<u8>, delivery: Delivery) {
        let mut outgoing = self.outgoing.borrow_mut();
        match (&mut *outgoing, delivery) {
            (Some(line), Delivery::Now) if self.is_up(link) => {
                let letter = Letter { link, topic: topic.to_owned(), message };
                line.send(topic, letter, Instant::now());
            }
            _ => self.post(Letter { link, topic: topic.to_owned(), message }, delivery),
        }
    }

    fn post(&self, letter: Letter, delivery: Delivery) {
        if let Some(link) = self.links.get(letter.link).filter(|_| self.is_up(letter.link)) {
            // A queue that is full leaves it out, too.
            let _ = link.client.try_publish(letter.topic, letter.message, delivery.options());
        }
    }

    /// Takes what has come next. Messages that were delayed are sent, too.
    pub fn take(&self) -> Option<Incoming> {
        if let Some(line) = &mut *self.outgoing.borrow_mut() {
            while let Some(letter) = line.take(Instant::now()) {
                self.post(letter, Delivery::Now);
            }
        }
        let mut incoming = self.incoming.borrow_mut();
        let Some(line) = &mut *incoming else { return self.next() };
        while let Some(news) = self.next() {
            match &news {
                Incoming::Message { topic, .. } => line.send(topic, news.clone(), Instant::now()),
                Incoming::Connected { .. } | Incoming::Lost { .. } => return Some(news),
            }
        }
        line.take(Instant::now())
    }

    fn next(&self) -> Option<Incoming> {
        let (incoming, _) = self.receiver.try_recv().ok()?;
        Some(incoming)
    }

    /// Loses a connection for some time, as a network does.
    pub fn cut(&self, link: usize, time: Duration) {
        if let Some(link) = self.links.get(link) {
            // A connection that has ended can't be lost.
            let _ = link.cuts.send(time);
        }
    }

    /// Ends a connection after what was published on it.
    pub fn disconnect(&self, link: usize) {
        if let Some(link) = self.links.get(link) {
            // A queue that is full belongs to a connection without a broker.
            let _ = link.client.try_disconnect();
        }
    }

    /// Ends all connections. They may send what was published before.
    pub fn end(mut self) {
        (0..self.links.len()).for_each(|link| self.disconnect(link));
        let start = Instant::now();
        while self.live.load(Ordering::Relaxed) > 0 && start.elapsed() < FAREWELL {
            std::thread::sleep(Duration::from_millis(5));
        }
        drop(self.end.take());
        if let Some(thread) = self.thread.take() {
            // A panic of the thread has been printed.
            let _ = thread.join();
        }
    }
}

/// The life of a connection.
struct Task {
    link: usize,
    client: AsyncClient,
    events: EventLoop,
    is_up: Arc<AtomicBool>,
    cuts: UnboundedReceiver<Duration>,
    topics: Vec<String>,
    room: Arc<Semaphore>,
    sender: SyncSender<Waiting>,
}

impl Task {
    async fn run(mut self) {
        loop {
            let event = tokio::select! {
                event = self.events.poll() => event,
                Some(time) = self.cuts.recv() => {
                    self.is_up.store(false, Ordering::Relaxed);
                    self.events.clean();
                    tokio::time::sleep(time).await;
                    continue;
                }
            };
            match event {
                Ok(Event::Incoming(Packet::ConnAck(_))) => self.begin(),
                Ok(Event::Incoming(Packet::Publish(message))) => {
                    let topic = String::from_utf8_lossy(&message.topic).into_owned();
                    let (payload, time) = (message.payload.to_vec(), SystemTime::now());
                    self.tell(Incoming::Message { topic, payload, time });
                }
                Ok(Event::Outgoing(Outgoing::Disconnect)) => return,
                Ok(_) => {}
                Err(error) => {
                    self.is_up.store(false, Ordering::Relaxed);
                    self.tell(Incoming::Lost { link: self.link, reason: error.to_string() });
                    tokio::time::sleep(RETRY + STAGGER * (self.link as u32 % 2_500)).await;
                }
            }
        }
    }

    fn begin(&self) {
        for topic in &self.topics {
            // The queue has room: nothing was put into it while there was no connection.
            let _ = self.client.try_subscribe(topic.as_str(), quality(topic));
        }
        self.is_up.store(true, Ordering::Relaxed);
        self.tell(Incoming::Connected { link: self.link });
    }

    /// Hands over what has come. What can't wait any longer is left out.
    fn tell(&self, incoming: Incoming) {
        let bytes = match &incoming {
            Incoming::Message { topic, payload, .. } => topic.len() + payload.len(),
            Incoming::Connected { .. } | Incoming::Lost { .. } => 0,
        };
        let bytes = u32::try_from(bytes).unwrap_or(u32::MAX);
        if let Ok(share) = Arc::clone(&self.room).try_acquire_many_owned(bytes) {
            let _ = self.sender.try_send((incoming, share));
        }
    }
}

/// The quality of service with which a topic is heard: that with which it is sent.
fn quality(topic: &str) -> QoS {
    let is_kept = topic.ends_with(&format!("/{}", Topic::Connection.name()));
    if is_kept { QoS::AtLeastOnce } else { QoS::AtMostOnce }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_are_read() {
        for (text, shown, user) in [
            ("mqtt://broker", "mqtt://broker:1883", None),
            ("mqtt://me@10.0.0.7:18830/", "mqtt://10.0.0.7:18830", Some("me")),
            ("mqtt://[::1]:1884", "mqtt://[::1]:1884", None),
            ("mqtt://[::1]", "mqtt://[::1]:1883", None),
        ] {
            let url: BrokerUrl = text.parse().expect(text);
            assert_eq!((url.to_string().as_str(), url.user.as_deref()), (shown, user));
            assert_eq!(url.to_text().parse(), Ok(url));
        }
    }

    #[test]
    fn other_addresses_are_refused_with_the_remedy() {
        for (text, error) in [
            ("broker:1883", UrlError::Form),
            ("mqtt://", UrlError::Form),
            ("mqtt://@host", UrlError::Form),
            ("mqtt://host:99999", UrlError::Form),
            ("mqtt://host/x", UrlError::Form),
            ("mqtt://me:secret@host", UrlError::Password),
            ("mqtts://host", UrlError::Encrypted),
        ] {
            assert_eq!(text.parse::<BrokerUrl>(), Err(error), "{text}");
        }
    }
}
