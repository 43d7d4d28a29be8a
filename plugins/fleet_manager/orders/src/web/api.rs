//! The state and the errors of the handlers, and the steps that several of them share: checking the
//! token, reading a body, keeping and finding orders.

use std::sync::Arc;
use std::sync::mpsc::Sender;
use std::time::Duration;

use axum::Json;
use axum::body::Bytes;
use axum::extract::rejection::{PathRejection, QueryRejection};
use axum::extract::{FromRequest as _, Request as HttpRequest, State};
use axum::http::header::{AUTHORIZATION, HOST, ORIGIN};
use axum::http::{HeaderMap, StatusCode};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use serde::Serialize;
use subtle::ConstantTimeEq as _;
use tokio::sync::{Semaphore, oneshot};
use tokio::time::timeout;
use utoipa::ToSchema;

use super::board::{Board, Refusal};
use crate::draft::{DraftError, OrderDraft};
use crate::order::{NewOrder, OrderName};
use crate::store::{Archive, StoreError};
use crate::threads::{InsertError, Job, Reply, Request};
use crate::view::TransportOrder;

/// The longest time for the body of a request.
const BODY_TIMEOUT: Duration = Duration::from_secs(20);
/// The reason of a request that comes when the process ends.
pub(super) const ENDS: &str = "the manager is stopping";

/// The state of the handlers.
pub(super) struct Api {
    pub(super) board: Arc<Board>,
    pub(super) archive: Option<Arc<Archive>>,
    pub(super) jobs: Option<Sender<Job>>,
    pub(super) requests: Sender<Request>,
    pub(super) token: Option<String>,
    pub(super) readers: Arc<Semaphore>,
}

impl Api {
    /// Runs work that may take long on a thread of its own.
    pub(super) async fn blocking<T: Send + 'static>(
        &self,
        work: impl FnOnce(&Board, Option<&Archive>) -> Result<T, StoreError> + Send + 'static,
    ) -> Result<T, Failure> {
        let (board, archive) = (self.board.clone(), self.archive.clone());
        let done = tokio::task::spawn_blocking(move || work(&board, archive.as_deref())).await;
        done.map_err(internal)?.map_err(internal)
    }
}

/// An error of a request: its status and its reason, as JSON.
pub(super) struct Failure(pub(super) StatusCode, pub(super) String);

/// The body of a [`Failure`].
#[derive(Serialize, ToSchema)]
pub(super) struct Error {
    error: String,
}

impl IntoResponse for Failure {
    fn into_response(self) -> Response {
        (self.0, Json(Error { error: self.1 })).into_response()
    }
}

impl From<PathRejection> for Failure {
    fn from(rejection: PathRejection) -> Self {
        Self(StatusCode::BAD_REQUEST, rejection.to_string())
    }
}

impl From<QueryRejection> for Failure {
    fn from(rejection: QueryRejection) -> Self {
        Self(StatusCode::BAD_REQUEST, rejection.body_text())
    }
}

pub(super) fn internal(error: impl std::error::Error) -> Failure {
    Failure(StatusCode::INTERNAL_SERVER_ERROR, error.to_string())
}

pub(super) fn unavailable(reason: &str) -> Failure {
    Failure(StatusCode::SERVICE_UNAVAILABLE, reason.to_owned())
}

/// Accepts requests that have the token. Without a token, it refuses requests that a page of
/// another site makes a browser send.
pub(super) async fn guard(
    State(api): State<Arc<Api>>,
    request: HttpRequest,
    next: Next,
) -> Response {
    let headers = request.headers();
    let refusal = match &api.token {
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
    let value = headers.get(AUTHORIZATION).map_or(&[][..], |value| value.as_bytes());
    // The duration must not depend on the number of right bytes.
    value.strip_prefix(b"Bearer ").unwrap_or(b"").ct_eq(token.as_bytes()).into()
}

fn is_foreign(headers: &HeaderMap) -> bool {
    let host = headers.get(HOST).and_then(|value| value.to_str().ok()).unwrap_or("localhost");
    let name = host.rsplit_once(':').map_or(host, |(name, _)| name);
    let is_local =
        name == "localhost" || name.trim_matches(['[', ']']).parse::<std::net::IpAddr>().is_ok();
    !is_local
        || headers
            .get(ORIGIN)
            .is_some_and(|origin| origin.as_bytes() != format!("http://{host}").as_bytes())
}

/// Finds an order, also one that only the store has.
pub(super) async fn find(api: &Api, text: &str) -> Result<TransportOrder, Failure> {
    let name = OrderName::stored(text).map_err(|_| unknown_order(text))?;
    if let Some(order) = api.board.order(&name) {
        return Ok(order);
    }
    let stored = api.blocking(move |_, archive| match archive {
        Some(archive) => archive.order(&name),
        None => Ok(None),
    });
    stored.await?.ok_or_else(|| unknown_order(text))
}

pub(super) fn unknown_order(name: &str) -> Failure {
    Failure(StatusCode::NOT_FOUND, format!("there is no order `{}`", name.escape_debug()))
}

/// Reads a body whose route has this limit.
pub(super) async fn read(request: HttpRequest, limit: usize) -> Result<Bytes, Failure> {
    let body = timeout(BODY_TIMEOUT, Bytes::from_request(request, &())).await;
    let Ok(body) = body else {
        return Err(Failure(StatusCode::REQUEST_TIMEOUT, "the body took too long".to_owned()));
    };
    body.map_err(|rejection| match rejection.status() {
        status @ StatusCode::PAYLOAD_TOO_LARGE => {
            Failure(status, format!("the body has more than {limit} bytes"))
        }
        status => Failure(status, format!("the body is incomplete ({})", rejection.body_text())),
    })
}

pub(super) fn malformed(error: serde_json::Error) -> Failure {
    Failure(StatusCode::BAD_REQUEST, format!("the body is not valid: {error}"))
}

pub(super) fn check(api: &Api, draft: &OrderDraft) -> Result<NewOrder, DraftError> {
    draft.check(&api.board.places, || api.board.generated_name())
}

pub(super) fn refused(error: &DraftError, index: Option<usize>) -> Failure {
    let place = index.map(|index| format!("order {}: ", index + 1)).unwrap_or_default();
    Failure(StatusCode::UNPROCESSABLE_ENTITY, format!("{place}{error}"))
}

/// Keeps new orders and passes them to the pool. It returns them when they are in the store.
pub(super) async fn keep(api: &Api, orders: Vec<NewOrder>) -> Result<Vec<TransportOrder>, Failure> {
    let shown = api.board.reserve(&orders).map_err(|refusal| match refusal {
        Refusal::Duplicate(name) => insert_failure(&InsertError::Duplicate(name)),
        Refusal::Full => unavailable("there are too many open orders"),
    })?;
    let created_secs = shown.first().map_or(0.0, |order| order.created_secs);
    let (sender, receiver) = oneshot::channel();
    let (board, requests, new) = (api.board.clone(), api.requests.clone(), orders.clone());
    // It runs even if the client has gone: stored orders must come to the pool.
    let done: Reply<Result<(), InsertError>> = Box::new(move |result| {
        match &result {
            Ok(()) => drop(requests.send(Request::Post { orders: new, created_secs })),
            Err(_) => board.release(&new),
        }
        let _ = sender.send(result);
    });
    match &api.jobs {
        None => done(Ok(())),
        Some(jobs) => {
            if let Err(error) = jobs.send(Job::Insert { orders, created_secs, done })
                && let Job::Insert { done, .. } = error.0
            {
                done(Err(InsertError::Write(ENDS.to_owned())));
            }
        }
    }
    receiver.await.map_err(|_| unavailable(ENDS))?.map_err(|error| insert_failure(&error))?;
    Ok(shown.iter().map(|order| TransportOrder::new(order, &api.board.places)).collect())
}

fn insert_failure(error: &InsertError) -> Failure {
    let status = match error {
        InsertError::Duplicate(_) => StatusCode::CONFLICT,
        InsertError::Write(_) => StatusCode::INSUFFICIENT_STORAGE,
    };
    Failure(status, error.to_string())
}
