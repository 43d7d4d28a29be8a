//! A client of the web API, for `regatta orders` and for programs of users.

use std::fmt;
use std::io::{Read, Write};
use std::net::{TcpStream, ToSocketAddrs};
use std::path::PathBuf;
use std::time::Duration;

use regatta_kit::private;
use regatta_kit::server::{is_own_host, socket_path};
use regatta_plugin::FleetName;
use serde_json::Value;

use super::web::SERVICE;

/// The longest time without an answer.
const TIMEOUT: Duration = Duration::from_secs(30);

/// The error of a request.
#[derive(Debug, thiserror::Error)]
pub enum ClientError {
    /// The address isn't of the form that this client knows.
    #[error(
        "invalid address `{}` of a fleet manager; give one such as http://127.0.0.1:55200",
        .0.escape_debug()
    )]
    Url(String),
    /// No manager answers.
    #[error(
        "no fleet manager answers on {address} ({reason}); start one, or choose it with --fleet \
         or --url"
    )]
    Connect {
        /// The address.
        address: String,
        /// The reason.
        reason: std::io::Error,
    },
    /// The answer is not one of the web API.
    #[error("the server on {0} isn't a fleet manager")]
    Answer(String),
    /// The manager has refused the request.
    #[error("{reason}")]
    Refused {
        /// The HTTP status.
        status: u16,
        /// The reason that it gave.
        reason: String,
    },
}

/// The address of a running manager's web API, and the token if it needs one.
#[derive(Clone, Debug)]
pub struct Client {
    address: Address,
    token: Option<String>,
}

/// The place where a manager serves.
#[derive(Clone, Debug)]
enum Address {
    Socket(PathBuf),
    Tcp(String),
}

impl fmt::Display for Address {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Socket(path) => write!(formatter, "{}", path.display()),
            Self::Tcp(address) => formatter.write_str(address),
        }
    }
}

/// The address of a manager on systems without Unix sockets.
const DEFAULT_URL: &str = "http://127.0.0.1:55200";

impl Client {
    /// Makes a client of the manager of a fleet of this user, at its Unix socket.
    ///
    /// # Errors
    /// [`ClientError::Connect`] if this user has no directory for sockets.
    pub fn of_fleet(fleet: &FleetName) -> Result<Self, ClientError> {
        if !cfg!(unix) {
            return Self::new(DEFAULT_URL, None);
        }
        let socket = socket_path(fleet, SERVICE).map_err(|reason| ClientError::Connect {
            address: format!("the socket of fleet '{fleet}'"),
            reason,
        })?;
        Ok(Self { address: Address::Socket(socket), token: None })
    }

    /// Makes a client of an address such as `http://127.0.0.1:55200` or `127.0.0.1:55200`. On
    /// loopback, the token is that of this user unless another is given.
    ///
    /// # Errors
    /// [`ClientError::Url`] if the address has another form.
    pub fn new(url: &str, token: Option<String>) -> Result<Self, ClientError> {
        let address = url.strip_prefix("http://").unwrap_or(url).trim_end_matches('/');
        let port = address.rsplit_once(':').and_then(|(_, port)| port.parse::<u16>().ok());
        let is_plain = address.chars().all(|c| c.is_ascii_alphanumeric() || ".:-[]".contains(c));
        let mut token_bytes = token.iter().flat_map(|token| token.bytes());
        if port.is_none() || !is_plain || !token_bytes.all(|byte| byte.is_ascii_graphic()) {
            return Err(ClientError::Url(url.to_owned()));
        }
        let token = token.or_else(|| is_own_host(address).then(private::token)?.ok());
        Ok(Self { address: Address::Tcp(address.to_owned()), token })
    }

    /// Gets the value at a path.
    ///
    /// # Errors
    /// [`ClientError`] if nobody answers, or the answer is an error.
    pub fn get(&self, path: &str) -> Result<Value, ClientError> {
        self.request("GET", path, "")
    }

    /// Posts a value to a path.
    ///
    /// # Errors
    /// [`ClientError`] if nobody answers, or the answer is an error.
    pub fn post(&self, path: &str, body: &Value) -> Result<Value, ClientError> {
        self.request("POST", path, &body.to_string())
    }

    /// The path of an order.
    pub fn order_path(name: &str) -> String {
        format!("/v1/transportOrders/{}", Self::escaped(name))
    }

    /// A text, escaped for paths and queries.
    pub fn escaped(text: &str) -> String {
        let mut escaped = String::with_capacity(text.len());
        for byte in text.bytes() {
            match byte {
                b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'-' | b'_' | b'.' | b'~' => {
                    escaped.push(byte.into());
                }
                _ => escaped.push_str(&format!("%{byte:02X}")),
            }
        }
        escaped
    }

    fn request(&self, method: &str, path: &str, body: &str) -> Result<Value, ClientError> {
        let authorization =
            self.token.iter().map(|token| format!("Authorization: Bearer {token}\r\n"));
        // HTTP 1.0: the answer ends with the connection.
        let request = format!(
            "{method} {path} HTTP/1.0\r\nHost: {}\r\nContent-Type: application/json\r\n\
             Content-Length: {}\r\n{}\r\n{body}",
            self.address.host(),
            body.len(),
            authorization.collect::<String>(),
        );
        let response = self
            .exchange(&request)
            .map_err(|reason| ClientError::Connect { address: self.address.to_string(), reason })?;
        self.answer(&String::from_utf8_lossy(&response))
    }

    fn exchange(&self, request: &str) -> std::io::Result<Vec<u8>> {
        match &self.address {
            Address::Tcp(address) => {
                let address = address.to_socket_addrs()?.next();
                let address =
                    address.ok_or_else(|| std::io::Error::other("the host name has no address"))?;
                let stream = TcpStream::connect_timeout(&address, TIMEOUT)?;
                stream.set_read_timeout(Some(TIMEOUT))?;
                stream.set_write_timeout(Some(TIMEOUT))?;
                exchange(stream, request)
            }
            #[cfg(unix)]
            Address::Socket(path) => {
                let stream = std::os::unix::net::UnixStream::connect(path)?;
                stream.set_read_timeout(Some(TIMEOUT))?;
                stream.set_write_timeout(Some(TIMEOUT))?;
                exchange(stream, request)
            }
            #[cfg(not(unix))]
            Address::Socket(_) => Err(std::io::ErrorKind::Unsupported.into()),
        }
    }

    fn answer(&self, response: &str) -> Result<Value, ClientError> {
        let (status, value) =
            parse(response).ok_or_else(|| ClientError::Answer(self.address.to_string()))?;
        match value.get("error").and_then(Value::as_str) {
            _ if (200..300).contains(&status) => Ok(value),
            Some(reason) => Err(ClientError::Refused { status, reason: reason.to_owned() }),
            None => Err(ClientError::Answer(self.address.to_string())),
        }
    }
}

impl Address {
    /// The host of requests.
    fn host(&self) -> &str {
        match self {
            Self::Socket(_) => "localhost",
            Self::Tcp(address) => address,
        }
    }
}

fn exchange(mut stream: impl Read + Write, request: &str) -> std::io::Result<Vec<u8>> {
    // A server may refuse a request before it has read all of it: the answer has the reason.
    let sent = stream.write_all(request.as_bytes());
    let mut response = Vec::new();
    let received = stream.read_to_end(&mut response);
    if response.is_empty() {
        sent?;
        received?;
    }
    Ok(response)
}

/// Returns the status and the body of a response.
fn parse(response: &str) -> Option<(u16, Value)> {
    let (head, body) = response.split_once("\r\n\r\n")?;
    Some((head.split(' ').nth(1)?.parse().ok()?, serde_json::from_str(body).ok()?))
}
