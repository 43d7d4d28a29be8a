use std::io::{Read, Write};
use std::net::{SocketAddr, TcpStream};

use regatta_kit::server::MAX_HEAD_BYTES;

use super::*;

struct Fixed(String);

impl PageSource for Fixed {
    fn metrics(&self, format: Format) -> String {
        match format {
            Format::Prometheus => self.0.clone(),
            Format::OpenMetrics => format!("{}# EOF\n", self.0),
        }
    }
}

fn server(page: &str) -> Server {
    let access = Access::with_token(Some(TOKEN.to_owned()));
    start(loopback(0), access, Arc::new(Fixed(page.to_owned()))).expect("a port")
}

const TOKEN: &str = "secret-token";
const GET: &[u8] = b"GET /metrics HTTP/1.1\r\nHost: localhost\r\n\
                     Authorization: Bearer secret-token\r\n\r\n";

fn loopback(port: u16) -> Place {
    Place::Tcp(([127, 0, 0, 1], port).into())
}

fn address(server: &Server) -> SocketAddr {
    server.address().expect("an address")
}

fn connect(server: &Server) -> TcpStream {
    TcpStream::connect(address(server)).expect("connected")
}

/// Sends a request and returns the whole response.
fn request(server: &Server, request: &[u8]) -> Vec<u8> {
    let mut stream = connect(server);
    stream.write_all(request).expect("sent");
    let mut response = Vec::new();
    stream.read_to_end(&mut response).expect("a response");
    response
}

fn text(response: &[u8]) -> String {
    String::from_utf8_lossy(response).into_owned()
}

/// Requests a page with further headers. Returns the head in lower case, and the body.
fn page(server: &Server, path: &str, headers: &str) -> (String, Vec<u8>) {
    let ask = format!(
        "GET {path} HTTP/1.1\r\nHost: localhost\r\nAuthorization: Bearer secret-token\r\nConnection: close\r\n{headers}\r\n"
    );
    let mut response = request(server, ask.as_bytes());
    let end = response.windows(4).position(|end| end == b"\r\n\r\n").expect("a head") + 4;
    let body = response.split_off(end);
    (text(&response).to_lowercase(), body)
}

#[test]
fn pages_are_served_with_their_length() {
    let server = server("regatta_up 1\n");
    let (head, body) = page(&server, "/metrics?x=1", "");
    assert!(
        head.starts_with("http/1.1 200 ok\r\n") && head.contains("content-length: 13\r\n"),
        "{head}"
    );
    assert!(head.contains("text/plain; version=0.0.4") && body == b"regatta_up 1\n", "{head}");
    let head = text(&request(
        &server,
        b"HEAD /metrics HTTP/1.0\r\nAuthorization: Bearer secret-token\r\n\r\n",
    ))
    .to_lowercase();
    assert!(head.contains("content-length: 13\r\n") && head.ends_with("\r\n\r\n"), "{head}");
    assert!(page(&server, "/", "").1.ends_with(b"/metrics.\n"));
    assert!(page(&server, "/favicon.ico", "").0.starts_with("http/1.1 404"));
}

#[test]
fn several_requests_of_a_connection_are_answered() {
    let server = server("regatta_up 1\n");
    let mut stream = connect(&server);
    for _ in 0..3 {
        stream.write_all(GET).expect("sent");
        let mut response = Vec::new();
        while !response.ends_with(b"regatta_up 1\n") {
            let mut byte = [0];
            stream.read_exact(&mut byte).expect("a response");
            response.push(byte[0]);
        }
    }
}

#[test]
fn the_client_chooses_the_format_and_the_encoding() {
    let metrics = "regatta_up 1\n".repeat(100);
    let server = server(&metrics);
    let (head, body) =
        page(&server, "/metrics", "Accept: application/openmetrics-text; version=1.0.0\r\n");
    assert!(
        head.contains(
            "content-type: application/openmetrics-text; version=1.0.0; charset=utf-8\r\n"
        ),
        "{head}"
    );
    assert!(body.ends_with(b"1\n# EOF\n"));
    for (accepted, is_compressed) in
        [("gzip", true), ("deflate, gzip;q=0.5", true), ("gzip;q=0", false), ("br", false)]
    {
        let (head, body) = page(&server, "/metrics", &format!("Accept-Encoding: {accepted}\r\n"));
        assert_eq!(
            head.contains("content-encoding: gzip\r\n"),
            is_compressed,
            "{accepted}: {head}"
        );
        let body = if is_compressed { unzip(&unchunk(&body)) } else { text(&body) };
        assert!(body == metrics, "{accepted}: {body}");
    }
}

/// Joins the chunks of a body.
fn unchunk(mut body: &[u8]) -> Vec<u8> {
    let mut whole = Vec::new();
    loop {
        let end = body.windows(2).position(|end| end == b"\r\n").expect("a length");
        let length = usize::from_str_radix(&text(&body[..end]), 16).expect("a number");
        if length == 0 {
            return whole;
        }
        whole.extend_from_slice(&body[end + 2..][..length]);
        body = &body[end + 2 + length + 2..];
    }
}

fn unzip(bytes: &[u8]) -> String {
    let mut text = String::new();
    flate2::read::GzDecoder::new(bytes).read_to_string(&mut text).expect("valid gzip");
    text
}

#[test]
fn invalid_requests_are_rejected_and_the_next_one_is_served() {
    let server = server("page\n");
    assert!(text(&request(&server, b"\x16\x03\x01\x02\x00\r\n\r\n")).starts_with("HTTP/1.1 400"));
    let delete = b"DELETE /metrics HTTP/1.1\r\nAuthorization: Bearer secret-token\r\nConnection: close\r\n\r\n";
    assert!(text(&request(&server, delete)).starts_with("HTTP/1.1 405"));
    let mut endless = connect(&server);
    // The server may close the connection before it has read everything.
    let _ = endless.write_all(
        &[b"GET /metrics HTTP/1.1\r\nX: ".to_vec(), vec![b'x'; 2 * MAX_HEAD_BYTES]].concat(),
    );
    let mut response = Vec::new();
    let _ = endless.read_to_end(&mut response);
    assert!(
        response.is_empty() || text(&response).starts_with("HTTP/1.1 431"),
        "{}",
        text(&response)
    );
    assert_eq!(page(&server, "/metrics", "").1, b"page\n");
}

#[test]
fn clients_that_hang_do_not_hurt_others() {
    let server = server(&"x".repeat(8 << 20));
    let mut hanging = Vec::new();
    for index in 0..2 * LIMITS.max_connections {
        let mut stream = connect(&server);
        let start: &[u8] = match index % 3 {
            0 => b"",
            1 => b"GET /met",
            _ => GET,
        };
        // The oldest ones are closed by and by.
        let _ = stream.write_all(start);
        hanging.push(stream);
        if index % 64 == 0 {
            assert!(page(&server, "/", "").0.starts_with("http/1.1 200"), "{index}");
        }
    }
    assert!(page(&server, "/metrics", "").1.len() == 8 << 20);
    drop(hanging);
}

#[test]
fn a_response_that_is_under_way_is_finished_before_the_end() {
    let server = server(&"x".repeat(8 << 20));
    let mut stream = connect(&server);
    stream.write_all(GET).expect("sent");
    let mut start = [0; 1000];
    stream.read_exact(&mut start).expect("the start of a response");
    let reader = std::thread::spawn(move || {
        let mut rest = Vec::new();
        stream.read_to_end(&mut rest).expect("a response");
        rest.len()
    });
    let (idle, address) = (connect(&server), address(&server));
    drop(server);
    assert!(reader.join().expect("no panic") + start.len() > 8 << 20);
    assert!(TcpStream::connect(address).is_err(), "it doesn't listen any more");
    drop(idle);
}

#[test]
fn a_port_in_use_is_reported_with_advice() {
    let server = server("page\n");
    let pages = Arc::new(Fixed(String::new()));
    let taken = address(&server);
    let error = start(loopback(taken.port()), Access::default(), pages).expect_err("taken");
    let error = error.to_string();
    assert!(error.contains(&taken.to_string()) && error.contains("--listen"), "{error}");
    assert!(!error.contains('\n'), "{error}");
}

#[test]
fn others_than_its_user_and_those_with_the_token_are_refused() {
    let server = server("regatta_up 1\n");
    for (headers, status) in [
        ("Host: localhost\r\n", "401"),
        ("Authorization: bearer secret-token\r\nHost: localhost\r\n", "200"),
        ("Authorization: Bearer secret-token\r\nHost: evil.example\r\n", "403"),
    ] {
        let ask = format!("GET /metrics HTTP/1.0\r\n{headers}\r\n");
        let answer = text(&request(&server, ask.as_bytes()));
        assert_eq!(answer.split(' ').nth(1), Some(status), "{headers}: {answer}");
    }
}

#[cfg(unix)]
#[test]
fn a_socket_serves_its_user_without_a_token() {
    use std::os::unix::fs::PermissionsExt;

    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("metrics");
    let pages = Arc::new(Fixed("regatta_up 1\n".to_owned()));
    let place = Place::Socket(path.clone());
    let server = start(place.clone(), Access::default(), pages.clone()).expect("a socket");
    assert_eq!(path.metadata().expect("a socket").permissions().mode() & 0o777, 0o600);
    let mut stream = std::os::unix::net::UnixStream::connect(&path).expect("connected");
    stream.write_all(b"GET /metrics HTTP/1.0\r\n\r\n").expect("sent");
    let mut answer = String::new();
    stream.read_to_string(&mut answer).expect("a response");
    assert!(answer.starts_with("HTTP/1.0 200") && answer.ends_with("regatta_up 1\n"), "{answer}");
    start(place.clone(), Access::default(), pages.clone()).expect_err("in use");
    drop(server);
    assert!(!path.exists(), "nothing is left");
    // A killed process leaves its socket.
    drop(std::os::unix::net::UnixListener::bind(&path).expect("a socket"));
    start(place, Access::default(), pages).expect("it takes the place of the dead one");
}
