//! The broker with the client of this crate, and with what is no client.

use std::io::{Read, Write};
use std::net::TcpStream;
use std::time::Instant;

use super::*;
use crate::broker::{Broker, Delivery, Incoming, Session};

fn server(access: Access) -> Server {
    Server::start("127.0.0.1:0".parse().expect("an address"), access).expect("a broker")
}

fn connect(server: &Server, user: &str, password: &str, session: &Session) -> Broker {
    let url = format!("mqtt://{user}{}", server.address()).parse().expect("an address");
    let mut broker = Broker::start(url, Some(password.to_owned())).expect("a thread");
    broker.connect(session);
    broker
}

/// Waits for what comes next.
fn next(broker: &Broker) -> Incoming {
    let start = Instant::now();
    while start.elapsed() < Duration::from_secs(30) {
        if let Some(incoming) = broker.take() {
            return incoming;
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    panic!("nothing came");
}

/// Waits for a message, as text.
fn message(broker: &Broker) -> String {
    loop {
        if let Incoming::Message { topic, payload, .. } = next(broker) {
            return format!("{topic} {}", String::from_utf8_lossy(&payload));
        }
    }
}

fn session(name: &str, topics: &[&str]) -> Session {
    Session {
        client_id: name.to_owned(),
        will: Some((format!("{name}/connection"), b"broken".to_vec())),
        topics: topics.iter().map(|topic| (*topic).to_owned()).collect(),
    }
}

#[test]
fn messages_reach_those_who_listen_and_kept_ones_those_who_come_later() {
    let server = server(Access::Anonymous);
    let robot = connect(&server, "", "", &session("robot", &["robot/order"]));
    assert!(matches!(next(&robot), Incoming::Connected { link: 0 }));
    robot.publish(0, "robot/connection", b"online".to_vec(), Delivery::Kept);
    let master = connect(&server, "", "", &session("master", &["+/connection", "+/state"]));
    assert_eq!(message(&master), "robot/connection online");
    master.publish(0, "robot/order", b"go".to_vec(), Delivery::Now);
    assert_eq!(message(&robot), "robot/order go");
    robot.publish(0, "robot/state", vec![b'x'; 1 << 20], Delivery::Now);
    assert_eq!(message(&master).len(), 12 + (1 << 20));
    // A farewell publishes no last will; a connection that breaks does.
    robot.end();
    let robot = connect(&server, "", "", &session("robot", &[]));
    assert!(matches!(next(&robot), Incoming::Connected { .. }));
    robot.publish(0, "robot/connection", b"again".to_vec(), Delivery::Kept);
    assert_eq!(message(&master), "robot/connection again");
    let taken = connect(&server, "", "", &session("robot", &[]));
    assert_eq!(message(&master), "robot/connection broken");
    [taken, master, robot].into_iter().for_each(Broker::end);
}

#[test]
fn only_those_with_the_password_get_in() {
    let login = Login { user: "me".to_owned(), password: "secret".to_owned() };
    let server = server(Access::Login(login));
    for (user, password) in [("", ""), ("me@", "wrong"), ("me@", "secret2"), ("you@", "secret")] {
        let broker = connect(&server, user, password, &session("x", &[]));
        let Incoming::Lost { reason, .. } = next(&broker) else { panic!("{user}{password}") };
        assert!(reason.contains("BadUserNamePassword"), "{reason}");
        broker.end();
    }
    let broker = connect(&server, "me@", "secret", &session("x", &[]));
    assert!(matches!(next(&broker), Incoming::Connected { .. }));
    broker.end();
}

#[test]
fn what_is_no_client_is_dropped_and_disturbs_nobody() {
    let server = server(Access::Anonymous);
    let request = format!("GET / HTTP/1.1\r\nHost: {}\r\n\r\n", "x".repeat(100));
    for bytes in [request.as_bytes(), &[0; 64], &[0xff; 64], &[0x30, 4, 0, 1, b'x', 0]] {
        let mut stream = TcpStream::connect(server.address()).expect("connected");
        stream.write_all(bytes).expect("sent");
        let mut rest = Vec::new();
        // The end of the connection, or its reset.
        let _ = stream.read_to_end(&mut rest);
        assert!(rest.is_empty(), "{bytes:?}: {rest:?}");
    }
    let broker = connect(&server, "", "", &session("x", &[]));
    assert!(matches!(next(&broker), Incoming::Connected { .. }));
    broker.end();
}

/// A connection packet of 15 MB, of which a part comes.
#[test]
fn who_has_not_said_its_name_has_little_room() {
    let server = server(Access::Anonymous);
    let mut stream = TcpStream::connect(server.address()).expect("connected");
    let start = Instant::now();
    stream.write_all(&[0x10, 0xc0, 0xc3, 0x93, 0x07, 0, 4, b'M', b'Q']).expect("sent");
    stream.set_read_timeout(Some(Duration::from_secs(9))).expect("a timeout");
    let end = stream.read(&mut [0]);
    assert!(matches!(end, Ok(0)) && start.elapsed() < Duration::from_secs(8), "{end:?}");
}

#[tokio::test]
async fn the_oldest_stranger_makes_room() {
    let mut strangers = Strangers::default();
    let (first, second) = (tokio::spawn(std::future::pending::<()>()), tokio::spawn(async {}));
    strangers.add(first.abort_handle());
    strangers.add(second.abort_handle());
    second.await.expect("ended");
    for _ in 0..MOST_STRANGERS - 1 {
        strangers.add(tokio::spawn(std::future::pending::<()>()).abort_handle());
    }
    tokio::task::yield_now().await;
    assert!(!first.is_finished(), "there was room");
    strangers.add(tokio::spawn(std::future::pending::<()>()).abort_handle());
    assert!(first.await.expect_err("no end of its own").is_cancelled());
    assert_eq!(strangers.0.len(), MOST_STRANGERS);
}
