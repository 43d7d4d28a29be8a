//! Orders that were acknowledged over HTTP are there after the process was killed.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::process::{Child, Command, Stdio};
use std::sync::Arc;
use std::time::Duration;

use regatta_orders::{OrderPool, OrderSettings, Place, Places};

/// Set in the child process: the path of its store.
const STORE_VARIABLE: &str = "REGATTA_TEST_STORE";

fn places() -> Arc<Places> {
    Arc::new(Places::new((0..4).map(|id| Place { id, ..Place::default() }).collect()))
}

/// The token of the web API, which lies beside the store.
const TOKEN: &str = "secret-token";

fn settings(store: impl Into<std::path::PathBuf>) -> OrderSettings {
    let (http, store) = (Some(SocketAddr::from(([127, 0, 0, 1], 0))), store.into());
    let token_file = Some(store.with_extension("token"));
    OrderSettings { http, token_file, store: Some(store), ..OrderSettings::default() }
}

/// Not a test of its own: the child process, which serves orders until it is killed.
#[test]
#[ignore = "the child process of another test"]
fn child() {
    let Ok(store) = std::env::var(STORE_VARIABLE) else { return };
    let mut book = OrderPool::open(&settings(store), places(), 1, 0.0).expect("a book");
    println!("\nserving {}", book.http_address().expect("an address"));
    for tick in 0.. {
        book.take_requests(f64::from(tick));
        book.publish(f64::from(tick));
        std::thread::sleep(Duration::from_millis(1));
    }
}

fn start(store: &std::path::Path) -> (Child, SocketAddr) {
    let mut child = Command::new(std::env::current_exe().expect("this program"))
        .args(["--exact", "child", "--ignored", "--nocapture"])
        .env(STORE_VARIABLE, store)
        .stdout(Stdio::piped())
        .spawn()
        .expect("a child");
    let lines = BufReader::new(child.stdout.take().expect("its output")).lines();
    let address = lines
        .map_while(Result::ok)
        .find_map(|line| line.strip_prefix("serving ").map(str::to_owned));
    (child, address.expect("an address").parse().expect("an address"))
}

/// Posts orders one after another until the server is gone. Returns the number that was
/// acknowledged.
fn post_until_death(address: SocketAddr, client: usize, first: impl Fn()) -> usize {
    let mut stream = TcpStream::connect(address).expect("connected");
    let body = r#"{"destinations": [{"locationName": 1}]}"#;
    for number in 0.. {
        let head = format!(
            "POST /v1/transportOrders/order-{client}-{number} HTTP/1.1\r\nHost: {address}\r\n\
             Authorization: Bearer {TOKEN}\r\n"
        );
        let request = format!("{head}Content-Length: {}\r\n\r\n{body}", body.len());
        let mut answer = [0; 12];
        if stream.write_all(request.as_bytes()).is_err() || stream.read_exact(&mut answer).is_err()
        {
            return number;
        }
        assert_eq!(&answer, b"HTTP/1.1 201");
        if !finish(&mut stream) {
            return number + 1;
        }
        if number == 20 {
            first();
        }
    }
    0
}

/// Reads the rest of a response. Returns whether it is complete.
fn finish(stream: &mut TcpStream) -> bool {
    let mut head = Vec::new();
    let mut byte = [0];
    while !head.ends_with(b"\r\n\r\n") {
        match stream.read(&mut byte) {
            Ok(1) => head.push(byte[0].to_ascii_lowercase()),
            _ => return false,
        }
    }
    let head = String::from_utf8_lossy(&head).into_owned();
    let length =
        head.split_once("content-length: ").and_then(|(_, rest)| rest.split("\r\n").next());
    let length = length.and_then(|length| length.parse().ok()).expect("a length");
    stream.read_exact(&mut vec![0; length]).is_ok()
}

#[test]
fn every_acknowledged_order_survives_a_kill() {
    let folder = tempfile::tempdir().expect("a folder");
    let store = folder.path().join("orders.db");
    std::fs::write(store.with_extension("token"), TOKEN).expect("written");
    let (mut child, address) = start(&store);
    let (sender, receiver) = std::sync::mpsc::channel();
    let clients: Vec<_> = (0..4)
        .map(|client| {
            let sender = sender.clone();
            std::thread::spawn(move || {
                post_until_death(address, client, || sender.send(()).expect("a receiver"))
            })
        })
        .collect();
    // If a client fails, nothing is waited for.
    drop(sender);
    // In the middle of the work of all clients.
    (0..4).for_each(|_| receiver.recv().expect("some orders are acknowledged"));
    child.kill().expect("killed");
    child.wait().expect("ended");
    let acknowledged: Vec<_> =
        clients.into_iter().map(|client| client.join().expect("a count")).collect();

    let book = OrderPool::open(&OrderSettings { http: None, ..settings(store) }, places(), 1, 0.0)
        .expect("a book");
    let names: Vec<_> = book.open_orders().map(|order| order.content.name.to_string()).collect();
    for (client, count) in acknowledged.into_iter().enumerate() {
        for number in 0..count {
            let name = format!("order-{client}-{number}");
            assert_eq!(names.iter().filter(|known| **known == name).count(), 1, "{name}");
        }
    }
}
