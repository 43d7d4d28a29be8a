//! The sources of transports: requests over HTTP, and made-up ones.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::sync::mpsc::{Receiver, Sender, channel};

use serde::Deserialize;

use crate::Result;
use crate::roads::Roads;

/// The largest request, in bytes.
const MOST_BYTES: usize = 1 << 16;

/// A transport from a station or a node to another.
#[derive(Deserialize)]
pub struct Transport {
    pub id: String,
    pub pick: String,
    pub drop: String,
}

/// The transports that come, beside those of the broker.
pub struct Load {
    requests: Receiver<Transport>,
    is_own: bool,
    made: usize,
}

impl Load {
    pub fn new(http: Option<u16>, is_own: bool) -> Result<Self> {
        let (sender, requests) = channel();
        if let Some(port) = http {
            let listener = TcpListener::bind(("127.0.0.1", port))?;
            std::thread::spawn(move || {
                for stream in listener.incoming().flatten() {
                    // A client that goes away gets no answer.
                    let _ = answer(stream, &sender);
                }
            });
        }
        Ok(Self { requests, is_own, made: 0 })
    }

    /// Takes what has come, and makes what is missing.
    pub fn take(&mut self, roads: &Roads, missing: usize) -> Vec<Transport> {
        let mut transports: Vec<Transport> = self.requests.try_iter().collect();
        let stations = roads.stations();
        for _ in 0..if self.is_own && stations.len() > 1 { missing } else { 0 } {
            self.made += 1;
            let [pick, drop] = [self.made, self.made + stations.len() / 2]
                .map(|index| stations[index % stations.len()].clone());
            transports.push(Transport { id: format!("own-{}", self.made), pick, drop });
        }
        transports
    }
}

fn answer(mut stream: TcpStream, sender: &Sender<Transport>) -> Result {
    let mut reader = BufReader::new(stream.try_clone()?.take(MOST_BYTES as u64));
    let (mut line, mut length) = (String::new(), 0);
    while reader.read_line(&mut line)? > 0 && !line.trim().is_empty() {
        if let Some(bytes) = line.to_ascii_lowercase().strip_prefix("content-length:") {
            length = bytes.trim().parse::<usize>()?.min(MOST_BYTES);
        }
        line.clear();
    }
    let mut body = vec![0; length];
    reader.read_exact(&mut body)?;
    let status = match serde_json::from_slice(&body) {
        Ok(transport) => {
            sender.send(transport)?;
            "200 OK"
        }
        Err(_) => "400 Bad Request",
    };
    let answer = format!("HTTP/1.1 {status}\r\nContent-Length: 0\r\nConnection: close\r\n\r\n");
    Ok(stream.write_all(answer.as_bytes())?)
}
