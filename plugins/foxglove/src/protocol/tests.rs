//! Messages of clients, as npm's `@foxglove/ws-protocol` and others write them.

use serde_json::json;

use super::*;

fn text(message: &str) -> Result<Request, RequestError> {
    parse(message.as_bytes(), true)
}

#[test]
fn texts_are_read() {
    let subscribe = text(r#"{"op":"subscribe","subscriptions":[{"id":0,"channelId":3}]}"#);
    let subscriptions = vec![Subscription { id: 0, channel_id: 3 }];
    assert_eq!(subscribe.expect("valid"), Request::Subscribe { subscriptions });
    let unsubscribe = text(r#"{"op":"unsubscribe","subscriptionIds":[0]}"#).expect("valid");
    assert_eq!(unsubscribe, Request::Unsubscribe { subscription_ids: vec![0] });
    let get = text(r#"{"op":"getParameters","parameterNames":[]}"#).expect("valid");
    assert_eq!(get, Request::GetParameters { parameter_names: Vec::new(), id: None });
    let set = r#"{"op":"setParameters","id":"7",
        "parameters":[{"name":"speed","value":2,"type":"float64"},{"name":"paused"}]}"#;
    let parameter = |name: &str, value| Parameter { name: name.to_owned(), value };
    let parameters = vec![parameter("speed", json!(2)), parameter("paused", json!(null))];
    let id = Some("7".to_owned());
    assert_eq!(text(set).expect("valid"), Request::SetParameters { parameters, id });
    let asset = text(r#"{"op":"fetchAsset","uri":"package://x","requestId":4}"#).expect("valid");
    assert_eq!(asset, Request::FetchAsset { request_id: 4 });
    let advertise = r#"{"op":"advertise","channels":[{"id":1,"topic":"/a","encoding":"json"}]}"#;
    assert_eq!(text(advertise).expect("valid"), Request::Advertise {});
    let graph = text(r#"{"op":"subscribeConnectionGraph"}"#).expect("valid");
    assert_eq!(graph, Request::SubscribeConnectionGraph {});
}

#[test]
fn calls_are_read() {
    let mut call = vec![2];
    for number in [3_u32, 9, 4] {
        call.extend(number.to_le_bytes());
    }
    call.extend(b"json{}");
    let expected =
        ServiceCall { service: 3, call: 9, encoding: "json".to_owned(), payload: b"{}".to_vec() };
    assert_eq!(parse(&call, false).expect("valid"), Request::Call(expected));
    for length in 0..17 {
        assert!(parse(&call[..length], false).is_err(), "{length} bytes");
    }
    assert_eq!(parse(&[1, 0], false).expect("valid"), Request::Message);
}

#[test]
fn other_messages_are_refused_with_a_reason() {
    for (message, reason) in [
        ("", "EOF"),
        ("[]", "not a message"),
        ("{}", "op"),
        (r#"{"op":"selfDestruct"}"#, "selfDestruct"),
        (r#"{"op":"subscribe"}"#, "subscriptions"),
        (r#"{"op":"subscribe","subscriptions":[{"id":-1,"channelId":1}]}"#, "-1"),
        (r#"{"op":"unsubscribe","subscriptionIds":[4294967296]}"#, "4294967296"),
    ] {
        let error = text(message).expect_err(message).to_string();
        assert!(error.contains(reason), "{error}");
    }
    assert!(matches!(parse(&[9], false), Err(RequestError::Kind(9))));
    let mut call = vec![2; 9];
    call.extend(2_u32.to_le_bytes());
    call.extend([0xff, 0xff]);
    assert!(matches!(parse(&call, false), Err(RequestError::Encoding)));
}

#[test]
fn deep_nesting_is_refused() {
    let message = format!(
        r#"{{"op":"setParameters","parameters":[{{"name":"a","value":{}"#,
        "[".repeat(MOST_BYTES)
    );
    assert!(text(&message).is_err());
}
