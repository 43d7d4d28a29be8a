//! The connection to ROS 2: a node, and its topics and services over DDS (RustDDS).

use std::net::{IpAddr, Ipv4Addr};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{SystemTime, UNIX_EPOCH};

use regatta_plugin::tell;
use ros2_client::action::{ActionServer, ActionServerQosPolicies};
use ros2_client::dds::rustdds::policy::{Durability, History, ResourceLimits};
use ros2_client::dds::rustdds::{
    DomainParticipantBuilder, Duration, QosPolicies, QosPolicyBuilder, TopicKind,
};
use ros2_client::error::{CreateError, WriteError};
use ros2_client::qos::{QosProfile, WhenFull};
use ros2_client::{
    ActionTypeName, Context, Message, MessageTypeName, Name, Node, NodeCreateError, NodeName,
    NodeOptions, Publisher, RmwRequestId, Server, ServiceMapping, ServiceTypeName, Subscription,
};

use crate::message::Typed;
use crate::message::geometry::{Log, Time};
use crate::options::Namespace;

/// The bytes of messages to a topic that may wait for readers that don't answer. A reader that is
/// stopped counts as gone after twenty seconds or so; until then messages wait for it.
const WAITING_BYTES: usize = 32 << 20;
/// The most messages that wait.
const MOST_WAITING: usize = 8_192;

/// The name of the node.
const NODE: &str = "regatta";

/// The error of connecting to ROS 2.
#[derive(Debug, thiserror::Error)]
pub(crate) enum LinkError {
    /// The sockets can't be opened, for example.
    #[error("can't join domain {domain} of ROS 2 ({reason}); choose another with --domain")]
    Participant { domain: u16, reason: CreateError },
    #[error("can't create a node of ROS 2: {0}")]
    Node(#[from] NodeCreateError),
    #[error("can't create a topic, a service or an action of ROS 2: {0}")]
    Endpoint(#[from] CreateError),
}

/// The node.
pub(crate) struct Link {
    node: Node,
    context: Context,
    namespace: Namespace,
    refused: Arc<AtomicU64>,
}

/// The messages of a topic that a new reader gets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Keep {
    /// Those that are published from then on.
    Nothing,
    /// The newest one, too (`transient local`).
    Newest,
}

impl Link {
    /// Opens the node. `networks` are the addresses of the interfaces to use; empty for all.
    pub fn open(
        domain: u16,
        networks: &[Ipv4Addr],
        namespace: &Namespace,
    ) -> Result<Self, LinkError> {
        let failed = |reason| LinkError::Participant { domain, reason };
        let mut builder = DomainParticipantBuilder::new(domain);
        if !networks.is_empty() {
            builder = builder.with_only_networks(networks.iter().copied().map(IpAddr::V4));
        }
        let participant = builder.build().map_err(|error| failed(error.into()))?;
        let context = Context::from_domain_participant(participant).map_err(failed)?;
        let name = NodeName::new(&namespace.absolute(), NODE)
            .map_err(|error| CreateError::BadParameter { reason: error.to_string() })?;
        let options = NodeOptions::new().enable_rosout(false).start_parameter_services(false);
        let node = context.new_node(name, options)?;
        let refused = Arc::default();
        Ok(Self { node, context, namespace: namespace.clone(), refused })
    }

    /// The number of the participant on this machine, which its ports follow from.
    pub fn number(&self) -> u16 {
        self.context.domain_participant().participant_id()
    }

    /// A logger, whose messages arrive on `/rosout`.
    pub fn logger(&mut self) -> Result<Logger, LinkError> {
        Ok(Logger { output: self.output("/rosout", Keep::Newest, LOG_BYTES)? })
    }

    /// The number of messages that couldn't be published, as readers didn't take those before.
    pub fn refused(&self) -> u64 {
        self.refused.load(Ordering::Relaxed)
    }

    /// Opens a topic to publish messages of about this size. The name is below the namespace,
    /// unless it begins with a slash.
    pub fn output<M: Typed>(
        &mut self,
        name: &str,
        keep: Keep,
        bytes: usize,
    ) -> Result<Output<M>, LinkError> {
        let publisher = self.publisher(name, M::PACKAGE, M::NAME, qos(keep, bytes))?;
        let refused = Arc::clone(&self.refused);
        Ok(Output { publisher, name: name.to_owned(), refused, is_full: false })
    }

    fn publisher<M: Message>(
        &mut self,
        name: &str,
        package: &str,
        kind: &str,
        qos: QosPolicies,
    ) -> Result<Publisher<M>, LinkError> {
        let topic = self.topic(name, package, kind, &qos)?;
        Ok(self.node.create_publisher(&topic, None)?)
    }

    /// Opens a topic to take messages of. At most ten wait; the oldest of more are dropped.
    pub fn input<M: Typed + 'static>(&mut self, name: &str) -> Result<Subscription<M>, LinkError> {
        let qos = QosPolicyBuilder::new()
            .reliable(Duration::ZERO)
            .durability(Durability::Volatile)
            .history(History::KeepLast { depth: 10 })
            .build();
        let topic = self.topic(name, M::PACKAGE, M::NAME, &qos)?;
        Ok(self.node.create_subscription(&topic, None)?)
    }

    fn topic(
        &self,
        name: &str,
        package: &str,
        kind: &str,
        qos: &QosPolicies,
    ) -> Result<ros2_client::dds::rustdds::Topic, LinkError> {
        let dds_name = format!("rt{}", self.namespace.resolve(name));
        let kind = MessageTypeName::new(package, kind).dds_msg_type();
        let participant = self.context.domain_participant();
        let topic = participant.create_topic(dds_name, kind, qos, TopicKind::NoKey);
        Ok(topic.map_err(CreateError::from)?)
    }

    /// Opens a service.
    pub fn service<Q, A>(
        &mut self,
        name: &str,
        package: &str,
        kind: &str,
    ) -> Result<Server<Q, A>, LinkError>
    where
        Q: Message + Clone + 'static,
        A: Message + 'static,
    {
        let name = self.name(name);
        let kind = ServiceTypeName::new(package, kind);
        let (requests, responses) = (service_qos(), service_qos());
        Ok(self.node.create_server(ServiceMapping::Enhanced, &name?, &kind, requests, responses)?)
    }

    /// Opens an action.
    pub fn action<G, R, F>(
        &mut self,
        name: &str,
        package: &str,
        kind: &str,
    ) -> Result<ActionServer<G, R, F>, LinkError>
    where
        G: Message + Clone + 'static,
        R: Message + Clone + 'static,
        F: Message + 'static,
    {
        let name = self.name(name)?;
        let kind = ActionTypeName::new(package, kind);
        let qos = ActionServerQosPolicies {
            goal_service: service_qos(),
            result_service: service_qos(),
            cancel_service: service_qos(),
            feedback_publisher: service_qos(),
            status_publisher: service_qos()
                .durability(ros2_client::qos::Durability::TransientLocal)
                .history(ros2_client::qos::History::KeepLast { depth: 1 }),
        };
        Ok(self.node.create_action_server(ServiceMapping::Enhanced, &name, &kind, qos)?)
    }

    fn name(&self, name: &str) -> Result<Name, CreateError> {
        Name::parse(&self.namespace.resolve(name))
            .map_err(|error| CreateError::BadParameter { reason: error.to_string() })
    }
}

/// Messages of a topic, or requests of a service, that are taken before others have their turn.
const AT_ONCE: usize = 16;

/// Takes the messages that have come, the oldest first. What can't be decoded is left out.
pub(crate) fn taken<M: Message + 'static>(input: &Subscription<M>) -> Vec<M> {
    let messages = (0..AT_ONCE).map_while(|_| input.take().transpose());
    messages.filter_map(|message| message.ok().map(|(message, _)| message)).collect()
}

/// Takes the requests that have come. One that can't be decoded has no answer in ROS: its client
/// runs into its time limit.
pub(crate) fn asked<Q, A>(server: &Server<Q, A>) -> Vec<(RmwRequestId, Q)>
where
    Q: Message + 'static,
    A: Message + 'static,
{
    let requests = (0..AT_ONCE).map_while(|_| server.receive_request().transpose());
    requests.filter_map(Result::ok).collect()
}

/// The quality of service of a published topic: reliable, as the displays of RViz want it, and
/// never waited for.
fn qos(keep: Keep, bytes: usize) -> QosPolicies {
    let waiting = (WAITING_BYTES / bytes.max(1)).clamp(4, MOST_WAITING) as i32;
    let durability = match keep {
        Keep::Nothing => Durability::Volatile,
        Keep::Newest => Durability::TransientLocal,
    };
    QosPolicyBuilder::new()
        .reliable(Duration::ZERO)
        .durability(durability)
        .history(History::KeepLast { depth: 1 })
        .resource_limits(ResourceLimits {
            max_samples: waiting,
            max_instances: 1,
            max_samples_per_instance: waiting,
        })
        .build()
}

fn service_qos() -> QosProfile {
    QosProfile::subscription_default()
        .reliability_reliable(WhenFull::Fail)
        .history(ros2_client::qos::History::KeepLast { depth: 10 })
}

/// Says where DDS listens, and that it can't be kept to an interface. `number` is that of the
/// participant on this machine.
pub(crate) fn tell_ports(domain: u16, number: u16, networks: &[Ipv4Addr], can: &str) {
    let base = 7_400 + 250 * u32::from(domain);
    let ports = [0, 1, 10 + 2 * u32::from(number), 11 + 2 * u32::from(number)];
    let ports = ports.map(|port| (base + port).to_string()).join(", ");
    let on = match networks {
        [] => "all interfaces".to_owned(),
        networks => networks.iter().map(Ipv4Addr::to_string).collect::<Vec<_>>().join(", "),
    };
    tell!(
        "ros2: in domain {domain} on {on}; DDS binds its UDP ports {ports} on all interfaces, and \
         has no passwords: anyone who reaches them can {can} the fleet"
    );
}

/// A topic that is published.
pub(crate) struct Output<M: Message> {
    publisher: Publisher<M>,
    name: String,
    refused: Arc<AtomicU64>,
    /// Whether the last message was refused.
    is_full: bool,
}

impl<M: Message> Output<M> {
    /// Publishes a message, unless readers haven't taken those before.
    pub fn publish(&mut self, message: M) {
        let was_full = std::mem::replace(&mut self.is_full, false);
        let Err(error) = self.publisher.publish(message) else { return };
        self.is_full = true;
        self.refused.fetch_add(1, Ordering::Relaxed);
        if was_full {
            return;
        }
        match error {
            WriteError::WouldBlock { .. } => tell!(
                "ros2: {}: a reader takes no messages; they are left out until it does, or is gone",
                self.name
            ),
            error => tell!("ros2: {}: {error}", self.name),
        }
    }
}

/// Bytes of a message to the log, about.
const LOG_BYTES: usize = 200;

/// Writes to the log of ROS 2.
pub(crate) struct Logger {
    output: Output<Log>,
}

impl Logger {
    /// Writes a warning. Its time is that of the machine.
    pub fn warn(&mut self, text: &str) {
        let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        self.output.publish(Log {
            stamp: Time::after(now),
            level: Log::WARN,
            name: NODE.to_owned(),
            msg: text.to_owned(),
            ..Log::default()
        });
    }
}
