//! The part of a study of a master that all runs share: the broker, the vehicles, the names of
//! nodes and edges on the broker, and the commands.

use std::collections::BTreeMap;
use std::process::Command;

use clap::Parser;
use regatta_layout::RouteGraph;
use regatta_study::plan::Variant;
use regatta_vda5050::Cli;
use regatta_vda5050::broker::{BrokerUrl, PASSWORD_VARIABLE};

use super::hand_over::{Way, Words};
use super::template::{filled, plain, words};
use crate::failure::{Failure, plugin_failure};

/// The options of the vehicles that the study gives itself.
const OWN_OPTIONS: [&str; 2] = ["--broker", "--fleet"];

/// The broker, the vehicles and the commands of a study.
#[derive(Debug)]
pub struct Site<'a> {
    /// The options of the vehicles.
    pub vehicles: Cli,
    /// Those of them that the user gave.
    pub options: Vec<String>,
    /// The broker.
    pub url: BrokerUrl,
    /// The password of its user.
    pub password: Option<String>,
    /// The command line of the master, if each run starts it.
    pub manager: Option<Vec<String>>,
    /// The way in which the master gets transport orders.
    pub way: Way,
    graph: &'a RouteGraph,
    edges: BTreeMap<String, u32>,
    /// The first station of each node with one.
    stations: BTreeMap<u32, &'a str>,
}

impl<'a> Site<'a> {
    /// Reads the options of the vehicles, and finds or starts the broker.
    ///
    /// # Errors
    /// If an option is invalid, or the study's own broker can't be started.
    pub fn new(
        variant: &'a Variant,
        broker: Option<&BrokerUrl>,
        options: &str,
        manager: Option<&str>,
        way: Way,
    ) -> Result<Self, Failure> {
        let options: Vec<String> = options.split_whitespace().map(str::to_owned).collect();
        if let Some(own) =
            OWN_OPTIONS.iter().find(|own| options.iter().any(|it| it.starts_with(**own)))
        {
            return Err(format!("--vehicle-options: {own} is the study's own").into());
        }
        let broker = broker.map(|url| ["--broker".to_owned(), url.to_text()]);
        let program = ["vda5050".to_owned()].into_iter();
        let args = program.chain(options.iter().cloned()).chain(broker.into_iter().flatten());
        let vehicles = Cli::try_parse_from(args).map_err(|error| in_a_line(&error))?;
        let manager = manager.map(words).transpose()?;
        let (url, password) = vehicles.find_broker().map_err(plugin_failure)?;
        let graph = &*variant.graph;
        Ok(Self {
            vehicles,
            options,
            url,
            password,
            manager,
            way,
            edges: edges(graph),
            stations: stations(graph),
            graph,
        })
    }

    /// The words of commands beside those of an order.
    pub fn words(&self, vehicles: u32) -> Words {
        let BrokerUrl { user, host, port } = &self.url;
        vec![
            ("broker", self.url.to_text()),
            ("host", host.clone()),
            ("port", port.to_string()),
            ("user", user.clone().unwrap_or_default()),
            ("vehicles", vehicles.to_string()),
        ]
    }

    /// Returns the command that starts the master of a run, if the study starts it.
    pub fn master(&self, vehicles: u32) -> Option<Command> {
        let own = self.words(vehicles);
        let values: Vec<_> = own.iter().map(|(name, value)| (*name, &**value)).collect();
        let mut words = self.manager.as_ref()?.iter().map(|word| filled(word, &values, plain));
        let mut command = Command::new(words.next()?);
        command.args(words);
        command.envs(self.password.as_ref().map(|password| (PASSWORD_VARIABLE, password)));
        Some(command)
    }

    /// The arguments of the vehicles' process, after the name of the plugin.
    pub fn vehicle_args(&self) -> Vec<String> {
        let mut args = Vec::new();
        let mut options = self.options.iter();
        while let Some(option) = options.next() {
            // Those of a broker of the plugin's own: the study has started it.
            match option.as_str() {
                "--anonymous" => {}
                "--listen" => drop(options.next()),
                option if option.starts_with("--listen=") => {}
                option => args.push(option.to_owned()),
            }
        }
        args.extend(["--broker".to_owned(), self.url.to_text()]);
        args
    }

    /// The id of a node on the broker: its name, or its number.
    pub fn node(&self, index: u32) -> String {
        let node = &self.graph.nodes()[index as usize];
        node.name().map_or_else(|| node.id.to_string(), str::to_owned)
    }

    /// The station of a node, or its id if it has none.
    pub fn station(&self, index: u32) -> String {
        self.stations.get(&index).map_or_else(|| self.node(index), |name| (*name).to_owned())
    }

    /// The places of nodes that have several names, or belong to a station.
    pub fn places(&self) -> Vec<(String, String)> {
        let mut places = Vec::new();
        for (node, index) in self.graph.nodes().iter().zip(0..) {
            let place = self.station(index);
            let names = node.other_names().into_iter().chain([self.node(index)]);
            places.extend(names.map(|name| (name, place.clone())));
        }
        places
    }

    /// The id of an edge in the layout.
    pub fn edge(&self, id: &str) -> Option<u32> {
        self.edges.get(id).copied()
    }
}

fn edges(graph: &RouteGraph) -> BTreeMap<String, u32> {
    let named = graph.edges().iter().map(|edge| {
        let name = edge.name().map_or_else(|| edge.id.to_string(), str::to_owned);
        (name, edge.id)
    });
    named.collect()
}

fn stations(graph: &RouteGraph) -> BTreeMap<u32, &str> {
    let mut stations = BTreeMap::new();
    for station in graph.stations() {
        for node in &station.nodes {
            stations.entry(node.0).or_insert(&*station.name);
        }
    }
    stations
}

/// The first line of an error of options, without the name of the kind.
fn in_a_line(error: &clap::Error) -> Failure {
    let text = error.to_string();
    let line = text.lines().next().unwrap_or_default().trim_start_matches("error: ");
    format!("--vehicle-options: {line}").into()
}
