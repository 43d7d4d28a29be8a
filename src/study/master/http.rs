//! A request by POST over HTTP/1.1, for masters that take transport orders so.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::{TcpStream, ToSocketAddrs};
use std::time::Duration;

use crate::failure::Failure;

const PORT: u16 = 80;
/// The longest time of each step of a request.
const TIMEOUT: Duration = Duration::from_secs(10);
/// The longest line of an answer, and the part of its text that is told, in bytes.
const MOST_LINE: u64 = 16 << 10;
const MOST_TOLD: u64 = 200;

/// An address: `http://HOST[:PORT]/PATH`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Url {
    host: String,
    port: u16,
    path: String,
}

impl Url {
    /// Reads an address.
    ///
    /// # Errors
    /// If it is of another form.
    pub fn parse(text: &str) -> Result<Self, Failure> {
        let form = || -> Failure {
            format!("'{text}': give http://HOST[:PORT]/PATH; for https:// give an --order-command")
                .into()
        };
        let rest = text.strip_prefix("http://").ok_or_else(form)?;
        let (place, path) = rest.split_once('/').unwrap_or((rest, ""));
        let (host, port) = match place.rsplit_once(':').filter(|_| !place.ends_with(']')) {
            Some((host, port)) => (host, port.parse().map_err(|_| form())?),
            None => (place, PORT),
        };
        if host.is_empty() || text.contains(|c: char| c.is_whitespace() || c.is_control()) {
            return Err(form());
        }
        let host = host.trim_matches(['[', ']']).to_owned();
        Ok(Self { host, port, path: format!("/{path}") })
    }

    /// Returns the address with another path.
    pub fn with_path(&self, path: String) -> Self {
        Self { path, ..self.clone() }
    }

    /// The path.
    pub fn path(&self) -> &str {
        &self.path
    }
}

/// Sends a body with some headers, each `NAME: VALUE`, and waits for the answer.
///
/// # Errors
/// If the server can't be reached, doesn't answer, or answers with another status than 2xx.
pub fn post(url: &Url, headers: &[String], body: &str) -> Result<(), Failure> {
    let Url { host, port, path } = url;
    let mut addresses = (host.as_str(), *port).to_socket_addrs()?;
    let address = addresses.next().ok_or_else(|| format!("{host}: no such host"))?;
    let mut stream = TcpStream::connect_timeout(&address, TIMEOUT)
        .map_err(|error| format!("{host}:{port}: can't connect ({error})"))?;
    stream.set_read_timeout(Some(TIMEOUT))?;
    stream.set_write_timeout(Some(TIMEOUT))?;
    let mut request = format!(
        "POST {path} HTTP/1.1\r\nHost: {host}:{port}\r\nContent-Type: application/json\r\n\
         Content-Length: {}\r\nConnection: close\r\n",
        body.len()
    );
    for header in headers {
        request += &format!("{header}\r\n");
    }
    stream.write_all(format!("{request}\r\n{body}").as_bytes())?;
    check(&mut BufReader::new(stream)).map_err(|error| format!("{host}:{port}: {error}").into())
}

/// Reads the status of an answer.
fn check(answer: &mut impl BufRead) -> Result<(), Failure> {
    let mut line = String::new();
    answer.by_ref().take(MOST_LINE).read_line(&mut line)?;
    let status = line.split_whitespace().nth(1).unwrap_or_default().to_owned();
    if status.len() == 3 && status.starts_with('2') {
        return Ok(());
    }
    if status.is_empty() {
        return Err("no answer of HTTP".into());
    }
    loop {
        line.clear();
        if answer.by_ref().take(MOST_LINE).read_line(&mut line)? == 0 || line.trim().is_empty() {
            break;
        }
    }
    let mut text = Vec::new();
    answer.by_ref().take(MOST_TOLD).read_to_end(&mut text)?;
    let text = String::from_utf8_lossy(&text);
    Err(format!("status {status}: {}", text.lines().next().unwrap_or_default()).into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_are_read() {
        let url = Url::parse("http://fleet:8080/orders/{id}").expect("an address");
        assert_eq!((&*url.host, url.port, url.path()), ("fleet", 8080, "/orders/{id}"));
        let url = Url::parse("http://[::1]").expect("an address");
        assert_eq!((&*url.host, url.port, url.path()), ("::1", 80, "/"));
        for text in ["https://fleet/", "fleet:80", "http://", "http://a:b/", "http://a/b c"] {
            assert!(Url::parse(text).is_err(), "{text}");
        }
    }

    #[test]
    fn only_an_answer_of_success_is_one() {
        let told = |text: &str| check(&mut text.as_bytes()).map_err(|error| error.to_string());
        assert_eq!(told("HTTP/1.1 201 Created\r\n\r\n"), Ok(()));
        let refused = "HTTP/1.1 400 Bad Request\r\nA: b\r\n\r\nno such station\nmore";
        assert_eq!(told(refused), Err("status 400: no such station".to_owned()));
        assert_eq!(told(""), Err("no answer of HTTP".to_owned()));
    }
}
