//! The remaining routes of robots, reported between ticks.

use regatta_layout::Gear;
use regatta_plugin::producer::Session;
use regatta_plugin::route::RouteResponse;

use super::{EngineError, Simulation};

/// The number of legs of a random walk that are reported after the one that the robot is on.
const WALK_LEGS: usize = 16;

/// The largest number of routes that are reported between two ticks. More requests wait for the
/// next.
const MAX_ROUTES: usize = 16;

impl Simulation {
    /// Answers the requests that have arrived since the last call.
    pub(super) fn answer_routes(&mut self, session: &Session) -> Result<(), EngineError> {
        let Self { routes, fleet, .. } = self;
        routes.answer(MAX_ROUTES, |request| {
            let response = RouteResponse::unknown(session.run_id(), session.tick(), request.robot);
            let Some(ahead) = fleet.ahead(request.robot) else { return response };
            let walk = fleet.walk_ahead(request.robot).take(WALK_LEGS);
            let drawn = walk.clone().count();
            let edges = ahead.legs().chain(walk).map(|leg| (leg.edge.0, leg.gear == Gear::Reverse));
            let response = response.with_legs(ahead.released() + drawn, ahead.len() + drawn, edges);
            let response = response.up_to(ahead.released_metres);
            if fleet.drives_on(request.robot) { response.and_on() } else { response }
        })?;
        Ok(())
    }
}
