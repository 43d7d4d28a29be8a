//! The connection to other hosts: zenoh, with nothing open that nobody asked for.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use regatta_plugin::FleetName;
use zenoh::pubsub::Publisher;
use zenoh::qos::{CongestionControl, Priority};
use zenoh::{Config, Session, Wait};

use crate::options::LinkArgs;

/// The error of opening a connection.
#[derive(Debug, thiserror::Error)]
pub enum LinkError {
    /// The configuration can't be used.
    #[error(
        "{}: not a configuration of zenoh ({reason}); its documentation is at zenoh.io",
        path.display()
    )]
    Config {
        /// The file.
        path: PathBuf,
        /// zenoh's reason.
        reason: String,
    },
    /// An address isn't one.
    #[error("'{address}' isn't an address; give tcp/HOST:PORT, for example tcp/127.0.0.1:7447")]
    Address {
        /// The text.
        address: String,
    },
    /// There is nobody to connect to.
    #[error("give --connect tcp/HOST:7447, the host that sends the fleet, or --listen")]
    Nowhere,
    /// zenoh can't begin.
    #[error("can't connect or listen ({reason}); is the address in use or not of this host?")]
    Open {
        /// zenoh's reason.
        reason: String,
    },
    /// zenoh can't serve a key.
    #[error("zenoh can't serve '{key}' ({reason})")]
    Declare {
        /// The key.
        key: String,
        /// zenoh's reason.
        reason: String,
    },
}

/// The place where a sender listens unless it is told otherwise.
pub const DEFAULT_LISTEN: &str = "tcp/127.0.0.1:7447";

/// Returns a key of a fleet.
pub fn key(fleet: &FleetName, name: &str) -> String {
    format!("regatta/{fleet}/{name}")
}

/// An open connection, and what users should know about it.
pub struct Link {
    /// The session.
    pub session: Session,
    /// The addresses that it listens on.
    pub listens: String,
    /// Whether peers must show that they may connect.
    pub asks_credentials: bool,
}

impl Link {
    /// Opens the session. Without options and configuration it listens on `listen`, if given, and
    /// looks for nobody.
    pub fn open(args: &LinkArgs, listen: Option<&str>) -> Result<Self, LinkError> {
        let config = configuration(args, listen)?;
        let is_set = |key| config.get_json(key).is_ok_and(|json| json != "null" && json != "false");
        let asks_credentials = is_set("transport/auth/usrpwd/dictionary_file")
            || is_set("transport/link/tls/enable_mtls");
        let listens = config.get_json("listen/endpoints").unwrap_or_default();
        let session = zenoh::open(config)
            .wait()
            .map_err(|error| LinkError::Open { reason: reason(&error) })?;
        Ok(Self { session, listens, asks_credentials })
    }
}

/// Returns zenoh's configuration: the file's, then the options. What neither gives is off: the
/// search for others on the network, and ports on all interfaces.
fn configuration(args: &LinkArgs, listen: Option<&str>) -> Result<Config, LinkError> {
    let mut config = match &args.config {
        Some(path) => Config::from_file(path)
            .map_err(|error| LinkError::Config { path: path.clone(), reason: error.to_string() })?,
        None => Config::default(),
    };
    let unset = Config::default();
    for (key, value) in [
        ("scouting/multicast/enabled", "false"),
        ("scouting/gossip/enabled", "false"),
        ("connect/retry", r#"{ period_init_ms: 200, period_max_ms: 2000 }"#),
        ("transport/link/rx/max_message_size", "536870912"),
    ] {
        if config.get_json(key).ok() == unset.get_json(key).ok() {
            set(&mut config, key, value)?;
        }
    }
    set(&mut config, "mode", "\"peer\"")?;
    if !args.connect.is_empty() {
        set_addresses(&mut config, "connect/endpoints", &args.connect)?;
    }
    let by_default: Vec<_> =
        listen.filter(|_| args.connect.is_empty()).map(str::to_owned).into_iter().collect();
    if !args.listen.is_empty() {
        set_addresses(&mut config, "listen/endpoints", &args.listen)?;
    } else if config.get_json("listen/endpoints").ok() == unset.get_json("listen/endpoints").ok() {
        set_addresses(&mut config, "listen/endpoints", &by_default)?;
    }
    Ok(config)
}

fn set(config: &mut Config, key: &str, value: &str) -> Result<(), LinkError> {
    config.insert_json5(key, value).map_err(|error| LinkError::Open { reason: reason(&error) })
}

fn set_addresses(config: &mut Config, key: &str, list: &[String]) -> Result<(), LinkError> {
    for address in list {
        if address.parse::<zenoh::config::EndPoint>().is_err() {
            return Err(LinkError::Address { address: address.clone() });
        }
    }
    let quoted: Vec<_> = list.iter().map(|address| format!("{address:?}")).collect();
    set(config, key, &format!("[{}]", quoted.join(",")))
}

/// Returns zenoh's reason without the lines of its source, which it appends.
fn reason(error: &zenoh::Error) -> String {
    let text = error.to_string();
    let end = text.find(" at /").unwrap_or(text.len());
    text[..end].replace('[', "")
}

/// Publishes on a key, while somebody listens.
pub struct Outlet {
    publisher: Publisher<'static>,
    wanted: Arc<AtomicBool>,
}

impl Outlet {
    /// Declares a key. Messages are dropped when the link is slow.
    pub fn dropping(session: &Session, key: String) -> Result<Self, LinkError> {
        Self::declare(session, key, CongestionControl::Drop, Priority::Data)
    }

    /// Declares a key. A [`put`](Self::put) waits while the link is slow.
    pub fn blocking(session: &Session, key: String) -> Result<Self, LinkError> {
        Self::declare(session, key, CongestionControl::Block, Priority::InteractiveHigh)
    }

    fn declare(
        session: &Session,
        key: String,
        congestion: CongestionControl,
        priority: Priority,
    ) -> Result<Self, LinkError> {
        let failed = |error: zenoh::Error| declare_error(&key, &error);
        let publisher = session
            .declare_publisher(key.clone())
            .congestion_control(congestion)
            .priority(priority)
            .wait()
            .map_err(failed)?;
        let wanted = Arc::new(AtomicBool::new(false));
        let flag = Arc::clone(&wanted);
        publisher
            .matching_listener()
            .callback(move |status| flag.store(status.matching(), Ordering::Relaxed))
            .background()
            .wait()
            .map_err(failed)?;
        let status = publisher.matching_status().wait().map_err(failed)?;
        wanted.fetch_or(status.matching(), Ordering::Relaxed);
        Ok(Self { publisher, wanted })
    }

    /// Whether somebody listens.
    pub fn is_wanted(&self) -> bool {
        self.wanted.load(Ordering::Relaxed)
    }

    /// Sends a message. A link that fails meanwhile loses it.
    pub fn put(&self, message: Vec<u8>) {
        let _ = self.publisher.put(message).wait();
    }
}

/// Returns the error of declaring a key.
pub fn declare_error(key: &str, error: &zenoh::Error) -> LinkError {
    LinkError::Declare { key: key.to_owned(), reason: reason(error) }
}
