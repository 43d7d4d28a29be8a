//! The routes of the web API, and the OpenAPI document that describes them.

use std::convert::Infallible;
use std::future::ready;
use std::sync::Arc;
use std::time::Duration;

use axum::extract::rejection::{PathRejection, QueryRejection};
use axum::extract::{Path, Query, Request as HttpRequest, State};
use axum::http::StatusCode;
use axum::http::header::CONTENT_TYPE;
use axum::middleware::{from_fn, from_fn_with_state};
use axum::response::sse::{Event, KeepAlive, Sse};
use axum::response::{IntoResponse, Response};
use axum::routing::{get, post};
use axum::{Json, Router};
use futures_util::stream::{Stream, StreamExt as _, once, unfold};
use regatta_kit::server::Access;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use tokio::sync::broadcast::error::RecvError;
use tokio::sync::oneshot;
use tokio::time::timeout;
use utoipa::openapi::security::{HttpAuthScheme, HttpBuilder, SecurityScheme};
use utoipa::{IntoParams, Modify, OpenApi, ToSchema};

use super::api::{
    Api, ENDS, Error, Failure, check, find, guard, guard_site, keep, malformed, read, refused,
    unavailable, unknown_order,
};
use super::list;
use crate::draft::OrderDraft;
use crate::order::{Order, OrderName, State as OrderState};
use crate::schema;
use crate::threads::{Request, WithdrawError};
use crate::view::{Page, TransportOrder, VehicleView};

/// The largest body of one order, in bytes.
const MAX_ORDER_BYTES: usize = 64 << 10;
/// The largest body of many orders, in bytes.
const MAX_ORDERS_BYTES: usize = 16 << 20;
/// The longest wait of a withdrawal for the manager's next tick: a paused fleet has none.
const TICK_TIMEOUT: Duration = Duration::from_secs(2);
/// The largest number of orders in an answer.
const MAX_PAGE: usize = 1_000;
/// A comment is sent after so much silence, so that a reader that has gone is noticed.
const HEARTBEAT: Duration = Duration::from_secs(15);

#[derive(OpenApi)]
#[openapi(
    info(
        title = "Regatta fleet manager",
        version = "1",
        description = "Transport orders and vehicles. All times are in seconds of simulated time, \
                       of the run in which something happened."
    ),
    paths(orders, post_orders, order, post_order, withdraw, vehicles, vehicle, status, sse),
    security((), ("bearer" = [])),
    modifiers(&Bearer)
)]
struct Document;

struct Bearer;

impl Modify for Bearer {
    fn modify(&self, document: &mut utoipa::openapi::OpenApi) {
        let bearer = HttpBuilder::new().scheme(HttpAuthScheme::Bearer).build();
        let components = document.components.get_or_insert_default();
        components.add_security_scheme("bearer", SecurityScheme::Http(bearer));
    }
}

pub(super) fn router(api: Arc<Api>, access: Access) -> Router {
    let guarded = Router::new()
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
        .layer(from_fn_with_state(access, guard));
    let open = guarded.route("/openapi.json", get(openapi)).route("/", get(page));
    open.layer(from_fn(guard_site)).with_state(api)
}

async fn openapi() -> Json<utoipa::openapi::OpenApi> {
    Json(Document::openapi())
}

async fn page() -> impl IntoResponse {
    ([(CONTENT_TYPE, "text/html; charset=utf-8")], include_str!("page.html"))
}

type PathName = Result<Path<String>, PathRejection>;
type QueryOf<T> = Result<Query<T>, QueryRejection>;

/// The query of a list of orders.
#[derive(Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
struct PageQuery {
    /// open, or a state
    #[param(schema_with = schema::listed_states)]
    state: Option<String>,
    #[param(minimum = 1, maximum = 1_000, default = 1_000)]
    limit: Option<usize>,
    /// only names after this one: the last one of the page before
    #[param(value_type = OrderName, inline)]
    after: Option<String>,
}

impl PageQuery {
    fn page(self) -> Result<Page, String> {
        let Self { state, limit, after } = self;
        if let Some(state) = state.as_deref()
            && state != "open"
            && !OrderState::NAMES.contains(&state)
        {
            return Err(format!(
                "unknown state `{}`; there are open, {}",
                state.escape_debug(),
                OrderState::NAMES.join(", ")
            ));
        }
        let limit = limit.unwrap_or(MAX_PAGE);
        if !(1..=MAX_PAGE).contains(&limit) {
            return Err(format!("`limit` is `{limit}`, and must be 1 to {MAX_PAGE}"));
        }
        let after = after.map(|name| OrderName::stored(&name)).transpose();
        Ok(Page { state, after: after.map_err(|error| format!("`after`: {error}"))?, limit })
    }
}

/// Orders, in the order of their names: open ones, and with a store all that are over, also of
/// earlier runs
#[utoipa::path(get, path = "/v1/transportOrders", params(PageQuery), responses(
    (status = 200, description = "The orders.", body = Vec<TransportOrder>),
    (status = 400, description = "A parameter is wrong.", body = Error),
))]
async fn orders(
    State(api): State<Arc<Api>>,
    query: QueryOf<PageQuery>,
) -> Result<Response, Failure> {
    let Query(query) = query?;
    let page = query.page().map_err(|reason| Failure(StatusCode::BAD_REQUEST, reason))?;
    list::page(api, page).await
}

/// An order
#[utoipa::path(get, path = "/v1/transportOrders/{name}", params(("name" = inline(OrderName), Path)), responses(
    (status = 200, description = "The order.", body = TransportOrder),
    (status = 404, description = "There is no such order.", body = Error),
))]
async fn order(
    State(api): State<Arc<Api>>,
    name: PathName,
) -> Result<Json<TransportOrder>, Failure> {
    let Path(name) = name?;
    find(&api, &name).await.map(Json)
}

/// Create an order
#[utoipa::path(post, path = "/v1/transportOrders/{name}", params(("name" = inline(OrderName), Path)),
    request_body = OrderDraft, responses(
    (status = 201, description = "Kept.", body = TransportOrder),
    (status = 400, description = "The body is malformed.", body = Error),
    (status = 409, description = "There is an order with this name.", body = Error),
    (status = 413, description = "The body is too large.", body = Error),
    (status = 422, description = "A stop or a value is wrong.", body = Error),
    (status = 507, description = "The order can't be kept.", body = Error),
))]
async fn post_order(
    State(api): State<Arc<Api>>,
    name: PathName,
    request: HttpRequest,
) -> Result<Response, Failure> {
    let Path(name) = name?;
    let body = read(request, MAX_ORDER_BYTES).await?;
    let mut draft: OrderDraft = serde_json::from_slice(&body).map_err(malformed)?;
    if draft.name.as_ref().is_some_and(|given| *given != name) {
        let reason = "the body has another name than the path".to_owned();
        return Err(Failure(StatusCode::BAD_REQUEST, reason));
    }
    draft.name = Some(name);
    let order = check(&api, &draft).map_err(|error| refused(&error, None))?;
    let orders = keep(&api, vec![order]).await?;
    Ok((StatusCode::CREATED, first(&api, &orders)).into_response())
}

/// One order or a list of them.
#[derive(Serialize, ToSchema)]
#[serde(untagged)]
#[expect(dead_code, reason = "it describes bodies in the document")]
enum OneOrMany<T> {
    One(T),
    Many(Vec<T>),
}

/// Create one order, or a list of orders: all or none
#[utoipa::path(post, path = "/v1/transportOrders",
    request_body = inline(OneOrMany<OrderDraft>), responses(
    (status = 201, description = "Kept.", body = inline(OneOrMany<TransportOrder>)),
    (status = 400, description = "The body is malformed.", body = Error),
    (status = 409, description = "There is an order with this name.", body = Error),
    (status = 413, description = "The body is too large.", body = Error),
    (status = 422, description = "A stop or a value is wrong.", body = Error),
    (status = 507, description = "The order can't be kept.", body = Error),
))]
async fn post_orders(
    State(api): State<Arc<Api>>,
    request: HttpRequest,
) -> Result<Response, Failure> {
    let body = read(request, MAX_ORDERS_BYTES).await?;
    // Not as an untagged enum, whose errors wouldn't name the field that is wrong.
    let is_list = body.trim_ascii_start().first() == Some(&b'[');
    let drafts: Vec<OrderDraft> = match is_list {
        true => serde_json::from_slice(&body).map_err(malformed)?,
        false => vec![serde_json::from_slice(&body).map_err(malformed)?],
    };
    drop(body);
    let mut checked = Vec::with_capacity(drafts.len());
    for (index, draft) in drafts.into_iter().enumerate() {
        let order = check(&api, &draft);
        checked.push(order.map_err(|error| refused(&error, is_list.then_some(index)))?);
    }
    let orders = keep(&api, checked).await?;
    let answer = match is_list {
        true => list::orders(api, orders),
        false => first(&api, &orders).into_response(),
    };
    Ok((StatusCode::CREATED, answer).into_response())
}

/// The one order of an answer.
fn first(api: &Api, orders: &[Arc<Order>]) -> Json<Option<TransportOrder>> {
    Json(orders.first().map(|order| TransportOrder::new(order, &api.board.places)))
}

#[derive(Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
struct WithdrawQuery {
    /// even if its robot has handled a stop
    #[serde(default)]
    #[param(required = false)]
    immediate: bool,
}

/// Withdraw an order
#[utoipa::path(post, path = "/v1/transportOrders/{name}/withdrawal",
    params(("name" = inline(OrderName), Path), WithdrawQuery), responses(
    (status = 200, description = "Withdrawn."),
    (status = 202, description = "It will be at the manager's next tick: the fleet is paused."),
    (status = 404, description = "There is no such order.", body = Error),
    (status = 409, description = "It is over, or its robot has begun.", body = Error),
))]
async fn withdraw(
    State(api): State<Arc<Api>>,
    name: PathName,
    query: QueryOf<WithdrawQuery>,
) -> Result<Response, Failure> {
    let (Path(text), Query(WithdrawQuery { immediate })) = (name?, query?);
    let name = OrderName::stored(&text).map_err(|_| unknown_order(&text))?;
    find(&api, &text).await?;
    let (sender, receiver) = oneshot::channel();
    // It fails only if the client has gone.
    let reply = Box::new(move |result| {
        let _ = sender.send(result);
    });
    let request = Request::Withdraw { name, immediate, reply };
    api.requests.send(request).map_err(|_| unavailable(ENDS))?;
    let Ok(answer) = timeout(TICK_TIMEOUT, receiver).await else {
        let answer = json!({"state": "at the manager's next tick"});
        return Ok((StatusCode::ACCEPTED, Json(answer)).into_response());
    };
    match answer.map_err(|_| unavailable(ENDS))? {
        Ok(()) => Ok(Json(json!({"state": "cancelled"})).into_response()),
        // The order is known, and so it is closed and no longer in memory.
        Err(WithdrawError::Unknown) => {
            Err(Failure(StatusCode::CONFLICT, WithdrawError::Over.to_string()))
        }
        Err(error) => Err(Failure(StatusCode::CONFLICT, error.to_string())),
    }
}

/// All vehicles
#[utoipa::path(get, path = "/v1/vehicles", responses(
    (status = 200, description = "The vehicles.", body = Vec<VehicleView>),
))]
async fn vehicles(State(api): State<Arc<Api>>) -> Response {
    list::list(unfold(0, move |from| {
        let next = api.board.next_vehicle(from);
        ready(next.map(|(robot, vehicle)| (Ok(vehicle), robot.saturating_add(1))))
    }))
}

/// A vehicle
#[utoipa::path(get, path = "/v1/vehicles/{name}", params(("name" = String, Path)), responses(
    (status = 200, description = "The vehicle.", body = VehicleView),
    (status = 404, description = "There is no such vehicle.", body = Error),
))]
async fn vehicle(
    State(api): State<Arc<Api>>,
    name: PathName,
) -> Result<Json<VehicleView>, Failure> {
    let Path(name) = name?;
    let vehicle = name.parse().ok().and_then(|robot| api.board.vehicle(robot));
    vehicle.map(Json).ok_or_else(|| {
        let reason = format!("there is no vehicle `{}`", name.escape_debug());
        Failure(StatusCode::NOT_FOUND, reason)
    })
}

/// Simulated time, numbers of orders and figures since the manager's start
#[utoipa::path(get, path = "/v1/status", responses(
    (status = 200, description = "The status.", body = Object),
))]
async fn status(State(api): State<Arc<Api>>) -> Json<Value> {
    Json(api.board.status())
}

/// Changes as server-sent events: transportOrder, vehicle (not for its position alone), missed
///
/// A reader that is too slow misses some changes, and gets their number.
#[utoipa::path(get, path = "/v1/sse", responses(
    (status = 200, description = "Events.", content_type = "text/event-stream"),
    (status = 503, description = "There are too many readers.", body = Error),
))]
async fn sse(
    State(api): State<Arc<Api>>,
) -> Result<Sse<impl Stream<Item = Result<Event, Infallible>>>, Failure> {
    let permit = api.readers.clone().try_acquire_owned();
    let permit = permit.map_err(|_| unavailable("there are too many readers"))?;
    let greeting = Event::default().comment("changes of orders and vehicles");
    // The permit is held as long as the reader is there.
    let changes = unfold((api.board.subscribe(), permit), |(mut events, permit)| async move {
        let event = match events.recv().await {
            Ok(event) => event,
            Err(RecvError::Lagged(count)) => {
                Event::default().event("missed").data(count.to_string())
            }
            Err(RecvError::Closed) => return None,
        };
        Some((Ok(event), (events, permit)))
    });
    let stream = once(ready(Ok(greeting))).chain(changes);
    Ok(Sse::new(stream).keep_alive(KeepAlive::new().interval(HEARTBEAT).text("still here")))
}
