//! What robots are going to drive, told between ticks.

use regatta_plugin::route::RouteResponse;

use super::{Engine, EngineError};
use crate::graph::Gear;

/// Most routes that are told at a time; who asks for more waits for the next tick.
const MOST_ROUTES: usize = 16;

impl Engine {
    /// Answers what was asked for since the last call.
    pub(super) fn answer_routes(&mut self) -> Result<(), EngineError> {
        let Self { routes, fleet, producer, tick, .. } = self;
        routes.answer(MOST_ROUTES, |request| {
            let response = RouteResponse::unknown(producer.run_id(), *tick, request.robot);
            let Some(ahead) = fleet.ahead(request.robot) else { return response };
            let edges = ahead.legs().map(|leg| (leg.edge.0, leg.gear == Gear::Reverse));
            response.with_legs(ahead.released(), ahead.len(), edges)
        })?;
        Ok(())
    }
}
