//! The requests that a server accepts: those over its Unix socket, which only its user can open, and
//! over TCP those with its token.

use std::net::IpAddr;

use axum::extract::Request;
use axum::http::HeaderMap;
use axum::http::header::{AUTHORIZATION, HOST, ORIGIN};
use subtle::ConstantTimeEq as _;

/// The other end of a connection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Peer {
    /// A process of this user, over a Unix socket.
    Socket,
    /// Any process of this machine.
    Loopback,
    /// Any machine.
    Network,
}

/// The requests that a server accepts.
#[derive(Clone, Default)]
pub struct Access {
    token: Option<String>,
}

impl std::fmt::Debug for Access {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.debug_struct("Access").finish_non_exhaustive()
    }
}

/// The reason of a request that isn't accepted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Refusal {
    /// The token is missing or wrong: status 401.
    #[error("the header `Authorization: Bearer TOKEN` is missing or wrong")]
    Token,
    /// A page of another site makes a browser send it: status 403.
    #[error("pages of other sites may not send requests")]
    Site,
}

impl Access {
    /// Accepts requests over TCP with this token; none without.
    pub fn with_token(token: Option<String>) -> Self {
        Self { token }
    }

    /// Checks a request.
    ///
    /// # Errors
    /// [`Refusal`] if it isn't accepted.
    pub fn check(&self, request: &Request) -> Result<(), Refusal> {
        Self::check_site(request)?;
        let peer = request.extensions().get().copied().unwrap_or(Peer::Network);
        let token = self.token.as_deref();
        match peer == Peer::Socket || token.is_some_and(|it| has_token(request.headers(), it)) {
            true => Ok(()),
            false => Err(Refusal::Token),
        }
    }

    /// Checks a request for what needs no token, such as a page that asks for one.
    ///
    /// # Errors
    /// [`Refusal::Site`] if a page of another site makes a browser send it to this machine.
    pub fn check_site(request: &Request) -> Result<(), Refusal> {
        let peer = request.extensions().get().copied().unwrap_or(Peer::Network);
        match peer == Peer::Loopback && is_foreign(request.headers()) {
            true => Err(Refusal::Site),
            false => Ok(()),
        }
    }
}

fn has_token(headers: &HeaderMap, token: &str) -> bool {
    let value = headers.get(AUTHORIZATION).map_or(&[][..], |value| value.as_bytes());
    let (scheme, given) = value.split_at(value.len().min(BEARER.len()));
    is_token(given.trim_ascii_start(), token) && scheme.eq_ignore_ascii_case(BEARER)
}

/// Whether these bytes are the token, in a time that doesn't depend on the number of right bytes.
pub fn is_token(given: &[u8], token: &str) -> bool {
    given.ct_eq(token.as_bytes()).into()
}

const BEARER: &[u8] = b"Bearer ";

/// Whether a page of another site makes a browser send a request with these headers to this
/// machine: the host isn't an address, or the page is from elsewhere.
pub fn is_foreign(headers: &HeaderMap) -> bool {
    let host = match headers.get(HOST).map(|value| value.to_str()) {
        None => "localhost",
        Some(Ok(host)) => host,
        Some(Err(_)) => return true,
    };
    let own = format!("http://{host}");
    !is_own_host(host)
        || headers.get(ORIGIN).is_some_and(|origin| origin.as_bytes() != own.as_bytes())
}

/// Whether a host, with or without a port, is `localhost` or an address: no name that somebody else
/// has registered.
///
/// ```
/// use regatta_kit::server::is_own_host;
///
/// assert!(["localhost:80", "127.0.0.1", "[::1]", "[::1]:55200"].into_iter().all(is_own_host));
/// assert!(!["evil.example:80", "::1", "[::1]evil", "", "localhost.evil"].into_iter().any(is_own_host));
/// ```
pub fn is_own_host(host: &str) -> bool {
    if let Some(rest) = host.strip_prefix('[') {
        let Some((address, port)) = rest.split_once(']') else { return false };
        let is_port = port.is_empty() || port.strip_prefix(':').is_some_and(is_number);
        return is_port && matches!(address.parse(), Ok(IpAddr::V6(_)));
    }
    let (name, port) = host.split_once(':').unwrap_or((host, "0"));
    let is_name =
        name.eq_ignore_ascii_case("localhost") || matches!(name.parse(), Ok(IpAddr::V4(_)));
    is_name && is_number(port)
}

fn is_number(text: &str) -> bool {
    text.parse::<u16>().is_ok()
}

#[cfg(test)]
mod tests {
    use axum::body::Body;

    use super::*;

    fn request(peer: Peer, headers: &[(&str, &str)]) -> Request {
        let mut request = Request::new(Body::empty());
        request.extensions_mut().insert(peer);
        for (name, value) in headers {
            let name: axum::http::HeaderName = name.parse().expect("a name");
            request.headers_mut().insert(name, value.parse().expect("a value"));
        }
        request
    }

    #[test]
    fn a_token_is_needed_over_tcp_alone() {
        let access = Access::with_token(Some("secret-token".to_owned()));
        assert_eq!(access.check(&request(Peer::Socket, &[])), Ok(()));
        for peer in [Peer::Loopback, Peer::Network] {
            assert_eq!(access.check(&request(peer, &[])), Err(Refusal::Token));
            for (given, is_right) in [
                ("Bearer secret-token", true),
                ("bearer secret-token", true),
                ("BEARER  secret-token", true),
                ("Bearer secret-toke", false),
                ("Bearersecret-token", false),
                ("Basic secret-token", false),
                ("", false),
            ] {
                let checked = access.check(&request(peer, &[("authorization", given)]));
                assert_eq!(checked.is_ok(), is_right, "{given}");
            }
        }
    }

    #[test]
    fn pages_of_other_sites_reach_no_server_of_this_machine() {
        for (headers, is_foreign) in [
            (&[("host", "evil.example")][..], true),
            (&[("host", "localhost:9"), ("origin", "http://evil.example")], true),
            (&[("host", "[::1]"), ("origin", "http://[::1]")], false),
            (&[("host", "127.0.0.1:9464")], false),
            (&[], false),
        ] {
            let checked = Access::check_site(&request(Peer::Loopback, headers));
            assert_eq!(checked.is_err(), is_foreign, "{headers:?}");
        }
        assert_eq!(Access::check_site(&request(Peer::Network, &[("host", "plant")])), Ok(()));
    }
}
