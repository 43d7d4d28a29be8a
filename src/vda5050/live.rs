//! Judges the traffic of a broker while it goes on.

use std::path::PathBuf;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use clap::Args;
use regatta_plugin::{Termination, tell};
use regatta_vda5050::broker::{self, Broker, BrokerUrl, Incoming, Session};
use regatta_vda5050::judge::{Judge, Report, Seen};

use super::{CheckArgs, take};
use crate::arguments::Time;
use crate::failure::{Failure, plugin_failure};

/// The time between two looks for messages.
const PAUSE: Duration = Duration::from_millis(5);
/// The topics of the standard, below an interface of one level.
const TOPICS: [&str; 2] = ["+/v2/#", "+/v3/#"];

/// Options of a broker.
#[derive(Args, Debug)]
pub struct LiveArgs {
    /// Time to listen to a broker [default: until Ctrl-C]
    #[arg(long = "for", value_name = "TIME")]
    duration: Option<Time>,
    /// Topics to listen to on a broker, with + and # [default: +/v2/# and +/v3/#]
    #[arg(long, value_name = "FILTER")]
    topic: Vec<String>,
    /// File with the password of the broker's user [default: the environment variable
    /// REGATTA_MQTT_PASSWORD]
    #[arg(long, value_name = "FILE")]
    password_file: Option<PathBuf>,
}

impl LiveArgs {
    fn topics(&self) -> Vec<String> {
        match self.topic.is_empty() {
            true => TOPICS.map(str::to_owned).to_vec(),
            false => self.topic.clone(),
        }
    }
}

/// The connection to the broker, as far as it was told.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Link {
    New,
    Up,
    Down,
}

/// Judges messages until Ctrl-C, or for the time of the options.
pub fn listen(args: &CheckArgs, url: &BrokerUrl) -> Result<(Judge, Report), Failure> {
    let stop = Termination::watch().map_err(plugin_failure)?;
    let password = broker::password(args.live.password_file.as_deref())?;
    let mut broker = Broker::start(url.clone(), password)
        .map_err(|error| format!("can't start a thread for {url}: {error}"))?;
    broker.connect(&Session {
        client_id: format!("regatta-check-{}", std::process::id()),
        will: None,
        topics: args.live.topics(),
    });
    let (mut judge, mut report) = (Judge::new(args.protocol), Report::new(args.examples));
    let (start, mut link) = (Instant::now(), Link::New);
    while !stop.requested() && !is_over(start, args.live.duration) {
        while let Some(incoming) = broker.take() {
            link = receive(args, incoming, link, url, &mut judge, &mut report)?;
        }
        // A broker that is gone brings no states: that says nothing about vehicles.
        if link == Link::Up {
            judge
                .pass(seconds(SystemTime::now()))
                .into_iter()
                .for_each(|finding| take(args, &mut report, finding));
        }
        std::thread::sleep(PAUSE);
    }
    broker.end();
    if judge.tally().judged == 0 {
        let topics = args.live.topics().join(" and ");
        return Err(format!("{url}: no message of VDA 5050 came on {topics}: see --topic").into());
    }
    Ok((judge, report))
}

fn is_over(start: Instant, duration: Option<Time>) -> bool {
    duration.is_some_and(|duration| start.elapsed() >= duration.0)
}

fn receive(
    args: &CheckArgs,
    incoming: Incoming,
    link: Link,
    url: &BrokerUrl,
    judge: &mut Judge,
    report: &mut Report,
) -> Result<Link, Failure> {
    match incoming {
        Incoming::Connected { .. } => Ok(Link::Up),
        Incoming::Lost { reason, .. } => lost(link, url, &reason),
        Incoming::Message { topic, payload, time } => {
            let (time, topic) = (Some(seconds(time)), topic.as_str());
            let seen = Seen { time, topic, payload: &payload, delivery: None };
            judge.take(&seen).into_iter().for_each(|finding| take(args, report, finding));
            Ok(link)
        }
    }
}

fn lost(link: Link, url: &BrokerUrl, reason: &str) -> Result<Link, Failure> {
    match link {
        Link::New => {
            let advice = "start the broker, or give another address, user or password";
            Err(format!("{url}: can't connect ({reason}): {advice}").into())
        }
        Link::Up => {
            tell!("regatta: {url}: the connection was lost ({reason}); connecting again");
            Ok(Link::Down)
        }
        Link::Down => Ok(Link::Down),
    }
}

/// Seconds since 1970.
pub fn seconds(time: SystemTime) -> f64 {
    time.duration_since(UNIX_EPOCH).map_or(0.0, |since| since.as_secs_f64())
}
