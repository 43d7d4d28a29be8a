//! A client: reads what it asks, and sends what is in its outbox.

use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;

use futures_util::{SinkExt as _, StreamExt as _};
use tokio::net::TcpStream;
use tokio::time::{Instant, sleep_until, timeout};
use tokio_tungstenite::WebSocketStream;
use tokio_tungstenite::tungstenite::protocol::CloseFrame;
use tokio_tungstenite::tungstenite::protocol::frame::coding::CloseCode;
use tokio_tungstenite::tungstenite::{Error, Message};

use crate::channel::Channel;
use crate::desk::{Desk, Reply};
use crate::hub::{Fault, Hub};
use crate::outbox::{Next, Outbox};
use crate::parameters;
use crate::protocol::response::{self, JSON, Level};
use crate::protocol::{Parameter, Request, ServiceCall, Subscription, parse};
use crate::service::{Service, Wish};

/// The longest time in which a client doesn't take a message.
const SEND_TIME: Duration = Duration::from_secs(10);
/// The messages that a client may send at once.
const BURST: u32 = 200;
/// The time in which it may send as many again.
const BURST_TIME: Duration = Duration::from_secs(1);
/// Messages that aren't of the protocol, after which a client is cut off.
const MOST_FAULTS: u32 = 100;
/// The most parameters and subscriptions in a message.
const MOST_ITEMS: usize = 100;
const READ_ONLY: &str = "the plugin runs with --read-only: it doesn't let clients steer the fleet";

/// A client with its connection.
pub(super) struct Client {
    socket: WebSocketStream<TcpStream>,
    asker: Asker,
    /// Messages that it may send until `refill`.
    credit: u32,
    refill: Instant,
}

/// The effect of a client on the rest of the plugin.
struct Asker {
    peer: SocketAddr,
    hub: Arc<Hub>,
    desk: Desk,
    outbox: Arc<Outbox>,
    faults: u32,
}

/// The end of a connection.
enum End {
    /// The client has gone, or breaks the rules of WebSocket.
    Gone,
    /// It is cut off for this reason.
    CutOff(&'static str),
}

impl Client {
    pub fn join(
        socket: WebSocketStream<TcpStream>,
        peer: SocketAddr,
        hub: Arc<Hub>,
        desk: Desk,
    ) -> Self {
        let outbox = hub.join();
        let asker = Asker { peer, hub, desk, outbox, faults: 0 };
        Self { socket, asker, credit: BURST, refill: Instant::now() + BURST_TIME }
    }

    /// Serves the client until it goes, or is cut off.
    pub async fn serve(mut self) {
        let end = loop {
            if let Err(end) = self.step().await {
                break end;
            }
        };
        if let End::CutOff(reason) = end {
            let frame = CloseFrame { code: CloseCode::Policy, reason: reason.into() };
            // Whether or not it hears why, it is gone.
            let _ = timeout(Duration::from_secs(1), self.socket.close(Some(frame))).await;
        }
    }

    /// Reads or sends a message, whichever can be done first.
    async fn step(&mut self) -> Result<(), End> {
        let outbox = Arc::clone(&self.asker.outbox);
        tokio::select! {
            received = self.socket.next(), if self.credit > 0 => {
                self.credit -= 1;
                self.asker.take(received)
            }
            next = outbox.next() => self.send(next).await,
            () = sleep_until(self.refill) => {
                if self.credit == 0 {
                    self.asker.is_flooding();
                }
                (self.credit, self.refill) = (BURST, Instant::now() + BURST_TIME);
                Ok(())
            }
        }
    }

    async fn send(&mut self, next: Next) -> Result<(), End> {
        let Next::Message(message) = next else {
            self.asker.tell_stuck("asks for more than it reads");
            return Err(End::CutOff("you ask for more answers than you read"));
        };
        match timeout(SEND_TIME, self.socket.send(message)).await {
            Ok(sent) => sent.map_err(|_| End::Gone),
            Err(_) => {
                self.asker.tell_stuck("reads nothing");
                Err(End::Gone)
            }
        }
    }
}

impl Drop for Asker {
    fn drop(&mut self) {
        self.hub.leave(&self.outbox);
    }
}

impl Asker {
    fn is_flooding(&self) {
        let peer = self.peer;
        let format = format_args!("client {peer} sends more than {BURST} messages a second");
        self.hub.tell(Fault::Flood, format);
    }

    fn tell_stuck(&self, what: &str) {
        let peer = self.peer;
        self.hub.tell(Fault::Stuck, format_args!("client {peer} {what}, and is cut off"));
    }

    fn take(&mut self, received: Option<Result<Message, Error>>) -> Result<(), End> {
        let (bytes, is_text) = match received {
            Some(Ok(Message::Text(text))) => (text.into(), true),
            Some(Ok(Message::Binary(bytes))) => (bytes, false),
            // The library answers pings and the end.
            Some(Ok(_)) => return Ok(()),
            Some(Err(Error::Capacity(_))) => return Err(End::CutOff("a message is too long")),
            Some(Err(_)) | None => return Err(End::Gone),
        };
        match parse(&bytes, is_text) {
            Ok(request) => {
                self.handle(request);
                Ok(())
            }
            Err(error) => self.refuse(&error.to_string()),
        }
    }

    /// Answers a message that isn't of the protocol.
    fn refuse(&mut self, reason: &str) -> Result<(), End> {
        self.faults += 1;
        let peer = self.peer;
        self.hub.tell(Fault::Message, format_args!("client {peer} is refused: {reason}"));
        self.outbox.status(Level::Error, reason);
        match self.faults < MOST_FAULTS {
            true => Ok(()),
            false => Err(End::CutOff("too many messages that aren't of the protocol")),
        }
    }

    fn warn(&self, message: &str) {
        self.outbox.status(Level::Warning, message);
    }

    fn handle(&self, request: Request) {
        match request {
            Request::Subscribe { subscriptions } => self.subscribe(&subscriptions),
            Request::Unsubscribe { subscription_ids } => {
                for id in subscription_ids.into_iter().take(MOST_ITEMS) {
                    if !self.outbox.unsubscribe(id) {
                        self.warn(&format!("there is no subscription {id}"));
                    }
                }
            }
            Request::GetParameters { parameter_names, id } => {
                let values = self.hub.parameters().map(|values| values.named(&parameter_names));
                let values = values.unwrap_or_default();
                self.outbox.answer(response::parameter_values(values, id.as_deref()));
            }
            Request::SetParameters { parameters, id } => self.set_parameters(&parameters, id),
            Request::SubscribeParameterUpdates { parameter_names } => {
                self.outbox.watch(&parameter_names, true);
            }
            Request::UnsubscribeParameterUpdates { parameter_names } => {
                self.outbox.watch(&parameter_names, false);
            }
            Request::Call(call) => self.call(&call),
            Request::FetchAsset { request_id } => {
                self.outbox.answer(response::asset_refused(request_id, "there are no files"));
            }
            Request::Advertise {} | Request::Unadvertise {} | Request::Message => {
                self.warn("messages of clients are not read: steer by parameters and services");
            }
            Request::SubscribeConnectionGraph {} | Request::UnsubscribeConnectionGraph {} => {
                self.warn("there is no graph of connections");
            }
        }
    }

    fn subscribe(&self, subscriptions: &[Subscription]) {
        for Subscription { id, channel_id } in subscriptions.iter().take(MOST_ITEMS) {
            match Channel::of_id(*channel_id) {
                None => self.warn(&format!("there is no channel {channel_id}")),
                Some(channel) if !self.outbox.subscribe(channel, *id) => self.warn(&format!(
                    "channel {channel_id} or the number {id} is subscribed to already"
                )),
                Some(_) => {}
            }
        }
    }

    fn set_parameters(&self, parameters: &[Parameter], id: Option<String>) {
        if !self.hub.can_steer() {
            return self.outbox.status(Level::Error, READ_ONLY);
        }
        let mut wishes = Vec::new();
        for parameter in parameters.iter().take(MOST_ITEMS) {
            match parameters::wish(parameter) {
                Ok(wish) => wishes.push(wish),
                Err(error) => self.outbox.status(Level::Error, &error.to_string()),
            }
        }
        let names = parameters.iter().map(|parameter| parameter.name.clone());
        let reply = Reply::Parameters { names: names.take(MOST_ITEMS).collect(), id };
        if let Err(busy) = self.desk.ask(wishes, reply, &self.outbox) {
            self.outbox.status(Level::Error, &busy.to_string());
        }
    }

    fn call(&self, call: &ServiceCall) {
        let refused = match self.wish(call) {
            Ok(wish) => {
                let reply = Reply::Service { service: call.service, call: call.call };
                let asked = self.desk.ask(vec![wish], reply, &self.outbox);
                asked.err().map(|busy| busy.to_string())
            }
            Err(reason) => Some(reason),
        };
        if let Some(reason) = refused {
            self.outbox.answer(response::call_failed(call, &reason));
        }
    }

    fn wish(&self, call: &ServiceCall) -> Result<Wish, String> {
        if !self.hub.can_steer() {
            return Err(READ_ONLY.to_owned());
        }
        let service = Service::of_id(call.service);
        let service = service.ok_or_else(|| format!("there is no service {}", call.service))?;
        if call.encoding != JSON {
            return Err(format!("services are called in {JSON}"));
        }
        service.wish(&call.payload).map_err(|error| error.to_string())
    }
}
