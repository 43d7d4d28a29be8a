//! The state and the errors of the handlers, and the steps that several of them share: checking the
//! token, reading a body, keeping and finding orders.

use std::sync::Arc;
use std::sync::mpsc::Sender;
use std::time::Duration;

use axum::Json;
use axum::extract::rejection::{PathRejection, QueryRejection};
use axum::extract::{Request as HttpRequest, State};
use axum::http::StatusCode;
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use regatta_kit::server::{Access, BodyError, Refusal as Refused, read_body};
use serde::Serialize;
use tokio::sync::{Semaphore, oneshot};
use utoipa::ToSchema;

use super::board::{Board, Refusal};
use crate::draft::{DraftError, OrderDraft};
use crate::order::{NewOrder, Order, OrderName};
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

/// Accepts requests of this user, and those that have the token.
pub(super) async fn guard(
    State(access): State<Access>,
    request: HttpRequest,
    next: Next,
) -> Response {
    match access.check(&request) {
        Ok(()) => next.run(request).await,
        Err(refusal) => refused_request(refusal),
    }
}

/// Accepts requests for what needs no token.
pub(super) async fn guard_site(request: HttpRequest, next: Next) -> Response {
    match Access::check_site(&request) {
        Ok(()) => next.run(request).await,
        Err(refusal) => refused_request(refusal),
    }
}

fn refused_request(refusal: Refused) -> Response {
    let status = match refusal {
        Refused::Token => StatusCode::UNAUTHORIZED,
        Refused::Site => StatusCode::FORBIDDEN,
    };
    Failure(status, refusal.to_string()).into_response()
}

/// Finds an order, also one that only the store has.
pub(super) async fn find(api: &Api, text: &str) -> Result<TransportOrder, Failure> {
    let name = OrderName::stored(text).map_err(|_| unknown_order(text))?;
    shown(api, name).await?.ok_or_else(|| unknown_order(text))
}

/// Returns an order of the board or the store.
pub(super) async fn shown(api: &Api, name: OrderName) -> Result<Option<TransportOrder>, Failure> {
    if let Some(order) = api.board.order(&name) {
        return Ok(Some(order));
    }
    let stored = api.blocking(move |_, archive| match archive {
        Some(archive) => archive.order(&name),
        None => Ok(None),
    });
    stored.await
}

pub(super) fn unknown_order(name: &str) -> Failure {
    Failure(StatusCode::NOT_FOUND, format!("there is no order `{}`", name.escape_debug()))
}

/// Reads a body whose route has this limit.
pub(super) async fn read(request: HttpRequest, limit: usize) -> Result<Vec<u8>, Failure> {
    read_body(request, limit, BODY_TIMEOUT).await.map_err(|error| {
        let status = match error {
            BodyError::TooLarge(_) => StatusCode::PAYLOAD_TOO_LARGE,
            BodyError::TooSlow => StatusCode::REQUEST_TIMEOUT,
            BodyError::Incomplete(_) => StatusCode::BAD_REQUEST,
        };
        Failure(status, error.to_string())
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
pub(super) async fn keep(api: &Api, orders: Vec<NewOrder>) -> Result<Vec<Arc<Order>>, Failure> {
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
    Ok(shown)
}

fn insert_failure(error: &InsertError) -> Failure {
    let status = match error {
        InsertError::Duplicate(_) => StatusCode::CONFLICT,
        InsertError::Write(_) => StatusCode::INSUFFICIENT_STORAGE,
    };
    Failure(status, error.to_string())
}
