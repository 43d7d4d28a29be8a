//! Messages of the server.

use bytes::{BufMut, BytesMut};
use data_encoding::BASE64;
use serde_json::{Value, json};
use tokio_tungstenite::tungstenite::Message;

use super::request::ServiceCall;
use crate::channel::Channel;
use crate::service::Service;

/// The first bytes of binary messages.
const MESSAGE_DATA: u8 = 1;
const TIME: u8 = 2;
const SERVICE_CALL: u8 = 3;
const FETCH_ASSET: u8 = 4;
/// The bytes before the data of a message.
const DATA_HEADER: usize = 13;
/// The state of a file that can't be had.
const ASSET_ERROR: u8 = 1;
/// The encoding of services.
pub(crate) const JSON: &str = "json";

/// The severity of a status.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Level {
    Warning = 1,
    Error = 2,
}

fn text(value: &Value) -> Message {
    Message::text(value.to_string())
}

/// The first message to a client, and to all when a run begins: `session` differs from run to run.
pub(crate) fn server_info(fleet: &str, session: &str, can_steer: bool) -> Message {
    let mut capabilities = vec!["time", "parameters", "parametersSubscribe"];
    if can_steer {
        capabilities.push("services");
    }
    text(&json!({
        "op": "serverInfo",
        "name": format!("Regatta, fleet {fleet}"),
        "capabilities": capabilities,
        "supportedEncodings": [JSON],
        "metadata": {"fleet": fleet, "regatta": env!("CARGO_PKG_VERSION")},
        "sessionId": session,
    }))
}

pub(crate) fn advertise() -> Message {
    let channels: Vec<_> = Channel::ALL.into_iter().map(channel).collect();
    text(&json!({"op": "advertise", "channels": channels}))
}

fn channel(channel: Channel) -> Value {
    json!({
        "id": channel.id(),
        "topic": channel.topic(),
        "encoding": "protobuf",
        "schemaName": channel.schema(),
        "schema": BASE64.encode(channel.descriptors()),
        "schemaEncoding": "protobuf",
    })
}

pub(crate) fn advertise_services() -> Message {
    let services: Vec<_> = Service::ALL.into_iter().map(service).collect();
    text(&json!({"op": "advertiseServices", "services": services}))
}

fn service(service: Service) -> Value {
    let kind = service.kind();
    json!({
        "id": service.id(),
        "name": service.name(),
        "type": kind,
        "request": definition(&format!("{kind}_Request"), &service.arguments()),
        "response": definition(&format!("{kind}_Response"), &Service::answer()),
    })
}

fn definition(name: &str, schema: &Value) -> Value {
    json!({
        "encoding": JSON,
        "schemaName": name,
        "schemaEncoding": "jsonschema",
        "schema": schema.to_string(),
    })
}

pub(crate) fn status(level: Level, message: &str) -> Message {
    text(&json!({"op": "status", "level": level as u8, "message": message}))
}

pub(crate) fn parameter_values(parameters: Vec<Value>, id: Option<&str>) -> Message {
    let mut message = json!({"op": "parameterValues", "parameters": parameters});
    if let Some(id) = id {
        message["id"] = id.into();
    }
    text(&message)
}

/// A message of a channel, as one of its subscribers gets it; its time is in nanoseconds.
pub(crate) fn message_data(subscription: u32, nanos: u64, data: &[u8]) -> Message {
    let mut message = BytesMut::with_capacity(DATA_HEADER + data.len());
    message.put_u8(MESSAGE_DATA);
    message.put_u32_le(subscription);
    message.put_u64_le(nanos);
    message.put_slice(data);
    Message::Binary(message.freeze())
}

/// The time of the server, in nanoseconds.
pub(crate) fn time(nanos: u64) -> Message {
    let mut message = BytesMut::new();
    message.put_u8(TIME);
    message.put_u64_le(nanos);
    Message::Binary(message.freeze())
}

/// The answer to a call, which has `answer` as its result.
pub(crate) fn call_answered(service: u32, call: u32, answer: &Value) -> Message {
    let mut message = BytesMut::new();
    message.put_u8(SERVICE_CALL);
    message.put_u32_le(service);
    message.put_u32_le(call);
    message.put_u32_le(JSON.len() as u32);
    message.put_slice(JSON.as_bytes());
    message.put_slice(answer.to_string().as_bytes());
    Message::Binary(message.freeze())
}

/// The answer to a call that can't be read.
pub(crate) fn call_failed(call: &ServiceCall, reason: &str) -> Message {
    text(&json!({
        "op": "serviceCallFailure",
        "serviceId": call.service,
        "callId": call.call,
        "message": reason,
    }))
}

/// The answer to a request for a file, of which there are none.
pub(crate) fn asset_refused(request: u32, reason: &str) -> Message {
    let mut message = BytesMut::new();
    message.put_u8(FETCH_ASSET);
    message.put_u32_le(request);
    message.put_u8(ASSET_ERROR);
    message.put_u32_le(reason.len() as u32);
    message.put_slice(reason.as_bytes());
    Message::Binary(message.freeze())
}
