//! The routes of the web API.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::mpsc::Sender;
use std::time::Duration;

use axum::body::{Body, Bytes, to_bytes};
use axum::extract::{Path, RawQuery, Request as HttpRequest, State};
use axum::http::header::{AUTHORIZATION, CACHE_CONTROL, CONTENT_TYPE, HOST, ORIGIN};
use axum::http::{HeaderMap, StatusCode};
use axum::middleware::{Next, from_fn_with_state};
use axum::response::{IntoResponse, Response};
use axum::routing::{get, post};
use axum::{Router, extract::rejection::PathRejection};
use serde::de::DeserializeOwned;
use serde_json::{Value, json};
use tokio::sync::{Semaphore, oneshot};
use tokio::time::timeout;

use super::board::{Board, Refusal};
use super::events;
use super::query::{page, parameter};
use crate::tasks::desk::{Reply, Request, WithdrawError};
use crate::tasks::draft::{DraftError, OrderDraft};
use crate::tasks::order::{NewOrder, OrderName};
use crate::tasks::store::{Archive, InsertError, Job, StoreError};

/// The largest body of one order, in bytes.
const MAX_ORDER_BYTES: usize = 64 << 10;
/// The largest body of many orders, in bytes.
const MAX_ORDERS_BYTES: usize = 16 << 20;
/// The longest time for the body of a request.
const BODY_TIMEOUT: Duration = Duration::from_secs(20);
/// How long a withdrawal waits for the manager's next tick: a paused fleet has none.
const TICK_TIMEOUT: Duration = Duration::from_secs(2);
/// The largest number of readers of events.
const MAX_READERS: usize = 64;

/// What the handlers work with.
pub(super) struct Desk {
    board: Arc<Board>,
    archive: Option<Arc<Archive>>,
    jobs: Option<Sender<Job>>,
    requests: Sender<Request>,
    token: Option<String>,
    readers: Arc<Semaphore>,
}

impl Desk {
    pub(super) fn new(
        board: Arc<Board>,
        archive: Option<Archive>,
        jobs: Option<Sender<Job>>,
        requests: Sender<Request>,
        token: Option<String>,
    ) -> Arc<Self> {
        let archive = archive.map(Arc::new);
        Arc::new(Self {
            board,
            archive,
            jobs,
            requests,
            token,
            readers: Arc::new(Semaphore::new(MAX_READERS)),
        })
    }
}

impl Desk {
    /// Does something that may take long, on a thread of its own.
    async fn beside<T: Send + 'static>(
        &self,
        work: impl FnOnce(&Board, Option<&Archive>) -> Result<T, StoreError> + Send + 'static,
    ) -> Result<T, Failure> {
        let (board, archive) = (self.board.clone(), self.archive.clone());
        let done = tokio::task::spawn_blocking(move || work(&board, archive.as_deref())).await;
        let error = |reason: String| Failure(StatusCode::INTERNAL_SERVER_ERROR, reason);
        done.map_err(|reason| error(reason.to_string()))?
            .map_err(|reason| error(reason.to_string()))
    }
}

/// An error of a request: its status and its reason, as JSON.
struct Failure(StatusCode, String);

impl IntoResponse for Failure {
    fn into_response(self) -> Response {
        json_response(self.0, &json!({"error": self.1}))
    }
}

type Answer = Result<Response, Failure>;

fn json_response(status: StatusCode, value: &Value) -> Response {
    (status, [(CONTENT_TYPE, "application/json")], value.to_string()).into_response()
}

pub(super) fn router(desk: Arc<Desk>) -> Router {
    let api = Router::new()
        .route("/v1/transportOrders", get(orders).post(post_orders))
        .route("/v1/transportOrders/{name}", get(order).post(post_order))
        .route("/v1/transportOrders/{name}/withdrawal", post(withdraw))
        .route("/v1/vehicles", get(vehicles))
        .route("/v1/vehicles/{name}", get(vehicle))
        .route("/v1/status", get(status))
        .route("/v1/sse", get(sse))
        .fallback(|| async {
            Failure(StatusCode::NOT_FOUND, "there is no such path; see /openapi.json".to_owned())
        })
        .method_not_allowed_fallback(|| async {
            Failure(
                StatusCode::METHOD_NOT_ALLOWED,
                "this path has other methods; see /openapi.json".to_owned(),
            )
        })
        .layer(from_fn_with_state(desk.clone(), guard));
    let openapi = || async { ([(CONTENT_TYPE, "application/json")], include_str!("openapi.json")) };
    let page =
        || async { ([(CONTENT_TYPE, "text/html; charset=utf-8")], include_str!("page.html")) };
    api.route("/openapi.json", get(openapi)).route("/", get(page)).with_state(desk)
}

/// Lets requests pass that have the token. Without one, it refuses those that a web page of another
/// site made a browser send.
async fn guard(State(desk): State<Arc<Desk>>, request: HttpRequest, next: Next) -> Response {
    let headers = request.headers();
    let refusal = match &desk.token {
        Some(token) if !has_token(headers, token) => Some((
            StatusCode::UNAUTHORIZED,
            "the header `Authorization: Bearer TOKEN` is missing or wrong",
        )),
        None if is_foreign(headers) => {
            Some((StatusCode::FORBIDDEN, "pages of other sites may not send requests"))
        }
        _ => None,
    };
    match refusal {
        Some((status, reason)) => Failure(status, reason.to_owned()).into_response(),
        None => next.run(request).await,
    }
}

fn has_token(headers: &HeaderMap, token: &str) -> bool {
    let given = headers
        .get(AUTHORIZATION)
        .and_then(|value| value.as_bytes().strip_prefix(b"Bearer "))
        .unwrap_or(b"");
    // The time must not tell how much of it is right.
    let difference =
        given.iter().zip(token.bytes()).fold(0, |difference, (a, b)| difference | (a ^ b));
    given.len() == token.len() && difference == 0
}

fn is_foreign(headers: &HeaderMap) -> bool {
    let text = |name| headers.get(name).and_then(|value| value.to_str().ok());
    let host = text(HOST).unwrap_or("localhost");
    let name = host.rsplit_once(':').map_or(host, |(name, _)| name);
    let is_local =
        name == "localhost" || name.trim_matches(['[', ']']).parse::<std::net::IpAddr>().is_ok();
    !is_local
        || headers
            .get(ORIGIN)
            .is_some_and(|origin| origin.as_bytes() != format!("http://{host}").as_bytes())
}

/// Returns the name in a path.
fn name_of(path: Result<Path<String>, PathRejection>) -> Result<String, Failure> {
    path.map(|Path(name)| name).map_err(|error| Failure(StatusCode::BAD_REQUEST, error.to_string()))
}

async fn orders(State(desk): State<Arc<Desk>>, RawQuery(query): RawQuery) -> Answer {
    let page = page(query.as_deref()).map_err(|reason| Failure(StatusCode::BAD_REQUEST, reason))?;
    // Answers may be large, and so they are made beside the server's thread.
    let text = desk.beside(move |board, archive| {
        // The store first: an order that is forgotten in between is in one of both.
        let stored = archive
            .map_or(Ok(Vec::new()), |archive| archive.page(&page, |name| board.has(name)))?;
        let shown: BTreeMap<_, _> = stored.into_iter().chain(board.orders(&page)).collect();
        Ok(Value::Array(shown.into_values().take(page.limit).collect()).to_string())
    });
    Ok(([(CONTENT_TYPE, "application/json")], text.await?).into_response())
}

async fn order(State(desk): State<Arc<Desk>>, name: Result<Path<String>, PathRejection>) -> Answer {
    let name = name_of(name)?;
    let order = find(&desk, &name).await?;
    Ok(json_response(StatusCode::OK, &order))
}

/// Finds an order, also one that only the store has.
async fn find(desk: &Desk, text: &str) -> Result<Value, Failure> {
    let name = OrderName::stored(text).map_err(|_| unknown_order(text))?;
    let shown = desk.board.order(&name);
    let found = match shown {
        Some(order) => Some(order),
        None => {
            desk.beside(move |_, archive| archive.map_or(Ok(None), |archive| archive.order(&name)))
                .await?
        }
    };
    found.ok_or_else(|| unknown_order(text))
}

fn unknown_order(name: &str) -> Failure {
    Failure(StatusCode::NOT_FOUND, format!("there is no order `{}`", name.escape_debug()))
}

async fn post_order(
    State(desk): State<Arc<Desk>>,
    name: Result<Path<String>, PathRejection>,
    body: Body,
) -> Answer {
    let name = name_of(name)?;
    let mut draft: OrderDraft = read(body, MAX_ORDER_BYTES).await?;
    if draft.name.as_ref().is_some_and(|given| *given != name) {
        return Err(Failure(
            StatusCode::BAD_REQUEST,
            "the body has another name than the path".to_owned(),
        ));
    }
    draft.name = Some(name);
    let orders =
        keep(&desk, vec![check(&desk, &draft).map_err(|error| refused(&error, None))?]).await?;
    Ok(json_response(StatusCode::CREATED, orders.first().unwrap_or(&Value::Null)))
}

/// A body with one order, which may have no name, or a list of them.
#[derive(serde::Deserialize)]
#[serde(transparent)]
struct Orders(Value);

async fn post_orders(State(desk): State<Arc<Desk>>, body: Body) -> Answer {
    let Orders(value) = read(body, MAX_ORDERS_BYTES).await?;
    let is_list = value.is_array();
    let drafts: Vec<OrderDraft> =
        serde_json::from_value(if is_list { value } else { Value::Array(vec![value]) })
            .map_err(|error| malformed(&error))?;
    let checked = drafts.iter().enumerate().map(|(index, draft)| {
        check(&desk, draft).map_err(|error| refused(&error, is_list.then_some(index)))
    });
    let orders = keep(&desk, checked.collect::<Result<_, _>>()?).await?;
    let answer =
        if is_list { Value::Array(orders) } else { orders.into_iter().next().unwrap_or_default() };
    Ok(json_response(StatusCode::CREATED, &answer))
}

async fn read<T: DeserializeOwned>(body: Body, limit: usize) -> Result<T, Failure> {
    let too_large =
        || Failure(StatusCode::PAYLOAD_TOO_LARGE, format!("the body has more than {limit} bytes"));
    let slow = |_| Failure(StatusCode::REQUEST_TIMEOUT, "the body took too long".to_owned());
    let body: Bytes = match timeout(BODY_TIMEOUT, to_bytes(body, limit)).await.map_err(slow)? {
        Ok(body) => body,
        Err(error)
            if std::error::Error::source(&error)
                .is_some_and(|source| source.to_string().contains("limit")) =>
        {
            return Err(too_large());
        }
        Err(error) => {
            return Err(Failure(StatusCode::BAD_REQUEST, format!("the body broke off ({error})")));
        }
    };
    serde_json::from_slice(&body).map_err(|error| malformed(&error))
}

fn malformed(error: &serde_json::Error) -> Failure {
    Failure(StatusCode::BAD_REQUEST, format!("the body is not valid: {error}"))
}

fn check(desk: &Desk, draft: &OrderDraft) -> Result<NewOrder, DraftError> {
    draft.check(&desk.board.places, || desk.board.generated_name())
}

fn refused(error: &DraftError, index: Option<usize>) -> Failure {
    let place = index.map(|index| format!("order {}: ", index + 1)).unwrap_or_default();
    Failure(StatusCode::UNPROCESSABLE_ENTITY, format!("{place}{error}"))
}

/// Keeps new orders and passes them to the book. It returns them when they are in the store.
async fn keep(desk: &Desk, orders: Vec<NewOrder>) -> Result<Vec<Value>, Failure> {
    let duplicate = |name: &OrderName| InsertError::Duplicate(name.clone()).to_string();
    let shown = desk.board.reserve(&orders).map_err(|refusal| match refusal {
        Refusal::Duplicate(name) => Failure(StatusCode::CONFLICT, duplicate(&name)),
        Refusal::Full => {
            Failure(StatusCode::SERVICE_UNAVAILABLE, "there are too many open orders".to_owned())
        }
    })?;
    let created_secs = shown.first().map_or(0.0, |order| order.created_secs());
    let (sender, receiver) = oneshot::channel();
    let (board, requests, new) = (desk.board.clone(), desk.requests.clone(), orders.clone());
    // It runs even if the client has gone: what is kept must come to the book.
    let done: Reply<Result<(), InsertError>> = Box::new(move |result| {
        match &result {
            Ok(()) => drop(requests.send(Request::Post { orders: new, created_secs })),
            Err(_) => board.release(&new),
        }
        let _ = sender.send(result);
    });
    match &desk.jobs {
        None => done(Ok(())),
        Some(jobs) => {
            if let Err(error) = jobs.send(Job::Insert { orders, created_secs, done })
                && let Job::Insert { done, .. } = error.0
            {
                done(Err(InsertError::Write("the manager ends".to_owned())));
            }
        }
    }
    match receiver.await {
        Ok(Ok(())) => {
            Ok(shown.iter().map(|order| super::json::order(order, &desk.board.places)).collect())
        }
        Ok(Err(error @ InsertError::Duplicate(_))) => {
            Err(Failure(StatusCode::CONFLICT, error.to_string()))
        }
        Ok(Err(error)) => Err(Failure(StatusCode::INSUFFICIENT_STORAGE, error.to_string())),
        Err(_) => Err(Failure(StatusCode::SERVICE_UNAVAILABLE, "the manager ends".to_owned())),
    }
}

async fn withdraw(
    State(desk): State<Arc<Desk>>,
    name: Result<Path<String>, PathRejection>,
    RawQuery(query): RawQuery,
) -> Answer {
    let text = name_of(name)?;
    let name = OrderName::stored(&text).map_err(|_| unknown_order(&text))?;
    find(&desk, &text).await?;
    let immediate = parameter(query.as_deref(), "immediate").is_some_and(|value| value == "true");
    let (sender, receiver) = oneshot::channel();
    // It fails only if the client has gone.
    let reply = Box::new(move |result| {
        let _ = sender.send(result);
    });
    let ended = || Failure(StatusCode::SERVICE_UNAVAILABLE, "the manager ends".to_owned());
    desk.requests.send(Request::Withdraw { name, immediate, reply }).map_err(|_| ended())?;
    match timeout(TICK_TIMEOUT, receiver).await {
        Err(_) => {
            Ok(json_response(StatusCode::ACCEPTED, &json!({"state": "at the manager's next tick"})))
        }
        Ok(Err(_)) => Err(ended()),
        Ok(Ok(Ok(()))) => Ok(json_response(StatusCode::OK, &json!({"state": "cancelled"}))),
        Ok(Ok(Err(WithdrawError::Unknown))) => {
            Err(Failure(StatusCode::CONFLICT, WithdrawError::Over.to_string()))
        }
        Ok(Ok(Err(error))) => Err(Failure(StatusCode::CONFLICT, error.to_string())),
    }
}

async fn vehicles(State(desk): State<Arc<Desk>>) -> Response {
    json_response(StatusCode::OK, &Value::Array(desk.board.vehicles()))
}

async fn vehicle(
    State(desk): State<Arc<Desk>>,
    name: Result<Path<String>, PathRejection>,
) -> Answer {
    let name = name_of(name)?;
    let vehicle = name.parse().ok().and_then(|robot| desk.board.vehicle(robot));
    let unknown =
        || Failure(StatusCode::NOT_FOUND, format!("there is no vehicle `{}`", name.escape_debug()));
    Ok(json_response(StatusCode::OK, &vehicle.ok_or_else(unknown)?))
}

async fn status(State(desk): State<Arc<Desk>>) -> Response {
    json_response(StatusCode::OK, &desk.board.status())
}

async fn sse(State(desk): State<Arc<Desk>>) -> Answer {
    let permit = desk.readers.clone().try_acquire_owned();
    let permit = permit.map_err(|_| {
        Failure(StatusCode::SERVICE_UNAVAILABLE, "there are too many readers".to_owned())
    })?;
    let headers = [(CONTENT_TYPE, "text/event-stream"), (CACHE_CONTROL, "no-cache")];
    Ok((headers, events::body(desk.board.subscribe(), permit)).into_response())
}
