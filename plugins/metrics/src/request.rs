//! What a client of the exporter asks for.

/// Bytes that a request may have.
pub const MAX_REQUEST: usize = 8 << 10;

/// Headers that a request may have.
const MAX_HEADERS: usize = 64;

/// A request that can be answered.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Request {
    /// Without a query.
    pub path: String,
    /// `HEAD`: the answer has no body.
    pub head: bool,
}

/// Why there is no answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refusal {
    /// It isn't HTTP.
    Malformed,
    /// It is neither `GET` nor `HEAD`.
    Method,
    /// It has more headers or bytes than anybody needs to ask for this.
    TooLong,
}

impl Refusal {
    /// As HTTP says it.
    pub fn status(self) -> &'static str {
        match self {
            Self::Malformed => "400 Bad Request",
            Self::Method => "405 Method Not Allowed",
            Self::TooLong => "431 Request Header Fields Too Large",
        }
    }
}

impl Request {
    /// The request that these bytes are, `None` if they are only its start.
    ///
    /// # Errors
    /// [`Refusal`] if nothing that follows can make a proper request of them.
    pub fn parse(bytes: &[u8]) -> Result<Option<Self>, Refusal> {
        let mut headers = [httparse::EMPTY_HEADER; MAX_HEADERS];
        let mut request = httparse::Request::new(&mut headers);
        match request.parse(bytes) {
            Ok(httparse::Status::Partial) => return Ok(None),
            Ok(httparse::Status::Complete(_)) => {}
            Err(httparse::Error::TooManyHeaders) => return Err(Refusal::TooLong),
            Err(_) => return Err(Refusal::Malformed),
        }
        let target = request.path.unwrap_or_default();
        let path = target.split('?').next().unwrap_or_default().to_owned();
        match request.method {
            Some("GET") => Ok(Some(Self { path, head: false })),
            Some("HEAD") => Ok(Some(Self { path, head: true })),
            _ => Err(Refusal::Method),
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const PROPER: &[u8] = b"GET /metrics?x=1 HTTP/1.1\r\nHost: here\r\nAccept: */*\r\n\r\n";

    #[test]
    fn a_proper_request_is_understood_when_it_is_complete() {
        for end in 0..PROPER.len() {
            assert_eq!(Request::parse(&PROPER[..end]), Ok(None), "{end}");
        }
        assert_eq!(Request::parse(PROPER), Ok(Some(Request { path: "/metrics".to_owned(), head: false })));
    }

    #[test]
    fn what_is_no_request_is_refused() {
        assert_eq!(Request::parse(b"\x16\x03\x01 hello\r\n\r\n"), Err(Refusal::Malformed));
        assert_eq!(Request::parse(b"POST / HTTP/1.1\r\n\r\n"), Err(Refusal::Method));
        let many = format!("GET / HTTP/1.1\r\n{}\r\n", "a: b\r\n".repeat(MAX_HEADERS + 1));
        assert_eq!(Request::parse(many.as_bytes()), Err(Refusal::TooLong));
    }

    proptest! {
        #[test]
        fn no_bytes_panic(bytes in prop::collection::vec(any::<u8>(), 0..200), cut in 0..PROPER.len()) {
            let _ = Request::parse(&bytes);
            let _ = Request::parse(&[&PROPER[..cut], &bytes].concat());
        }
    }
}
