//! Two network namespaces, with delay, loss and a cut between them. They need root and `ip`,
//! delay and loss `tc` with netem; what is missing is told and left out.

use std::process::{Command, Stdio};
use std::time::Duration;

use crate::process::{Hosts, Process};

/// Two namespaces, joined by a cable; removed when dropped.
struct Cable {
    names: [String; 2],
}

/// Runs a command line. Returns whether it succeeded.
fn succeeds(line: &str) -> bool {
    let mut words = line.split(' ');
    let mut command = Command::new(words.next().expect("a program"));
    command.args(words).stdout(Stdio::null()).stderr(Stdio::null());
    command.status().is_ok_and(|status| status.success())
}

impl Cable {
    /// Lays a cable, or returns `None` where that isn't possible.
    fn lay() -> Option<Self> {
        let names = ["a", "b"].map(|end| format!("rgtm{}{end}", std::process::id()));
        let cable = Self { names };
        let [a, b] = &cable.names;
        let lines = [
            format!("ip netns add {a}"),
            format!("ip netns add {b}"),
            format!("ip -n {a} link add eth0 type veth peer name eth0 netns {b}"),
            format!("ip -n {a} addr add 10.77.0.1/24 dev eth0"),
            format!("ip -n {b} addr add 10.77.0.2/24 dev eth0"),
            format!("ip -n {a} link set eth0 up"),
            format!("ip -n {b} link set eth0 up"),
        ];
        if !lines.iter().all(|line| succeeds(line)) {
            return None;
        }
        if !succeeds(&format!("tc -n {a} qdisc add dev eth0 root netem delay 20ms loss 1%")) {
            regatta_plugin::tell!("not tested: delay and loss, which need tc with netem");
        }
        Some(cable)
    }

    fn set(&self, state: &str) {
        assert!(succeeds(&format!("ip -n {} link set eth0 {state}", self.names[0])));
    }
}

impl Drop for Cable {
    fn drop(&mut self) {
        for name in &self.names {
            succeeds(&format!("ip netns del {name}"));
        }
    }
}

#[test]
fn a_fleet_survives_delay_loss_and_a_cut() {
    let Some(cable) = Cable::lay() else {
        regatta_plugin::tell!("not tested: network namespaces, which need root and ip");
        return;
    };
    let [a, b] = [0, 1].map(|end| ["ip", "netns", "exec", &cable.names[end]]);
    let hosts = Hosts { address: "tcp/10.77.0.1:7447".to_owned(), ..Hosts::new("cable") };
    let (fleet, copy) = (hosts.fleet.as_str(), hosts.copy.as_str());
    let _engine = hosts.engine();
    let send = ["mirror", "send", "--fleet", fleet, "--listen", &hosts.address];
    let _send = Process::start_in(&a, &send);
    let receive =
        ["mirror", "receive", "--from", fleet, "--fleet", copy, "--connect", &hosts.address];
    let _receive = Process::start_in(&b, &receive);
    hosts.wait_for_frames();
    cable.set("down");
    std::thread::sleep(Duration::from_secs(2));
    cable.set("up");
    hosts.wait_for_frames();
}
