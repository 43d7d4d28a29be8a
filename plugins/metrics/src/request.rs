//! HTTP requests of the exporter's clients.

/// The largest number of bytes in a request.
pub const MAX_REQUEST: usize = 8 << 10;

/// The largest number of headers in a request.
const MAX_HEADERS: usize = 64;

/// A valid request.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Request {
    /// Path without the query.
    pub path: String,
    /// Whether the method is `HEAD`: the response has no body.
    pub head: bool,
}

/// The error of parsing a request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RequestError {
    /// The request isn't HTTP.
    Malformed,
    /// The method is neither `GET` nor `HEAD`.
    Method,
    /// The request has too many headers or bytes.
    TooLong,
}

impl RequestError {
    /// Returns the status line of the HTTP response.
    pub fn status(self) -> &'static str {
        match self {
            Self::Malformed => "400 Bad Request",
            Self::Method => "405 Method Not Allowed",
            Self::TooLong => "431 Request Header Fields Too Large",
        }
    }
}

impl Request {
    /// Parses a request. Returns `None` if the bytes are only its beginning.
    ///
    /// # Errors
    /// [`RequestError`] if no further bytes can make the request valid.
    pub fn parse(bytes: &[u8]) -> Result<Option<Self>, RequestError> {
        let mut headers = [httparse::EMPTY_HEADER; MAX_HEADERS];
        let mut request = httparse::Request::new(&mut headers);
        match request.parse(bytes) {
            Ok(httparse::Status::Partial) => return Ok(None),
            Ok(httparse::Status::Complete(_)) => {}
            Err(httparse::Error::TooManyHeaders) => return Err(RequestError::TooLong),
            Err(_) => return Err(RequestError::Malformed),
        }
        let target = request.path.unwrap_or_default();
        let path = target.split('?').next().unwrap_or_default().to_owned();
        match request.method {
            Some("GET") => Ok(Some(Self { path, head: false })),
            Some("HEAD") => Ok(Some(Self { path, head: true })),
            _ => Err(RequestError::Method),
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const VALID: &[u8] = b"GET /metrics?x=1 HTTP/1.1\r\nHost: here\r\nAccept: */*\r\n\r\n";

    #[test]
    fn a_valid_request_is_parsed_when_it_is_complete() {
        for end in 0..VALID.len() {
            assert_eq!(Request::parse(&VALID[..end]), Ok(None), "{end}");
        }
        assert_eq!(Request::parse(VALID), Ok(Some(Request { path: "/metrics".to_owned(), head: false })));
    }

    #[test]
    fn invalid_requests_are_rejected() {
        assert_eq!(Request::parse(b"\x16\x03\x01 hello\r\n\r\n"), Err(RequestError::Malformed));
        assert_eq!(Request::parse(b"POST / HTTP/1.1\r\n\r\n"), Err(RequestError::Method));
        let many = format!("GET / HTTP/1.1\r\n{}\r\n", "a: b\r\n".repeat(MAX_HEADERS + 1));
        assert_eq!(Request::parse(many.as_bytes()), Err(RequestError::TooLong));
    }

    proptest! {
        #[test]
        fn parsing_never_panics(bytes in prop::collection::vec(any::<u8>(), 0..200), cut in 0..VALID.len()) {
            let _ = Request::parse(&bytes);
            let _ = Request::parse(&[&VALID[..cut], &bytes].concat());
        }
    }
}
