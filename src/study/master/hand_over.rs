//! Hands transport orders to a master, on threads of its own: a command or a request takes time.

use std::fmt;
use std::io::Read;
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::{Duration, Instant, SystemTime};

use parking_lot::Mutex;
use regatta_vda5050::broker::PASSWORD_VARIABLE;

use super::http::{self, Url};
use super::template::{Value, filled, in_json, in_url, plain, words};
use crate::failure::Failure;

/// Orders that are handed over side by side.
const THREADS: usize = 4;
/// The longest time of a command.
const TIMEOUT: Duration = Duration::from_secs(10);
const POLL: Duration = Duration::from_millis(2);
/// The part of a command's error that is read, in bytes.
const MOST_ERROR: u64 = 4096;

/// The way in which a master gets transport orders.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Way {
    /// It makes them itself.
    Own,
    /// A command with its arguments.
    Command(Vec<String>),
    /// A request by POST.
    Post {
        /// The address.
        url: Url,
        /// The body.
        body: String,
        /// More headers.
        headers: Vec<String>,
    },
}

impl Way {
    /// Hands over by a command line.
    ///
    /// # Errors
    /// If it is no command line.
    pub fn command(command: &str) -> Result<Self, Failure> {
        words(command).map(Self::Command)
    }

    /// Hands over by a request.
    ///
    /// # Errors
    /// If the address or a header is of another form.
    pub fn post(url: &str, body: &str, headers: &[String]) -> Result<Self, Failure> {
        for header in headers {
            let is_form = header.split_once(':').is_some_and(|(name, _)| !name.trim().is_empty());
            if !is_form || header.contains(char::is_control) {
                return Err(format!("--order-header '{header}': give 'NAME: VALUE'").into());
            }
        }
        let (body, headers) = (body.to_owned(), headers.to_vec());
        Ok(Self::Post { url: Url::parse(url)?, body, headers })
    }

    /// Hands an order over, and waits until the master has it.
    fn hand_over(&self, values: &[Value<'_>], password: Option<&str>) -> Result<(), Failure> {
        match self {
            Self::Own => Ok(()),
            Self::Command(words) => {
                let words = words.iter().map(|word| filled(word, values, plain));
                run(&words.collect::<Vec<_>>(), password)
            }
            Self::Post { url, body, headers } => {
                let url = url.with_path(filled(url.path(), values, in_url));
                http::post(&url, headers, &filled(body, values, in_json))
            }
        }
    }
}

impl fmt::Display for Way {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Own => f.write_str("those that the master makes itself"),
            Self::Command(words) => write!(f, "handed over by `{}`", words.join(" ")),
            Self::Post { .. } => f.write_str("handed over by HTTP"),
        }
    }
}

fn run(words: &[String], password: Option<&str>) -> Result<(), Failure> {
    let (program, args) = words.split_first().ok_or("the command has no program")?;
    let mut command = Command::new(program);
    command.args(args).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::piped());
    command.envs(password.map(|password| (PASSWORD_VARIABLE, password)));
    let mut child = command.spawn().map_err(|error| format!("can't start {program} ({error})"))?;
    let start = Instant::now();
    let status = loop {
        if let Some(status) = child.try_wait()? {
            break status;
        }
        if start.elapsed() > TIMEOUT {
            // An error means that it has just ended by itself.
            let _ = child.kill();
            child.wait()?;
            return Err(format!("{program} took more than {} s", TIMEOUT.as_secs()).into());
        }
        std::thread::sleep(POLL);
    };
    if status.success() {
        return Ok(());
    }
    let mut error = Vec::new();
    if let Some(stderr) = child.stderr.take() {
        stderr.take(MOST_ERROR).read_to_end(&mut error)?;
    }
    let error = String::from_utf8_lossy(&error);
    let line = error.lines().rfind(|line| !line.trim().is_empty()).unwrap_or("it printed nothing");
    Err(format!("{program} failed ({status}): {line}").into())
}

/// A transport order to be handed over.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Transport {
    /// Its number in the run.
    pub number: u64,
    /// The text that the master gets as its id.
    pub id: String,
    /// The stations, or the nodes if these have none.
    pub stations: [String; 2],
    /// The nodes to pick at and to drop at.
    pub nodes: [String; 2],
}

/// The result of a hand-over.
#[derive(Debug)]
pub struct HandedOver {
    /// The transport order.
    pub transport: Transport,
    /// The time when the master had it, or the reason why it hasn't.
    pub result: Result<SystemTime, String>,
}

/// The threads that hand transport orders over. They end with the orders that they have.
#[derive(Debug)]
pub struct HandOver {
    orders: Sender<Transport>,
    results: Receiver<HandedOver>,
}

/// The words beside those of an order that templates can have: names and values.
pub type Words = Vec<(&'static str, String)>;

impl HandOver {
    /// Starts the threads. `words` are the same for all orders.
    pub fn start(way: &Way, words: &Words, password: Option<&str>) -> Self {
        let (orders, waiting) = channel::<Transport>();
        let (sender, results) = channel();
        let waiting = Arc::new(Mutex::new(waiting));
        for _ in 0..THREADS {
            let (way, words, waiting) = (way.clone(), words.clone(), Arc::clone(&waiting));
            let (password, sender) = (password.map(str::to_owned), sender.clone());
            std::thread::spawn(move || {
                while let Some(transport) = next(&waiting) {
                    let values = transport.values(&words);
                    let handed = way.hand_over(&values, password.as_deref());
                    let result =
                        handed.map(|()| SystemTime::now()).map_err(|error| error.to_string());
                    if sender.send(HandedOver { transport: transport.clone(), result }).is_err() {
                        return;
                    }
                }
            });
        }
        Self { orders, results }
    }

    /// Hands an order over, some time.
    pub fn hand_over(&self, transport: Transport) {
        // The threads wait for orders until this is dropped.
        let _ = self.orders.send(transport);
    }

    /// Takes the next result.
    pub fn take(&self) -> Option<HandedOver> {
        self.results.try_recv().ok()
    }
}

fn next(waiting: &Mutex<Receiver<Transport>>) -> Option<Transport> {
    waiting.lock().recv().ok()
}

impl Transport {
    fn values<'a>(&'a self, words: &'a Words) -> Vec<Value<'a>> {
        let Self { id, stations: [pick, drop], nodes: [pick_node, drop_node], .. } = self;
        let own: [Value<'a>; 5] = [
            ("id", id),
            ("pick", pick),
            ("drop", drop),
            ("pick-node", pick_node),
            ("drop-node", drop_node),
        ];
        own.into_iter().chain(words.iter().map(|(name, value)| (*name, &**value))).collect()
    }
}

#[cfg(test)]
mod tests {
    use std::io::{BufRead, BufReader, Write};
    use std::net::TcpListener;

    use super::*;

    fn transport() -> Transport {
        Transport {
            number: 1,
            id: "o-1".to_owned(),
            stations: ["in \"1\"", "out"].map(str::to_owned),
            nodes: ["N1", "N2"].map(str::to_owned),
        }
    }

    fn result(way: &Way) -> Result<SystemTime, String> {
        let handing = HandOver::start(way, &vec![("port", "7".to_owned())], None);
        handing.hand_over(transport());
        handing.results.recv_timeout(TIMEOUT * 2).expect("a result").result
    }

    #[test]
    fn a_command_gets_the_order_and_its_error_is_told() {
        let file = tempfile::NamedTempFile::new().expect("a file");
        let path = file.path().display();
        let way = Way::command(&format!(
            "sh -c 'echo \"$0 $1 $2\" > {path}' {{pick}} {{drop-node}} {{port}}"
        ));
        assert!(result(&way.expect("a command")).is_ok());
        assert_eq!(std::fs::read_to_string(file.path()).expect("a text"), "in \"1\" N2 7\n");
        let way = Way::command("sh -c 'echo no such station >&2; exit 3'").expect("a command");
        assert_eq!(result(&way), Err("sh failed (exit status: 3): no such station".to_owned()));
    }

    #[test]
    fn a_request_has_the_order_in_its_body_and_its_path() {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
        let port = listener.local_addr().expect("an address").port();
        let server = std::thread::spawn(move || {
            let (mut stream, _) = listener.accept().expect("a client");
            let mut reader = BufReader::new(stream.try_clone().expect("a stream"));
            let (mut head, mut length) = (Vec::new(), 0);
            loop {
                let mut line = String::new();
                reader.read_line(&mut line).expect("a line");
                let line = line.trim_end().to_owned();
                if let Some(bytes) = line.strip_prefix("Content-Length: ") {
                    length = bytes.parse().expect("a number");
                }
                if line.is_empty() {
                    break;
                }
                head.push(line);
            }
            let mut body = vec![0; length];
            reader.read_exact(&mut body).expect("a body");
            stream.write_all(b"HTTP/1.1 200 OK\r\n\r\n").expect("written");
            (head, String::from_utf8(body).expect("a text"))
        });
        let url = format!("http://127.0.0.1:{port}/orders/{{id}}");
        let headers = ["X-Key: k".to_owned()];
        let way = Way::post(&url, r#"{"from": "{pick}"}"#, &headers).expect("an address");
        assert!(result(&way).is_ok());
        let (head, body) = server.join().expect("a request");
        assert_eq!((&*head[0], &*body), ("POST /orders/o-1 HTTP/1.1", r#"{"from": "in \"1\""}"#));
        assert!(head.contains(&headers[0]), "{head:?}");
        assert!(Way::post(&url, "", &["no header".to_owned()]).is_err());
    }
}
