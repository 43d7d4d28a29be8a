use super::*;

struct Fixed(String);

impl PageSource for Fixed {
    fn metrics(&self) -> String {
        self.0.clone()
    }
}

fn server(page: &str) -> SocketAddr {
    let loopback = SocketAddr::from(([127, 0, 0, 1], 0));
    start(loopback, Arc::new(Fixed(page.to_owned()))).expect("a port")
}

fn connect(address: SocketAddr) -> TcpStream {
    TcpStream::connect(address).expect("connected")
}

/// Sends a request and returns the whole response.
fn request(address: SocketAddr, request: &[u8]) -> String {
    let mut stream = connect(address);
    stream.write_all(request).expect("sent");
    let mut response = String::new();
    stream.read_to_string(&mut response).expect("an response");
    response
}

fn scrape(address: SocketAddr) -> String {
    request(address, b"GET /metrics HTTP/1.1\r\nHost: here\r\n\r\n")
}

#[test]
fn pages_are_served_with_their_length() {
    let address = server("regatta_up 1\n");
    let response = scrape(address);
    assert!(response.starts_with("HTTP/1.1 200 OK\r\n") && response.contains("Content-Length: 13\r\n"), "{response}");
    assert!(
        response.contains("text/plain; version=0.0.4") && response.ends_with("\r\n\r\nregatta_up 1\n"),
        "{response}"
    );
    let head = request(address, b"HEAD /metrics HTTP/1.0\r\n\r\n");
    assert!(head.contains("Content-Length: 13\r\n") && head.ends_with("\r\n\r\n"), "{head}");
    assert!(request(address, b"GET / HTTP/1.1\r\n\r\n").ends_with("/metrics.\n"));
    assert!(request(address, b"GET /favicon.ico HTTP/1.1\r\n\r\n").starts_with("HTTP/1.1 404"));
}

#[test]
fn invalid_requests_are_rejected_and_the_next_one_is_served() {
    let address = server("page\n");
    assert!(request(address, b"\x16\x03\x01\x02\x00\r\n\r\n").starts_with("HTTP/1.1 400"));
    assert!(request(address, b"DELETE /metrics HTTP/1.1\r\n\r\n").starts_with("HTTP/1.1 405"));
    let endless = [b"GET /metrics HTTP/1.1\r\nX: ".to_vec(), vec![b'x'; 2 * MAX_REQUEST]].concat();
    assert!(request(address, &endless).starts_with("HTTP/1.1 431"));
    assert!(scrape(address).ends_with("page\n"));
}

#[test]
fn clients_that_hang_do_not_block_others_for_long() {
    let address = server(&"x".repeat(8 << 20));
    let mut hanging: Vec<_> = (0..3 * MAX_CONNECTIONS).map(|_| connect(address)).collect();
    for (index, stream) in hanging.iter_mut().enumerate() {
        let start: &[u8] = if index % 2 == 0 { b"GET /met" } else { b"GET /metrics HTTP/1.1\r\n\r\n" };
        // A connection beyond the limit may already be closed.
        let _ = stream.write_all(start);
    }
    // The clients neither finish their requests nor read the responses. Each loses its connection after the timeout.
    let start = Instant::now();
    let served = || {
        let mut stream = TcpStream::connect(address).ok()?;
        stream.write_all(b"GET / HTTP/1.1\r\n\r\n").ok()?;
        let mut response = String::new();
        stream.read_to_string(&mut response).ok()?;
        response.starts_with("HTTP/1.1 200").then_some(())
    };
    while served().is_none() {
        assert!(start.elapsed() < Duration::from_secs(60), "still blocked");
        thread::sleep(Duration::from_millis(50));
    }
    drop(hanging);
}

#[test]
fn a_port_in_use_is_reported_with_advice() {
    let address = server("page\n");
    let error = start(address, Arc::new(Fixed(String::new()))).expect_err("taken").to_string();
    assert!(error.contains(&address.to_string()) && error.contains("--listen") && !error.contains('\n'), "{error}");
}
