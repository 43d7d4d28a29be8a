use std::io::{Read, Write};
use std::net::TcpStream;

use glam::Vec2;
use regatta_kit::private;
use serde_json::{Value, json};

use crate::order::State;
use crate::places::Place;
use crate::{Candidate, Client, OrderPool, OrderSettings, Places, PoolError, Vehicle, WebError};
use std::net::SocketAddr;
use std::sync::Arc;

const LOOPBACK: SocketAddr =
    SocketAddr::new(std::net::IpAddr::V4(std::net::Ipv4Addr::LOCALHOST), 0);

fn places() -> Arc<Places> {
    let place = |id| Place { id, name: format!("N{id}"), ..Place::default() };
    Arc::new(Places::new((0..4).map(place).collect()))
}

fn open(settings: &OrderSettings) -> Result<OrderPool, PoolError> {
    OrderPool::open(settings, places(), 1, 0.0)
}

fn pool() -> OrderPool {
    open(&OrderSettings { http: Some(LOOPBACK), ..OrderSettings::default() }).expect("a pool")
}

fn address(pool: &OrderPool) -> SocketAddr {
    pool.http_address().expect("an address")
}

/// Sends a request and returns the status and the body.
fn raw(address: SocketAddr, request: &[u8]) -> (u16, String) {
    let mut stream = TcpStream::connect(address).expect("connected");
    // The server may answer before it has read everything.
    let _ = stream.write_all(request);
    let mut response = Vec::new();
    let _ = stream.read_to_end(&mut response);
    let response = String::from_utf8_lossy(&response).into_owned();
    let status = response.split(' ').nth(1).and_then(|status| status.parse().ok()).unwrap_or(0);
    (status, response.split_once("\r\n\r\n").map_or("", |(_, body)| body).to_owned())
}

fn send(address: SocketAddr, method: &str, path: &str, headers: &str, body: &str) -> (u16, Value) {
    let headers = format!("{}{headers}", own_token());
    send_as(address, method, path, &headers, body)
}

/// The header with this user's token.
fn own_token() -> String {
    format!("Authorization: Bearer {}\r\n", private::token().expect("a token"))
}

/// Sends a request with these headers alone.
fn send_as(
    address: SocketAddr,
    method: &str,
    path: &str,
    headers: &str,
    body: &str,
) -> (u16, Value) {
    let length = body.len();
    let head = format!(
        "{method} {path} HTTP/1.0\r\nHost: {address}\r\nContent-Length: {length}\r\n{headers}\r\n"
    );
    let (status, body) = raw(address, (head + body).as_bytes());
    (status, serde_json::from_str(&body).unwrap_or(Value::String(body)))
}

fn get(address: SocketAddr, path: &str) -> (u16, Value) {
    send(address, "GET", path, "", "")
}

fn post(address: SocketAddr, path: &str, body: &str) -> (u16, Value) {
    send(address, "POST", path, "", body)
}

/// Ticks until a request on another thread is answered.
fn ticking<T: Send>(pool: &mut OrderPool, request: impl FnOnce() -> T + Send) -> T {
    std::thread::scope(|scope| {
        let request = scope.spawn(request);
        while !request.is_finished() {
            pool.take_requests(1.0);
            pool.publish(1.0);
            std::thread::yield_now();
        }
        request.join().expect("an answer")
    })
}

/// Asks until an answer is as expected.
fn eventually(address: SocketAddr, path: &str, is_expected: impl Fn(&Value) -> bool) -> Value {
    loop {
        let (_, value) = get(address, path);
        if is_expected(&value) {
            return value;
        }
    }
}

const ORDER: &str = r#"{"destinations": [{"locationName": "N1", "operation": "pick", "dwell": 2}, {"locationName": 2}]}"#;

#[test]
fn an_order_is_posted_and_followed() {
    let mut pool = pool();
    let address = address(&pool);
    let (status, order) = post(address, "/v1/transportOrders/my%20order", ORDER);
    assert_eq!(
        (status, &order["name"], &order["state"]),
        (201, &json!("my order"), &json!("created"))
    );
    assert_eq!(get(address, "/v1/transportOrders/my%20order").1["priority"], json!(0));
    pool.take_requests(3.0);
    pool.assign(3.0, &[Candidate { robot: 5, ..Candidate::default() }], &|_, _| Some(1.0));
    pool.arrived(5, 4.0);
    let (state, position) = ("handling", Vec2::new(1.0, 2.5));
    let vehicle = Vehicle {
        robot: 5,
        state,
        activity: state,
        node: Some(1),
        edge: Some(7),
        position,
        ..Vehicle::default()
    };
    pool.show_vehicle(Vehicle { energy_level: Some(80), ..vehicle });
    pool.publish(4.0);
    let order =
        eventually(address, "/v1/transportOrders/my%20order", |order| order["state"] == "handling");
    assert_eq!(
        (&order["processingVehicle"], &order["destinations"][0]["state"]),
        (&json!("5"), &json!("handling"))
    );
    assert_eq!(order["history"][1], json!({"time": 3.0, "event": "assigned", "robot": 5}));
    let vehicle = json!({"name": "5", "state": "handling", "activity": "handling", "currentPosition": "N1", "edge": 7,
        "position": [1.0, 2.5], "energyLevel": 80, "transportOrder": "my order"});
    assert_eq!(get(address, "/v1/vehicles/5"), (200, vehicle.clone()));
    assert_eq!(get(address, "/v1/vehicles"), (200, json!([vehicle])));
    assert_eq!(get(address, "/v1/status").1["openOrders"], json!(1));
    assert_eq!(get(address, "/v1/transportOrders?state=open").1.as_array().map(Vec::len), Some(1));
    assert_eq!(get(address, "/v1/transportOrders?state=finished").1, json!([]));
}

#[test]
fn each_error_has_its_status_and_its_reason() {
    let pool = pool();
    let address = address(&pool);
    assert_eq!(post(address, "/v1/transportOrders/a", ORDER).0, 201);
    let unknown = r#"{"destinations": [{"locationName": "Mars"}]}"#;
    let many = format!("[{ORDER}, {unknown}]");
    let large = format!(r#"{{"name": "{}"}}"#, "x".repeat(70_000));
    for (path, body, status, reason) in [
        ("/v1/transportOrders/a", ORDER, 409, "there is an order `a` already"),
        ("/v1/transportOrders/b", unknown, 422, "stop 1 is at `Mars`"),
        ("/v1/transportOrders", &many, 422, "order 2: stop 1 is at `Mars`"),
        ("/v1/transportOrders/b", "{", 400, "not valid"),
        ("/v1/transportOrders/b", r#"{"destinations": [], "colour": 1}"#, 400, "colour"),
        ("/v1/transportOrders/b", r#"{"destinations": [], "priority": 256}"#, 400, "256"),
        ("/v1/transportOrders/b", r#"{"destinations": [], "name": "c"}"#, 400, "another name"),
        ("/v1/transportOrders/b", "\u{0}", 400, "not valid"),
        ("/v1/transportOrders/b", &large, 413, "more than 65536 bytes"),
        ("/v1/transportOrders/%ff", ORDER, 400, "UTF-8"),
        ("/v1/transportOrders/load:1-1", ORDER, 422, "generated"),
        ("/v1/transportOrders/b/withdrawal", "", 404, "no order `b`"),
        ("/v1/vehicles", "", 405, "other methods"),
        ("/v2", "", 404, "no such path"),
    ] {
        let (found, answer) = post(address, path, body);
        let text =
            answer["error"].as_str().unwrap_or_else(|| panic!("{path} {body:.60}: {answer}"));
        assert_eq!((found, text.contains(reason)), (status, true), "{path} {body:.60}: {answer}");
    }
    assert_eq!(get(address, "/v1/transportOrders/b").0, 404);
    assert_eq!(get(address, "/v1/vehicles/x").0, 404);
    assert_eq!(get(address, "/v1/transportOrders?state=lost").0, 400);
    assert_eq!(
        get(address, "/v1/transportOrders").1.as_array().map(Vec::len),
        Some(1),
        "no other order is kept"
    );
    let chunked = format!(
        "POST /v1/transportOrders/b HTTP/1.1\r\nHost: {address}\r\nConnection: close\r\n{}Transfer-Encoding: chunked\r\n\r\n20000\r\n{}\r\n0\r\n\r\n",
        own_token(),
        "x".repeat(0x20000)
    );
    assert_eq!(raw(address, chunked.as_bytes()).0, 413);
    assert_eq!(raw(address, b"\x16\x03\x01\r\n\r\n").0, 400);
}

#[test]
fn pages_of_other_sites_and_requests_without_the_token_are_refused() {
    let pool = pool();
    let address = address(&pool);
    assert_eq!(send_as(address, "POST", "/v1/transportOrders/a", "", ORDER).0, 401);
    let brief = own_token().replace("Bearer", "bearer");
    assert_eq!(send_as(address, "GET", "/v1/status", &brief, "").0, 200);
    assert_eq!(
        send(address, "POST", "/v1/transportOrders/a", "Origin: http://evil.example\r\n", ORDER).0,
        403
    );
    let own = format!("Origin: http://{address}\r\n");
    assert_eq!(send(address, "POST", "/v1/transportOrders/a", &own, ORDER).0, 201);
    assert_eq!(raw(address, b"GET /v1/status HTTP/1.0\r\nHost: evil.example\r\n\r\n").0, 403);
}

#[test]
fn withdrawals_are_answered_by_the_book() {
    let mut pool = pool();
    let address = address(&pool);
    for name in ["a", "b"] {
        assert_eq!(post(address, &format!("/v1/transportOrders/{name}"), ORDER).0, 201);
    }
    let withdraw = |path: &'static str| move || post(address, path, "");
    assert_eq!(ticking(&mut pool, withdraw("/v1/transportOrders/a/withdrawal")).0, 200);
    eventually(address, "/v1/transportOrders/a", |order| order["state"] == "cancelled");
    let (status, answer) = ticking(&mut pool, withdraw("/v1/transportOrders/a/withdrawal"));
    assert_eq!((status, &answer["error"]), (409, &json!("the order is over")));
    pool.assign(1.0, &[Candidate { robot: 0, ..Candidate::default() }], &|_, _| Some(1.0));
    assert!(pool.arrived(0, 1.0).is_some() && pool.handled(0, 1.0).is_some());
    assert_eq!(ticking(&mut pool, withdraw("/v1/transportOrders/b/withdrawal")).0, 409);
    assert_eq!(
        ticking(&mut pool, withdraw("/v1/transportOrders/b/withdrawal?immediate=true")).0,
        200
    );
    assert_eq!(pool.order_of(0), None);
}

#[test]
fn ten_thousand_orders_at_once_are_all_kept() {
    let folder = tempfile::tempdir().expect("a folder");
    let settings = OrderSettings {
        http: Some(LOOPBACK),
        store: Some(folder.path().join("orders.db")),
        ..OrderSettings::default()
    };
    let mut pool = open(&settings).expect("a pool");
    let address = address(&pool);
    let client = |client: usize| {
        let mut stream = TcpStream::connect(address).expect("connected");
        let token = own_token();
        let requests: Vec<u8> = (0..500)
            .flat_map(|number| {
                let length = ORDER.len();
                let path = format!("/v1/transportOrders/order-{client}-{number}");
                format!("POST {path} HTTP/1.1\r\nHost: {address}\r\n{token}Content-Length: {length}\r\n\r\n{ORDER}")
                    .into_bytes()
            })
            .collect();
        let mut reader = stream.try_clone().expect("a second handle");
        let sender = std::thread::spawn(move || stream.write_all(&requests).expect("sent"));
        let (mut answers, mut bytes, mut buffer) = (0, Vec::new(), [0; 65_536]);
        while answers < 500 {
            let count = reader.read(&mut buffer).expect("answers");
            assert!(count > 0, "the connection has ended after {answers}");
            bytes.extend_from_slice(&buffer[..count]);
            answers = String::from_utf8_lossy(&bytes).matches("HTTP/1.1 201").count();
        }
        sender.join().expect("sent");
    };
    std::thread::scope(|scope| {
        (0..20).for_each(|number| drop(scope.spawn(move || client(number))))
    });
    pool.take_requests(1.0);
    assert_eq!(pool.open_orders().count(), 10_000);
    drop(pool);
    assert_eq!(
        open(&OrderSettings { http: None, ..settings }).expect("a pool").open_orders().count(),
        10_000
    );
}

#[test]
fn names_of_earlier_runs_are_taken() {
    let folder = tempfile::tempdir().expect("a folder");
    let store = Some(folder.path().join("orders.db"));
    let settings = OrderSettings { http: Some(LOOPBACK), store, ..OrderSettings::default() };
    let mut pool = open(&settings).expect("a pool");
    let first = address(&pool);
    assert_eq!(post(first, "/v1/transportOrders/a", ORDER).0, 201);
    assert_eq!(post(first, "/v1/transportOrders", ORDER).1["name"], json!("order-1"));
    assert_eq!(ticking(&mut pool, || post(first, "/v1/transportOrders/a/withdrawal", "")).0, 200);
    drop(pool);
    let mut pool = open(&settings).expect("a pool");
    let second = address(&pool);
    assert_eq!(post(second, "/v1/transportOrders/a", ORDER).0, 409);
    assert_eq!(
        ticking(&mut pool, || post(second, "/v1/transportOrders/order-1/withdrawal", "")).0,
        200
    );
    drop(pool);
    let pool = open(&settings).expect("a pool");
    assert_eq!(
        post(address(&pool), "/v1/transportOrders", ORDER).1["name"],
        json!("order-2"),
        "no name is taken again"
    );
}

#[test]
fn orders_that_are_over_are_found_after_a_restart() {
    let folder = tempfile::tempdir().expect("a folder");
    let settings = OrderSettings {
        http: Some(LOOPBACK),
        store: Some(folder.path().join("orders.db")),
        ..OrderSettings::default()
    };
    let mut pool = open(&settings).expect("a pool");
    let first = address(&pool);
    for name in ["a", "b", "c d", "e"] {
        assert_eq!(post(first, &Client::order_path(name), ORDER).0, 201);
    }
    for name in ["a", "c d"] {
        let path = format!("{}/withdrawal", Client::order_path(name));
        assert_eq!(ticking(&mut pool, || post(first, &path, "")).0, 200);
    }
    let before =
        eventually(first, "/v1/transportOrders?state=cancelled", |orders| orders[1].is_object());
    drop(pool);
    let mut pool = open(&settings).expect("a pool");
    let second = address(&pool);
    assert_eq!(get(second, "/v1/transportOrders/a"), (200, before[0].clone()));
    assert_eq!(get(second, "/v1/transportOrders?state=cancelled"), (200, before));
    let names = |query: &str| {
        let (status, orders) = get(second, &format!("/v1/transportOrders?{query}"));
        assert_eq!(status, 200, "{query}: {orders}");
        orders
            .as_array()
            .expect("orders")
            .iter()
            .map(|order| order["name"].clone())
            .collect::<Vec<_>>()
    };
    assert_eq!(names(""), ["a", "b", "c d", "e"]);
    assert_eq!(names("state=open"), ["b", "e"]);
    assert_eq!(names("state=finished"), [""; 0]);
    assert_eq!(names("state=waiting"), ["b", "e"]);
    assert_eq!(
        (names("limit=3"), names("limit=3&after=c%20d")),
        (vec![json!("a"), json!("b"), json!("c d")], vec![json!("e")])
    );
    let (status, answer) =
        ticking(&mut pool, || post(second, "/v1/transportOrders/a/withdrawal", ""));
    assert_eq!((status, &answer["error"]), (409, &json!("the order is over")));
    assert_eq!(get(second, "/v1/transportOrders?limit=0").0, 400);
}

#[test]
fn the_time_of_creation_is_the_same_everywhere() {
    let folder = tempfile::tempdir().expect("a folder");
    let settings = OrderSettings {
        http: Some(LOOPBACK),
        store: Some(folder.path().join("orders.db")),
        ..OrderSettings::default()
    };
    let mut pool = OrderPool::open(&settings, places(), 1, 2.8).expect("a pool");
    let first = address(&pool);
    let answer = post(first, "/v1/transportOrders/a", ORDER).1;
    assert_eq!(answer["created"], json!(2.8), "the time of the first frame, before the first tick");
    assert_eq!(post(first, "/v1/transportOrders/killed", ORDER).0, 201);
    pool.take_requests(2.9);
    pool.publish(2.9);
    let order = eventually(first, "/v1/transportOrders/a", |order| order["state"] == "waiting");
    assert_eq!((&order["created"], &order["history"][0]["time"]), (&json!(2.8), &json!(2.8)));
    drop(pool);
    let pool = OrderPool::open(&settings, places(), 1, 50.0).expect("a pool");
    let (_, order) = get(address(&pool), "/v1/transportOrders/a");
    assert_eq!((&order["created"], &order["history"][0]["time"]), (&json!(2.8), &json!(2.8)));
}

#[test]
fn vehicles_that_only_move_on_are_no_events_and_those_that_leave_are_gone() {
    let mut pool = pool();
    let address = address(&pool);
    let mut stream = TcpStream::connect(address).expect("connected");
    stream
        .write_all(
            format!("GET /v1/sse HTTP/1.0\r\nHost: {address}\r\n{}\r\n", own_token()).as_bytes(),
        )
        .expect("sent");
    let mut text = String::new();
    let mut read_until = |end: &str| {
        let mut buffer = [0; 4096];
        while !text.contains(end) {
            let count = stream.read(&mut buffer).expect("events");
            assert!(count > 0, "{text}");
            text.push_str(&String::from_utf8_lossy(&buffer[..count]));
        }
        text.clone()
    };
    read_until(": changes");
    let mut show = |secs: f64, robot, state, x| {
        pool.show_vehicle(Vehicle {
            robot,
            state,
            position: Vec2::new(x, 0.0),
            ..Vehicle::default()
        });
        pool.publish(secs);
    };
    show(1.0, 3, "driving", 1.0);
    show(2.0, 3, "driving", 2.0);
    show(3.0, 4, "absent", 0.0);
    eventually(address, "/v1/vehicles/3", |vehicle| vehicle["position"][0] == 2.0);
    show(4.0, 3, "absent", 0.0);
    let text = read_until("absent");
    assert_eq!(text.matches("event: vehicle").count(), 2, "{text}");
    assert_eq!(get(address, "/v1/vehicles"), (200, json!([])));
}

#[test]
fn changes_come_as_server_sent_events() {
    let mut pool = pool();
    let address = address(&pool);
    let mut stream = TcpStream::connect(address).expect("connected");
    stream
        .write_all(
            format!("GET /v1/sse HTTP/1.1\r\nHost: {address}\r\n{}\r\n", own_token()).as_bytes(),
        )
        .expect("sent");
    let mut text = String::new();
    let mut read_until = |end: &str| {
        let mut buffer = [0; 4096];
        while !text.contains(end) {
            let count = stream.read(&mut buffer).expect("events");
            assert!(count > 0, "{text}");
            text.push_str(&String::from_utf8_lossy(&buffer[..count]));
        }
        text.clone()
    };
    assert!(read_until(": changes").contains("text/event-stream"));
    assert_eq!(post(address, "/v1/transportOrders/a", ORDER).0, 201);
    pool.take_requests(1.0);
    pool.show_vehicle(Vehicle { robot: 3, state: "idle", ..Vehicle::default() });
    pool.publish(1.0);
    let text = read_until(
        "event: vehicle\ndata: {\"activity\":\"\",\"currentPosition\":null,\"edge\":null",
    );
    assert!(
        text.contains("event: transportOrder\ndata: {") && text.contains("\"state\":\"waiting\""),
        "{text}"
    );
}

#[test]
fn other_addresses_need_a_token() {
    let any = SocketAddr::from(([0, 0, 0, 0], 0));
    let settings = OrderSettings { http: Some(any), ..OrderSettings::default() };
    assert!(matches!(settings.check(), Err(WebError::NeedsToken(_))), "before there is a world");
    let error = open(&settings).expect_err("no token").to_string();
    assert!(error.contains("--token-file"), "{error}");
    let folder = tempfile::tempdir().expect("a folder");
    let token_file = Some(folder.path().join("token"));
    let settings = OrderSettings { token_file: token_file.clone(), ..settings };
    assert!(open(&settings).is_err(), "no such file");
    std::fs::write(folder.path().join("token"), "short\n").expect("written");
    assert!(open(&settings).expect_err("too short").to_string().contains("at least 8"));
    std::fs::write(folder.path().join("token"), "secret-token\n").expect("written");
    let pool = open(&settings).expect("a pool");
    let local = SocketAddr::from(([127, 0, 0, 1], address(&pool).port()));
    for (header, status) in [
        ("", 401),
        (&own_token(), 401),
        ("Authorization: Bearer secret-tokem\r\n", 401),
        ("Authorization: Bearer secret-token2\r\n", 401),
        ("Authorization: Bearer secret-token\r\n", 200),
    ] {
        assert_eq!(send_as(local, "GET", "/v1/status", header, "").0, status, "{header}");
    }
    let (status, document) = get(local, "/openapi.json");
    assert_eq!((status, &document["openapi"]), (200, &json!("3.1.0")));
    assert!(get(local, "/").1.as_str().is_some_and(|page| page.contains("<h1>Fleet manager")));
}

#[test]
fn an_address_in_use_is_one_line() {
    let pool = pool();
    let settings = OrderSettings { http: Some(address(&pool)), ..OrderSettings::default() };
    let error = open(&settings).expect_err("in use").to_string();
    assert!(error.contains("choose another port with --http") && !error.contains('\n'), "{error}");
}

#[test]
fn the_client_gets_values_and_reasons() {
    use crate::ClientError;
    let pool = pool();
    let client = Client::new(&format!("http://{}/", address(&pool)), None).expect("an address");
    let order: Value = serde_json::from_str(ORDER).expect("an order");
    let path = Client::order_path("Größe 1%");
    assert_eq!(client.post(&path, &order).expect("kept")["name"], json!("Größe 1%"));
    assert_eq!(client.get(&path).expect("there")["state"], json!("created"));
    let error = client.post(&path, &order).expect_err("twice");
    assert!(
        matches!(&error, ClientError::Refused { status: 409, reason } if reason.contains("already")),
        "{error}"
    );
    drop(pool);
    assert!(matches!(client.get(&path), Err(ClientError::Connect { .. })));
    for url in ["", "http://here", "https://127.0.0.1:1", "127.0.0.1:1\r\n", "127.0.0.1:99999"] {
        assert!(matches!(Client::new(url, None), Err(ClientError::Url(_))), "{url}");
    }
}

#[test]
fn the_document_describes_each_path_with_its_answers() {
    let pool = pool();
    let (status, document) = get(address(&pool), "/openapi.json");
    assert_eq!((status, &document["openapi"]), (200, &json!("3.1.0")));
    let mut found = Vec::new();
    for (path, item) in document["paths"].as_object().expect("paths") {
        for (method, operation) in item.as_object().expect("methods") {
            let answers = operation["responses"].as_object().expect("answers");
            let statuses: Vec<_> = answers.keys().map(String::as_str).collect();
            found.push(format!("{method} {path}: {}", statuses.join(" ")));
        }
    }
    assert_eq!(
        found,
        [
            "get /v1/sse: 200 503",
            "get /v1/status: 200",
            "get /v1/transportOrders: 200 400",
            "post /v1/transportOrders: 201 400 409 413 422 507",
            "get /v1/transportOrders/{name}: 200 404",
            "post /v1/transportOrders/{name}: 201 400 409 413 422 507",
            "post /v1/transportOrders/{name}/withdrawal: 200 202 404 409",
            "get /v1/vehicles: 200",
            "get /v1/vehicles/{name}: 200 404",
        ]
    );
    let components = &document["components"];
    assert_eq!(components["securitySchemes"]["bearer"]["scheme"], json!("bearer"));
    let draft = &components["schemas"]["OrderDraft"];
    assert_eq!(draft["required"], json!(["destinations"]));
    assert_eq!(draft["additionalProperties"], json!(false));
    assert_eq!(draft["properties"]["destinations"]["maxItems"], json!(1000));
    for field in ["earliestStart", "deadline"] {
        assert_eq!(draft["properties"][field]["maximum"].as_f64(), Some(1e9), "{field}");
    }
    let name = &draft["properties"]["name"]["oneOf"][0];
    assert_eq!(name["maxLength"], json!(128), "{draft}");
    let name = name["pattern"].as_str().expect("a pattern");
    assert!(name.contains(r"\u{2028}-\u{202e}"), "{name}");
    let stop = &components["schemas"]["Destination"];
    assert_eq!(stop["required"], json!(["locationName"]));
    assert_eq!(stop["properties"]["dwell"]["maximum"].as_f64(), Some(1e9));
    let operation = stop["properties"]["operation"]["pattern"].as_str().expect("a pattern");
    for name in crate::Action::NAMES {
        assert!(name.parse::<crate::Action>().is_ok(), "{name}");
    }
    assert!(operation.starts_with("^([nN][oO][nN][eE]|"), "{operation}");
    let order = &components["schemas"]["TransportOrder"]["properties"];
    assert_eq!(order["state"]["enum"], json!(State::NAMES));
    let vehicle = &components["schemas"]["Vehicle"]["properties"];
    assert_eq!(vehicle["activity"]["enum"][1], json!("fetching"));
    assert_eq!(vehicle["position"]["maxItems"], json!(2));
}

#[test]
fn a_page_of_long_orders_comes_in_pieces_and_is_whole() {
    let pool = pool();
    let address = address(&pool);
    let stops = vec![r#"{"locationName": "N1"}"#; 100].join(",");
    let orders = vec![format!(r#"{{"destinations": [{stops}]}}"#); 1_200].join(",");
    let (status, kept) = post(address, "/v1/transportOrders", &format!("[{orders}]"));
    assert_eq!((status, kept.as_array().map(Vec::len)), (201, Some(1_200)));
    let (_, first) = get(address, "/v1/transportOrders");
    let first = first.as_array().expect("a page").clone();
    let last = first.last().expect("orders")["name"].as_str().expect("a name").to_owned();
    let (_, rest) = get(address, &format!("/v1/transportOrders?after={last}"));
    let all = [&first[..], rest.as_array().expect("a page")].concat();
    assert_eq!((first.len(), all.len()), (1_000, 1_200));
    assert!(all.is_sorted_by_key(|order| order["name"].as_str()));
    assert_eq!(all[7]["destinations"].as_array().map(Vec::len), Some(100));
    assert_eq!(get(address, "/v1/transportOrders?limit=1001").0, 400);
    assert_eq!(get(address, "/v1/transportOrders?state=failed"), (200, json!([])));
}

#[test]
fn names_that_mislead_are_refused() {
    let pool = pool();
    for name in ["..", ".", "a..b", "x\u{202e}y", "a\u{200b}", "\u{feff}a", "a\u{2066}", "a\tb"] {
        let draft = json!({"name": name, "destinations": [{"locationName": "N1"}]}).to_string();
        let (status, answer) = post(address(&pool), "/v1/transportOrders", &draft);
        assert_eq!(status, 422, "{name:?}: {answer}");
    }
    let draft = r#"{"name": "Größe 1.0 – 中", "destinations": [{"locationName": "N1"}]}"#;
    assert_eq!(post(address(&pool), "/v1/transportOrders", draft).0, 201);
}

#[cfg(unix)]
#[test]
fn a_socket_serves_its_user_without_a_token_and_nobody_else() {
    use std::os::unix::fs::PermissionsExt;

    let fleet = format!("orders-socket-{}", std::process::id()).parse().expect("a name");
    let mut settings = OrderSettings::default();
    settings.serve_at_socket_of(&fleet);
    let path = settings.socket.clone().expect("a socket");
    let pool = open(&settings).expect("a pool");
    assert_eq!(pool.http_address(), None);
    for (path, mode) in [(path.as_path(), 0o600), (path.parent().expect("a folder"), 0o700)] {
        let permissions = path.metadata().expect("there").permissions();
        assert_eq!(permissions.mode() & 0o777, mode, "{}", path.display());
    }
    let client = Client::of_fleet(&fleet).expect("a client");
    assert_eq!(client.get("/v1/status").expect("an answer")["openOrders"], json!(0));
    drop(pool);
    let error = client.get("/v1/status").expect_err("no manager").to_string();
    assert!(error.contains("no fleet manager answers on"), "{error}");
}
