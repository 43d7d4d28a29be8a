//! Tests with sockets of the loopback interface at both ends.

use super::*;

/// Receives `count` datagrams, or fewer if the socket is silent for 10 seconds.
fn received(socket: &Socket, count: usize) -> Vec<Vec<u8>> {
    let (mut buffers, mut datagrams) = (Buffers::default(), Vec::new());
    while datagrams.len() < count && socket.wait_to_receive(Duration::from_secs(10)) {
        socket
            .receive(&mut buffers, |datagram| datagrams.push(datagram.to_vec()))
            .expect("received");
    }
    datagrams
}

fn round_trip(listen: &str, datagram_bytes: usize) {
    let receiver = Socket::listen(&listen.parse().expect("infallible")).expect("a socket");
    let to = receiver.local_address().expect("an address");
    let sender = Socket::towards(to).expect("a socket");
    let bytes: Vec<u8> = (0..datagram_bytes * 70 + 3).map(|i| (i / datagram_bytes) as u8).collect();
    let (first, rest) = bytes.split_at(datagram_bytes * 40);
    sender.send(to, first, datagram_bytes).expect("sent");
    sender.send(to, rest, datagram_bytes).expect("sent");
    let datagrams = received(&receiver, 71);
    assert_eq!(datagrams, bytes.chunks(datagram_bytes).map(<[u8]>::to_vec).collect::<Vec<_>>());
    assert!(receiver.dropped().is_none_or(|dropped| dropped == 0));
}

#[test]
fn datagrams_sent_in_one_call_arrive_separately() {
    round_trip("0", 1_400);
    round_trip("127.0.0.1:0", 200);
}

#[test]
fn ipv6_is_supported() {
    // A machine may have no IPv6 address.
    if UdpSocket::bind("[::1]:0").is_ok() {
        round_trip("[::1]:0", 1_400);
    }
}

#[test]
fn empty_datagrams_are_skipped() {
    let receiver = Socket::listen(&Listen("127.0.0.1:0".into())).expect("a socket");
    let sender = UdpSocket::bind("127.0.0.1:0").expect("a socket");
    let to = receiver.local_address().expect("an address");
    sender.send_to(b"", to).expect("sent");
    sender.send_to(b"x", to).expect("sent");
    assert_eq!(received(&receiver, 1), [b"x"]);
}

#[test]
fn an_unreachable_receiver_is_reported_and_can_appear_later() {
    let to =
        UdpSocket::bind("127.0.0.1:0").and_then(|socket| socket.local_addr()).expect("a free port");
    let sender = Socket::towards(to).expect("a socket");
    let reported = (0..1_000).any(|_| {
        std::thread::sleep(Duration::from_millis(1));
        sender.send(to, b"1,2,3,4\n", 1_400).is_ok_and(|reachable| !reachable)
    });
    assert!(reported || !cfg!(target_os = "linux"));
    let receiver = UdpSocket::bind(to).expect("the port is free");
    receiver.set_read_timeout(Some(Duration::from_secs(10))).expect("set");
    sender.send(to, b"5,6,7,8\n", 1_400).expect("a receiver exists now");
    let mut buffer = [0; 20];
    let length = receiver.recv(&mut buffer).expect("received");
    assert_eq!(&buffer[..length], b"5,6,7,8\n");
}

#[test]
fn errors_of_addresses_have_one_line() {
    for invalid in ["nonsense", "no.such.host.invalid:1", "127.0.0.1:99999", ""] {
        let message = resolve(invalid).expect_err(invalid).to_string();
        assert!(
            message.contains(&format!("'{invalid}'")) && message.lines().count() == 1,
            "{message}"
        );
    }
    let taken = Socket::listen(&Listen("127.0.0.1:0".into())).expect("a socket");
    let address = taken.local_address().expect("an address").to_string();
    let message = Socket::listen(&Listen(address.clone())).expect_err("taken").to_string();
    assert!(message.contains(&address) && message.lines().count() == 1, "{message}");
}
