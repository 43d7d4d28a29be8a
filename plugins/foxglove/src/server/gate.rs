//! The admission of connections as clients.

use std::net::SocketAddr;

use regatta_kit::server::{is_foreign, is_token};
use tokio_tungstenite::tungstenite::handshake::server::{
    Callback, ErrorResponse, Request, Response,
};
use tokio_tungstenite::tungstenite::http::header::{HeaderName, ORIGIN, SEC_WEBSOCKET_PROTOCOL};
use tokio_tungstenite::tungstenite::http::{HeaderMap, HeaderValue, StatusCode};

use crate::hub::{Fault, Hub};
use crate::protocol::SUBPROTOCOLS;

/// The rules of who may become a client.
#[derive(Default)]
pub(crate) struct Gate {
    /// Sites whose pages may connect.
    pub origins: Vec<String>,
    /// The token that clients have in their address, if they need one.
    pub token: Option<String>,
    /// Whether the server listens on loopback.
    pub is_loopback: bool,
}

impl Gate {
    /// Returns the check of a handshake.
    pub fn check<'gate>(
        &'gate self,
        hub: &'gate Hub,
        peer: SocketAddr,
        has_seat: bool,
    ) -> Check<'gate> {
        Check { gate: self, hub, peer, has_seat }
    }

    /// Returns the name of the protocol that a request is answered with.
    fn admit(&self, request: &Request, has_seat: bool) -> Result<&'static str, Refusal> {
        if !self.may_connect(request.headers()) {
            return Err(Refusal::Site(text(request.headers(), &ORIGIN).to_owned()));
        }
        if let Some(token) = &self.token
            && !is_token(given_token(request).as_bytes(), token)
        {
            return Err(Refusal::Token);
        }
        let offered = request.headers().get_all(SEC_WEBSOCKET_PROTOCOL);
        let offered: Vec<&str> = offered
            .iter()
            .flat_map(|names| names.to_str().unwrap_or_default().split(',').map(str::trim))
            .collect();
        let protocol = SUBPROTOCOLS.into_iter().find(|name| offered.contains(name));
        let protocol = protocol.ok_or(Refusal::Protocol)?;
        if has_seat { Ok(protocol) } else { Err(Refusal::Crowd) }
    }

    fn may_connect(&self, headers: &HeaderMap) -> bool {
        let origin = text(headers, &ORIGIN);
        if self.origins.iter().any(|allowed| allowed == origin || allowed == "*") {
            return true;
        }
        // Only on loopback is the host known; elsewhere a page of any site is foreign.
        if self.is_loopback { !is_foreign(headers) } else { !headers.contains_key(ORIGIN) }
    }
}

/// The token in the address of a request: `ws://HOST/?token=TOKEN`.
fn given_token(request: &Request) -> &str {
    let query = request.uri().query().unwrap_or_default();
    query.split('&').find_map(|part| part.strip_prefix("token=")).unwrap_or_default()
}

fn text<'headers>(headers: &'headers HeaderMap, name: &HeaderName) -> &'headers str {
    headers.get(name).and_then(|value| value.to_str().ok()).unwrap_or_default()
}

/// The reason why a connection becomes no client.
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
enum Refusal {
    #[error(
        "pages of '{0}' may not connect; if that is your Foxglove, start with --allow-origin {0}"
    )]
    Site(String),
    #[error("the token is missing or wrong; the address is ws://HOST:PORT/?token=TOKEN")]
    Token,
    #[error("a client must speak {} or {}", SUBPROTOCOLS[0], SUBPROTOCOLS[1])]
    Protocol,
    #[error("there is no room for another client")]
    Crowd,
}

impl Refusal {
    fn status(&self) -> StatusCode {
        match self {
            Self::Site(_) => StatusCode::FORBIDDEN,
            Self::Token => StatusCode::UNAUTHORIZED,
            Self::Protocol => StatusCode::BAD_REQUEST,
            Self::Crowd => StatusCode::SERVICE_UNAVAILABLE,
        }
    }

    fn fault(&self) -> Fault {
        match self {
            Self::Site(_) => Fault::Site,
            Self::Token | Self::Protocol => Fault::Handshake,
            Self::Crowd => Fault::Crowd,
        }
    }
}

/// The check of a handshake.
pub(crate) struct Check<'gate> {
    gate: &'gate Gate,
    hub: &'gate Hub,
    peer: SocketAddr,
    has_seat: bool,
}

impl Callback for Check<'_> {
    fn on_request(
        self,
        request: &Request,
        mut response: Response,
    ) -> Result<Response, ErrorResponse> {
        let Self { gate, hub, peer, has_seat } = self;
        match gate.admit(request, has_seat) {
            Ok(protocol) => {
                let protocol = HeaderValue::from_static(protocol);
                response.headers_mut().insert(SEC_WEBSOCKET_PROTOCOL, protocol);
                Ok(response)
            }
            Err(refusal) => {
                hub.tell(refusal.fault(), format_args!("{peer} is refused: {refusal}"));
                let mut response = ErrorResponse::new(Some(format!("{refusal}\n")));
                *response.status_mut() = refusal.status();
                Err(response)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn request(address: &str, headers: &[(&str, &str)]) -> Request {
        let mut request = Request::new(());
        *request.uri_mut() = address.parse().expect("an address");
        for (name, value) in headers {
            let name: HeaderName = name.parse().expect("a name");
            request.headers_mut().append(name, value.parse().expect("a value"));
        }
        request
    }

    const SDK: (&str, &str) = ("sec-websocket-protocol", "foxglove.sdk.v1");

    fn loopback() -> Gate {
        Gate { is_loopback: true, ..Gate::default() }
    }

    #[test]
    fn both_names_of_the_protocol_are_spoken() {
        for (offered, spoken) in [
            ("foxglove.sdk.v1", Ok("foxglove.sdk.v1")),
            ("foxglove.websocket.v1", Ok("foxglove.websocket.v1")),
            ("foxglove.websocket.v1, foxglove.sdk.v1", Ok("foxglove.sdk.v1")),
            ("foxglove.sdk.v1.1,foxglove.sdk.v1", Ok("foxglove.sdk.v1")),
            ("foxglove.sdk.v2", Err(Refusal::Protocol)),
            ("", Err(Refusal::Protocol)),
        ] {
            let request = request("/", &[("sec-websocket-protocol", offered)]);
            assert_eq!(loopback().admit(&request, true), spoken, "{offered}");
        }
        assert_eq!(loopback().admit(&request("/", &[SDK]), false), Err(Refusal::Crowd));
    }

    #[test]
    fn pages_of_other_sites_are_refused_unless_they_are_allowed() {
        let studio = "https://app.foxglove.dev";
        let allowing = Gate { origins: vec![studio.to_owned()], ..loopback() };
        let of_network = Gate { is_loopback: false, ..Gate::default() };
        for (gate, headers, is_admitted) in [
            (loopback(), &[("host", "localhost:8765")][..], true),
            (loopback(), &[("host", "localhost:8765"), ("origin", studio)], false),
            (loopback(), &[("host", "rebound.example")], false),
            (allowing, &[("host", "localhost:8765"), ("origin", studio)], true),
            (of_network, &[("host", "plant")], true),
            (Gate { is_loopback: false, ..Gate::default() }, &[("origin", studio)], false),
        ] {
            let headers: Vec<_> = headers.iter().copied().chain([SDK]).collect();
            let admitted = gate.admit(&request("/", &headers), true);
            assert_eq!(admitted.is_ok(), is_admitted, "{headers:?}: {admitted:?}");
        }
    }

    #[test]
    fn a_token_is_part_of_the_address() {
        let token = Some("secret-token".to_owned());
        let gate = Gate { token, ..loopback() };
        for (address, is_admitted) in [
            ("/?token=secret-token", true),
            ("/any?a=b&token=secret-token", true),
            ("/?token=secret-toke", false),
            ("/?token=", false),
            ("/", false),
        ] {
            let admitted = gate.admit(&request(address, &[SDK]), true);
            assert_eq!(admitted.is_ok(), is_admitted, "{address}");
        }
    }
}
