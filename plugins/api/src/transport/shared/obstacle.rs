//! The reasons for which a service can't be opened at once.

use iceoryx2::service::builder::event::{
    EventCreateError, EventOpenError, EventOpenOrCreateError as Event,
};
use iceoryx2::service::builder::publish_subscribe::{
    PublishSubscribeCreateError, PublishSubscribeOpenError,
    PublishSubscribeOpenOrCreateError as PublishSubscribe,
};
use iceoryx2::service::builder::request_response::{
    RequestResponseCreateError, RequestResponseOpenError,
    RequestResponseOpenOrCreateError as RequestResponse,
};

/// The reason in an error of iceoryx2 for which a service isn't opened or created.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Obstacle {
    /// Its file is there, and what belongs to it isn't: another process creates or removes it at this
    /// moment, or was killed while it did so.
    Hanging,
    /// Another process creates or removes it at this moment.
    InFlux,
    /// The largest number of processes has it open.
    Full,
    /// Another one, which rarely goes away.
    Other,
}

/// An error of iceoryx2 for a service.
pub(super) trait Obstructed: core::fmt::Display {
    /// The obstacle that it tells.
    fn obstacle(&self) -> Obstacle;
}

/// Implements [`Obstructed`] for the error of opening or creating a service of one messaging
/// pattern. All of them tell the same, with types of their own.
macro_rules! obstructed {
    ($error:ident, $opening:ident: $open:ident, $creating:ident: $create:ident) => {
        impl Obstructed for $error {
            fn obstacle(&self) -> Obstacle {
                match self {
                    $error::$opening($open::HangsInCreation | $open::IsMarkedForDestruction) => {
                        Obstacle::Hanging
                    }
                    // A signal, such as that of a child's end, wakes iceoryx2 while it waits.
                    $error::$opening($open::DoesNotExist | $open::Interrupt)
                    | $error::$creating(
                        $create::AlreadyExists
                        | $create::IsBeingCreatedByAnotherInstance
                        | $create::Interrupt,
                    )
                    | $error::SystemInFlux => Obstacle::InFlux,
                    $error::$opening($open::ExceedsMaxNumberOfNodes) => Obstacle::Full,
                    _ => Obstacle::Other,
                }
            }
        }
    };
}

obstructed!(
    PublishSubscribe,
    PublishSubscribeOpenError: PublishSubscribeOpenError,
    PublishSubscribeCreateError: PublishSubscribeCreateError
);
obstructed!(
    RequestResponse,
    RequestResponseOpenError: RequestResponseOpenError,
    RequestResponseCreateError: RequestResponseCreateError
);
obstructed!(Event, EventOpenError: EventOpenError, EventCreateError: EventCreateError);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_service_that_others_create_or_remove_is_waited_for() {
        use PublishSubscribeCreateError::AlreadyExists;
        use RequestResponseOpenError::{HangsInCreation, IncompatibleAttributes};
        let hangs = RequestResponse::RequestResponseOpenError(HangsInCreation);
        assert_eq!(hangs.obstacle(), Obstacle::Hanging);
        let exists = PublishSubscribe::PublishSubscribeCreateError(AlreadyExists);
        assert_eq!(exists.obstacle(), Obstacle::InFlux);
        assert_eq!(Event::SystemInFlux.obstacle(), Obstacle::InFlux);
        let full = Event::EventOpenError(EventOpenError::ExceedsMaxNumberOfNodes);
        assert_eq!(full.obstacle(), Obstacle::Full);
        let other = RequestResponse::RequestResponseOpenError(IncompatibleAttributes);
        assert_eq!(other.obstacle(), Obstacle::Other);
    }
}
