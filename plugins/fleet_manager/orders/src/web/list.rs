//! Long lists, made in pieces while the client takes them: a client that doesn't read its answer
//! costs no more memory than a piece.

use std::fmt::Write as _;
use std::pin::Pin;
use std::sync::Arc;

use axum::body::Body;
use axum::http::header::CONTENT_TYPE;
use axum::response::{IntoResponse, Response};
use futures_util::stream::{Stream, StreamExt as _, iter, unfold};
use regatta_kit::server::PIECE_BYTES;
use serde::Serialize;

use super::api::{Api, Failure, internal, shown};
use crate::order::{Order, OrderName};
use crate::view::{Page, TransportOrder};

/// A JSON list of items.
struct List<T> {
    items: Pin<Box<dyn Stream<Item = Result<T, Failure>> + Send>>,
    /// The text before the next item; `None` after the last one.
    before: Option<char>,
}

impl<T: Serialize> List<T> {
    /// Returns the next piece, at the end `None`.
    async fn piece(&mut self) -> Option<Result<String, std::io::Error>> {
        let mut text = String::new();
        while text.len() < PIECE_BYTES {
            let before = self.before?;
            match self.items.next().await {
                Some(item) => match item.and_then(|item| json(&item)) {
                    // A string takes all that is written.
                    Ok(item) => drop(write!(text, "{before}{item}")),
                    Err(Failure(_, reason)) => return Some(Err(std::io::Error::other(reason))),
                },
                None => {
                    text.push_str(if before == '[' { "[]" } else { "]" });
                    self.before = None;
                    return Some(Ok(text));
                }
            }
            self.before = Some(',');
        }
        Some(Ok(text))
    }
}

fn json(item: &impl Serialize) -> Result<String, Failure> {
    serde_json::to_string(item).map_err(internal)
}

/// Returns an answer with a list of items.
pub(super) fn list<T: Serialize + Send + 'static>(
    items: impl Stream<Item = Result<T, Failure>> + Send + 'static,
) -> Response {
    let list = List { items: Box::pin(items), before: Some('[') };
    let pieces = unfold(list, |mut list| async move { Some((list.piece().await?, list)) });
    ([(CONTENT_TYPE, "application/json")], Body::from_stream(pieces)).into_response()
}

/// Returns an answer with the orders of a page.
pub(super) async fn page(api: Arc<Api>, page: Page) -> Result<Response, Failure> {
    let names = api.blocking(move |board, archive| {
        // The store first: an order that the board drops in between is in one of both.
        let stored = archive
            .map_or(Ok(Vec::new()), |archive| archive.names(&page, |name| board.has(name)))?;
        let mut names: Vec<OrderName> = stored.into_iter().chain(board.names(&page)).collect();
        names.sort();
        names.dedup();
        names.truncate(page.limit);
        Ok(names)
    });
    let orders = iter(names.await?).filter_map(move |name| {
        let api = api.clone();
        async move { shown(&api, name).await.transpose() }
    });
    Ok(list(orders))
}

/// Returns an answer with these orders.
pub(super) fn orders(api: Arc<Api>, orders: Vec<Arc<Order>>) -> Response {
    list(iter(orders).map(move |order| Ok(TransportOrder::new(&order, &api.board.places))))
}
