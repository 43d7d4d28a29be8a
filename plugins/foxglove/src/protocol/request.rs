//! Messages of clients.

use serde::Deserialize;
use serde_json::Value;

/// The byte of a message on a client's own channel.
const MESSAGE_DATA: u8 = 1;
/// The byte of a call of a service.
const SERVICE_CALL: u8 = 2;

/// A message of a client.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(tag = "op", rename_all = "camelCase", rename_all_fields = "camelCase")]
pub enum Request {
    /// The client wants the messages of channels.
    Subscribe {
        /// The channels.
        subscriptions: Vec<Subscription>,
    },
    /// The client wants them no more.
    Unsubscribe {
        /// The client's numbers of subscriptions.
        subscription_ids: Vec<u32>,
    },
    /// The client asks for parameters.
    GetParameters {
        /// Their names; all if there are none.
        #[serde(default)]
        parameter_names: Vec<String>,
        /// The answer has it, too.
        id: Option<String>,
    },
    /// The client changes parameters.
    SetParameters {
        /// Their new values.
        parameters: Vec<Parameter>,
        /// The answer, which comes only if there is one, has it, too.
        id: Option<String>,
    },
    /// The client wants to know when parameters change.
    SubscribeParameterUpdates {
        /// Their names; all if there are none.
        #[serde(default)]
        parameter_names: Vec<String>,
    },
    /// The client wants that no more.
    UnsubscribeParameterUpdates {
        /// Their names; all if there are none.
        #[serde(default)]
        parameter_names: Vec<String>,
    },
    /// The client calls a service.
    #[serde(skip)]
    Call(ServiceCall),
    /// The client asks for a file.
    FetchAsset {
        /// The client's number of the request.
        request_id: u32,
    },
    /// The client publishes on channels of its own.
    Advertise {},
    /// The client ends channels of its own.
    Unadvertise {},
    /// The client sends a message on a channel of its own.
    #[serde(skip)]
    Message,
    /// The client asks who publishes and who reads what.
    SubscribeConnectionGraph {},
    /// The client asks for that no more.
    UnsubscribeConnectionGraph {},
}

/// A client's subscription to a channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Subscription {
    /// The client's number of it.
    pub id: u32,
    /// The server's number of the channel.
    pub channel_id: u32,
}

/// A parameter with its value.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct Parameter {
    /// Its name.
    pub name: String,
    /// Its value; null to remove it.
    #[serde(default)]
    pub value: Value,
}

/// A call of a service.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ServiceCall {
    /// The server's number of the service.
    pub service: u32,
    /// The client's number of the call.
    pub call: u32,
    /// The encoding of the payload.
    pub encoding: String,
    /// The arguments.
    pub payload: Vec<u8>,
}

/// The error of a message that isn't one of the protocol.
#[derive(Debug, thiserror::Error)]
pub enum RequestError {
    /// The text is something else.
    #[error("not a message of the protocol: {0}")]
    Text(#[from] serde_json::Error),
    /// The binary message is of an unknown kind.
    #[error("no binary message of clients begins with the byte {0}")]
    Kind(u8),
    /// The binary message ends too early.
    #[error("a binary message ends too early")]
    Short,
    /// The name of an encoding isn't text.
    #[error("the encoding of a call isn't UTF-8")]
    Encoding,
}

/// Reads a message of a client, which is a text or a binary one.
///
/// # Errors
/// [`RequestError`] if it isn't one of the protocol.
pub fn parse(message: &[u8], is_text: bool) -> Result<Request, RequestError> {
    if is_text {
        return Ok(serde_json::from_slice(message)?);
    }
    let (kind, rest) = message.split_first().ok_or(RequestError::Short)?;
    match *kind {
        MESSAGE_DATA => Ok(Request::Message),
        SERVICE_CALL => Ok(Request::Call(service_call(rest)?)),
        kind => Err(RequestError::Kind(kind)),
    }
}

fn service_call(mut rest: &[u8]) -> Result<ServiceCall, RequestError> {
    let (service, call) = (number(&mut rest)?, number(&mut rest)?);
    let length = number(&mut rest)? as usize;
    let (encoding, payload) = rest.split_at_checked(length).ok_or(RequestError::Short)?;
    let encoding = std::str::from_utf8(encoding).map_err(|_| RequestError::Encoding)?;
    Ok(ServiceCall { service, call, encoding: encoding.to_owned(), payload: payload.to_vec() })
}

fn number(rest: &mut &[u8]) -> Result<u32, RequestError> {
    let (bytes, after) = rest.split_first_chunk().ok_or(RequestError::Short)?;
    *rest = after;
    Ok(u32::from_le_bytes(*bytes))
}
