//! Recordings of a broker's traffic as text, as `mosquitto_sub` prints it.
//!
//! A line is a message: `TOPIC PAYLOAD` (`-v`), `TIME TOPIC PAYLOAD` (`-F '%U %t %p'`, or `%I` for
//! the time), `TIME QOS RETAIN TOPIC PAYLOAD` (`-F '%U %q %r %t %p'`), or an object (`-F %j`). The
//! payload goes on in the next lines until its braces are closed, or another message begins.

use std::io::{self, BufRead, Read as _};

use serde::Deserialize;

use super::clock;
use super::seen::{Address, Delivery, Seen};

/// The longest message, in bytes; what is beyond is left out, so that it is no JSON.
const MOST_BYTES: usize = (4 << 20) + 1024;

/// A message of a recording.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Recorded {
    time: Option<u64>,
    topic: String,
    payload: Vec<u8>,
    delivery: Option<Delivery>,
}

impl Recorded {
    /// The message, as the judge takes it.
    pub fn seen(&self) -> Seen<'_> {
        Seen {
            time: self.time.map(f64::from_bits),
            topic: &self.topic,
            payload: &self.payload,
            delivery: self.delivery,
        }
    }
}

/// Reads the messages of a recording one after the other.
#[derive(Debug)]
pub struct Recording<R> {
    input: R,
    line: Vec<u8>,
    /// The message whose payload may go on in the next line.
    open: Option<Recorded>,
    braces: Braces,
    /// Lines that belong to no message.
    unread: u64,
}

impl<R: BufRead> Recording<R> {
    /// Creates a reader.
    pub fn new(input: R) -> Self {
        Self { input, line: Vec::new(), open: None, braces: Braces::default(), unread: 0 }
    }

    /// The lines that belong to no message.
    pub fn unread_lines(&self) -> u64 {
        self.unread
    }

    /// Reads the next message; `None` at the end.
    ///
    /// # Errors
    /// Those of the input.
    pub fn read(&mut self) -> io::Result<Option<Recorded>> {
        loop {
            if self.braces.are_closed()
                && let Some(done) = self.open.take()
            {
                return Ok(Some(done));
            }
            if !self.read_line()? {
                return Ok(self.open.take());
            }
            if let Some(cut_off) = self.take_line() {
                return Ok(Some(cut_off));
            }
        }
    }

    /// Takes a line. Returns the message before, if it isn't complete and another one begins.
    fn take_line(&mut self) -> Option<Recorded> {
        if let Some(next) = message(&self.line) {
            self.braces = Braces::default();
            self.braces.read(&next.payload);
            return self.open.replace(next);
        }
        match &mut self.open {
            Some(open) => {
                append(&mut open.payload, &self.line);
                self.braces.read(&self.line);
            }
            None => self.unread += u64::from(!self.line.trim_ascii().is_empty()),
        }
        None
    }

    /// Reads a line of at most the bytes of a message, and skips its rest.
    fn read_line(&mut self) -> io::Result<bool> {
        self.line.clear();
        let most = MOST_BYTES as u64;
        (&mut self.input).take(most).read_until(b'\n', &mut self.line)?;
        let is_cut = self.line.len() >= MOST_BYTES && !self.line.ends_with(b"\n");
        if is_cut {
            self.input.skip_until(b'\n')?;
        }
        let is_there = !self.line.is_empty();
        while self.line.ends_with(b"\n") || self.line.ends_with(b"\r") {
            self.line.pop();
        }
        Ok(is_there)
    }
}

/// The braces of a payload that are open.
#[derive(Clone, Copy, Debug, Default)]
struct Braces {
    open: usize,
    text: Text,
}

/// The place in a text of JSON.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Text {
    #[default]
    Outside,
    Inside,
    AfterBackslash,
}

impl Braces {
    fn read(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.text = match (self.text, byte) {
                (Text::Outside, b'"') | (Text::AfterBackslash, _) => Text::Inside,
                (Text::Inside, b'\\') => Text::AfterBackslash,
                (Text::Inside, b'"') => Text::Outside,
                (text, _) => text,
            };
            match (self.text, byte) {
                (Text::Outside, b'{') => self.open += 1,
                (Text::Outside, b'}') => self.open = self.open.saturating_sub(1),
                _ => {}
            }
        }
    }

    fn are_closed(self) -> bool {
        self.open == 0
    }
}

fn append(payload: &mut Vec<u8>, line: &[u8]) {
    let room = MOST_BYTES.saturating_sub(payload.len());
    payload.extend(b"\n".iter().chain(line).take(room));
}

/// Reads a line that begins a message.
fn message(line: &[u8]) -> Option<Recorded> {
    if line.first() == Some(&b'{') {
        return object(line);
    }
    let (first, rest) = word(line)?;
    let Some(time) = time(first) else { return with_topic(None, None, line) };
    let plain = with_topic(Some(time), None, rest);
    plain.or_else(|| {
        let (quality, rest) = word(rest)?;
        let (retain, rest) = word(rest)?;
        with_topic(Some(time), Some(delivery(quality, retain)?), rest)
    })
}

/// Splits a line at its first space.
fn word(line: &[u8]) -> Option<(&[u8], &[u8])> {
    let end = line.iter().position(|byte| *byte == b' ')?;
    Some((&line[..end], &line[end + 1..]))
}

fn with_topic(time: Option<f64>, delivery: Option<Delivery>, line: &[u8]) -> Option<Recorded> {
    // A message may be empty.
    let (topic, payload) = word(line).unwrap_or((line, b""));
    let topic = core::str::from_utf8(topic).ok()?;
    Address::of(topic)?;
    let (topic, payload) = (topic.to_owned(), payload.to_vec());
    Some(Recorded { time: time.map(f64::to_bits), topic, payload, delivery })
}

fn time(word: &[u8]) -> Option<f64> {
    let text = core::str::from_utf8(word).ok()?;
    let is_number = text.bytes().all(|byte| byte.is_ascii_digit() || byte == b'.');
    let seconds = if is_number { text.parse().ok() } else { clock::seconds_with_zone(text) };
    seconds.filter(|seconds: &f64| seconds.is_finite())
}

fn delivery(quality: &[u8], retain: &[u8]) -> Option<Delivery> {
    let quality = match quality {
        b"0" => 0,
        b"1" => 1,
        b"2" => 2,
        _ => return None,
    };
    let retained = match retain {
        b"0" => false,
        b"1" => true,
        _ => return None,
    };
    Some(Delivery { quality, retained })
}

/// A message as an object.
#[derive(Deserialize)]
struct Object {
    #[serde(default)]
    tst: String,
    topic: String,
    #[serde(default)]
    payload: serde_json::Value,
}

fn object(line: &[u8]) -> Option<Recorded> {
    let object: Object = serde_json::from_slice(line).ok()?;
    let payload = match object.payload {
        serde_json::Value::String(text) => text.into_bytes(),
        content => content.to_string().into_bytes(),
    };
    Some(Recorded {
        time: clock::seconds_with_zone(&object.tst).map(f64::to_bits),
        topic: object.topic,
        payload,
        // Objects have the quality of the subscription, which is 0 unless it was asked for.
        delivery: None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const TOPIC: &str = "uagv/v2/KIT/1/state";

    fn read(text: &[u8]) -> (Vec<Recorded>, u64) {
        let mut recording = Recording::new(text);
        let mut messages = Vec::new();
        while let Some(message) = recording.read().expect("memory can be read") {
            messages.push(message);
        }
        (messages, recording.unread_lines())
    }

    fn one(line: &str) -> Recorded {
        let (messages, unread) = read(line.as_bytes());
        assert_eq!((messages.len(), unread), (1, 0), "{line}");
        messages[0].clone()
    }

    #[test]
    fn all_formats_are_read() {
        let kept = Some(Delivery { quality: 1, retained: true });
        for (line, time, delivery) in [
            ("{TOPIC} {\"a\": 1}".to_owned(), None, None),
            ("1.5 {TOPIC} {\"a\": 1}".to_owned(), Some(1.5), None),
            ("1970-01-01T01:00:02+0100 {TOPIC} {\"a\": 1}".to_owned(), Some(2.0), None),
            ("3.5 1 1 {TOPIC} {\"a\": 1}".to_owned(), Some(3.5), kept),
            (
                "{\"tst\":\"1970-01-01T00:00:04.000000Z+0000\",\"topic\":\"{TOPIC}\",\
                 \"qos\":1,\"retain\":1,\"payloadlen\":8,\"payload\":\"{\\\"a\\\": 1}\"}"
                    .to_owned(),
                Some(4.0),
                None,
            ),
        ] {
            let message = one(&line.replace("{TOPIC}", TOPIC));
            let seen = message.seen();
            assert_eq!((seen.time, seen.delivery), (time, delivery), "{line}");
            assert_eq!((seen.topic, seen.payload), (TOPIC, &b"{\"a\": 1}"[..]), "{line}");
        }
    }

    #[test]
    fn a_payload_ends_with_its_braces_or_with_the_next_message() {
        let text =
            format!("{TOPIC} {{\"a}}\\\"\":\n {{}}\n}}\nhello/world 1\n{TOPIC} {{\n{TOPIC} 7");
        let (messages, unread) = read(text.as_bytes());
        let payloads: Vec<_> =
            messages.iter().map(|one| String::from_utf8_lossy(&one.payload)).collect();
        assert_eq!(payloads, ["{\"a}\\\"\":\n {}\n}", "{", "7"]);
        assert_eq!(unread, 1);
    }

    #[test]
    fn a_line_without_end_is_cut() {
        let mut text = format!("{TOPIC} {{").into_bytes();
        text.resize(3 * MOST_BYTES, b'x');
        text.extend(format!("\n{TOPIC} {{}}\n").bytes());
        let (messages, _) = read(&text);
        let lengths: Vec<_> = messages.iter().map(|one| one.payload.len()).collect();
        assert_eq!(lengths, [MOST_BYTES - TOPIC.len() - 1, 2]);
    }
}
