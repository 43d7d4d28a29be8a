//! A client of the broker.

use std::sync::Arc;
use std::time::Duration;

use parking_lot::Mutex;
use rumqttc::{
    ConnAck, Connect, ConnectReturnCode, LastWill, Packet, PubAck, PubComp, PubRec, Publish, QoS,
    SubAck, Subscribe, SubscribeReasonCode, UnsubAck, valid_filter,
};
use tokio::sync::mpsc::UnboundedReceiver;
use tokio::task::yield_now;
use tokio::time::timeout;

use super::Access;
use super::hub::{Hub, Queued, lower};
use super::stream::{MOST_BYTES, Stream};

/// The time in which a client has to say who it is, and the most bytes that it needs for that.
const GREETING: Duration = Duration::from_secs(10);
const GREETING_BYTES: usize = 64 << 10;
/// The most clients.
const MOST_CLIENTS: usize = 50_000;
/// The silence of a client that wants no limit.
const ENDLESS: Duration = Duration::from_secs(365 * 24 * 3600);

/// The end of a connection.
enum End {
    /// The client has said so.
    Farewell,
    /// It is gone, or sends what it may not.
    Broken,
}

/// A client.
pub(super) struct Peer {
    stream: Stream,
    hub: Arc<Mutex<Hub>>,
}

impl Peer {
    pub(super) fn new(stream: Stream, hub: Arc<Mutex<Hub>>) -> Self {
        Self { stream, hub }
    }

    /// Waits until the client says who it is. One that may connect is served by another task.
    pub(super) async fn serve(mut self, access: Arc<Access>) {
        let greeting = timeout(GREETING, self.stream.read(GREETING_BYTES)).await;
        let Ok(Some(Packet::Connect(connect))) = greeting else { return };
        if !access.admits(&connect) {
            let code = ConnectReturnCode::BadUserNamePassword;
            // The connection ends in any case.
            let _ = self.stream.write(Packet::ConnAck(ConnAck::new(code, false))).await;
            return;
        }
        if self.hub.lock().len() < MOST_CLIENTS {
            tokio::spawn(self.serve_known(connect));
        }
    }

    async fn serve_known(mut self, connect: Connect) {
        let will = connect.last_will.clone().map(publish_of);
        let (number, messages) = self.hub.lock().join(&connect.client_id, will);
        let end = self.talk(number, messages, &connect).await;
        let mut hub = self.hub.lock();
        if let (Some(will), End::Broken) = (hub.leave(number), end) {
            hub.publish(&will);
        }
    }

    /// Passes messages on, in both directions.
    async fn talk(
        &mut self,
        number: u64,
        mut messages: UnboundedReceiver<Queued>,
        it: &Connect,
    ) -> End {
        let silence = match it.keep_alive {
            0 => ENDLESS,
            seconds => Duration::from_secs(u64::from(seconds)).mul_f32(1.5),
        };
        let welcome = ConnAck::new(ConnectReturnCode::Success, false);
        if self.stream.write(Packet::ConnAck(welcome)).await.is_none() {
            return End::Broken;
        }
        loop {
            let written = tokio::select! {
                packet = timeout(silence, self.stream.read(MOST_BYTES)) => match packet {
                    Ok(Some(Packet::Disconnect)) => return End::Farewell,
                    Ok(Some(packet)) => self.take(number, packet).await,
                    _ => None,
                },
                message = messages.recv() => match message {
                    Some(queued) => self.stream.write(Packet::Publish(queued.message)).await,
                    // Another client with the same name has taken its place.
                    None => None,
                },
            };
            if written.is_none() {
                return End::Broken;
            }
        }
    }

    /// Takes a packet, and answers it; `None` for one that may not be sent.
    async fn take(&mut self, number: u64, packet: Packet) -> Option<()> {
        let answer = match packet {
            Packet::Publish(message) => self.pass_on(&message),
            Packet::PubRel(release) => Some(Packet::PubComp(PubComp::new(release.pkid))),
            Packet::Subscribe(subscribe) => Some(self.subscribe(number, subscribe).await),
            Packet::Unsubscribe(it) => {
                self.hub.lock().unsubscribe(number, &it.topics);
                Some(Packet::UnsubAck(UnsubAck::new(it.pkid)))
            }
            Packet::PingReq => Some(Packet::PingResp),
            Packet::PubAck(_) | Packet::PubRec(_) | Packet::PubComp(_) => None,
            _ => return None,
        };
        match answer {
            Some(answer) => self.stream.write(answer).await,
            None => Some(()),
        }
    }

    fn pass_on(&self, message: &Publish) -> Option<Packet> {
        self.hub.lock().publish(message);
        match message.qos {
            QoS::AtMostOnce => None,
            QoS::AtLeastOnce => Some(Packet::PubAck(PubAck::new(message.pkid))),
            QoS::ExactlyOnce => Some(Packet::PubRec(PubRec::new(message.pkid))),
        }
    }

    async fn subscribe(&self, number: u64, subscribe: Subscribe) -> Packet {
        let mut codes = Vec::with_capacity(subscribe.filters.len());
        for filter in subscribe.filters {
            let quality = lower(filter.qos, QoS::AtLeastOnce);
            let is_valid = valid_filter(&filter.path);
            codes.push(match is_valid && self.hub.lock().subscribe(number, filter.path, quality) {
                true => SubscribeReasonCode::Success(quality),
                false => SubscribeReasonCode::Failure,
            });
            // Each filter is compared with all that is kept: other clients have their turn.
            yield_now().await;
        }
        Packet::SubAck(SubAck::new(subscribe.pkid, codes))
    }
}

fn publish_of(will: LastWill) -> Publish {
    let mut publish = Publish::new(will.topic, will.qos, will.message.to_vec());
    publish.retain = will.retain;
    publish
}
