//! `regatta orders`: lists, shows, cancels and imports the transport orders of a running fleet
//! manager, through its web API.

mod check;
mod list;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, Subcommand};
use regatta_orders::{Client, ClientError, TimedDraft, read_orders, read_token};
use regatta_plugin::FleetName;
use serde_json::{Value, json};

use crate::arguments::LayoutArgs;
use crate::failure::Failure;

#[derive(Subcommand)]
pub enum OrdersCommand {
    /// List orders: their states, robots and stops.
    List {
        /// List only orders in this state: open, created, waiting, fetching, carrying, handling,
        /// finished …
        #[arg(long)]
        state: Option<String>,
        /// Print JSON.
        #[arg(long)]
        json: bool,
        #[command(flatten)]
        manager: Manager,
    },
    /// Show an order with its history, as JSON.
    Show {
        /// Name of the order.
        name: String,
        #[command(flatten)]
        manager: Manager,
    },
    /// Cancel an order.
    Cancel {
        /// Name of the order.
        name: String,
        /// Cancel it even if its robot has handled a stop; the load stays on the robot.
        #[arg(long)]
        immediate: bool,
        #[command(flatten)]
        manager: Manager,
    },
    /// Check the orders of a day against a plant: rows that can't be used, rates, flows.
    Check {
        /// File of orders: CSV, XLSX, Parquet or YAML.
        file: PathBuf,
        /// Layout of any format, or scenario, whose stations they name.
        #[arg(long, value_hint = clap::ValueHint::FilePath)]
        plant: PathBuf,
        /// Print JSON.
        #[arg(long)]
        json: bool,
        #[command(flatten)]
        layout: LayoutArgs,
    },
    /// Send all orders of a file, or none: CSV, XLSX or Parquet
    /// (name,time,priority,earliest,deadline,stops), or YAML.
    Import {
        /// File of orders, with times in seconds of simulated time.
        file: PathBuf,
        #[command(flatten)]
        manager: Manager,
    },
}

/// The fleet manager that a command is sent to.
#[derive(Args)]
pub struct Manager {
    /// Fleet of the manager, if it is one of this user.
    #[arg(long, default_value_t)]
    fleet: FleetName,
    /// Address of its web API, such as http://127.0.0.1:55200.
    #[arg(long, conflicts_with = "fleet")]
    url: Option<String>,
    /// File with the token for this address [default: this user's token, on this machine].
    #[arg(long, requires = "url")]
    token_file: Option<PathBuf>,
}

impl Manager {
    fn client(&self) -> Result<Client, Failure> {
        let Some(url) = &self.url else { return Ok(Client::of_fleet(&self.fleet)?) };
        let token = self.token_file.as_deref().map(read_token).transpose()?;
        Ok(Client::new(url, token)?)
    }
}

/// Runs `regatta orders`.
pub fn run(command: OrdersCommand) -> Result<ExitCode, Failure> {
    match command {
        OrdersCommand::List { state, json, manager } => {
            list::run(&manager.client()?, state.as_deref(), json)?
        }
        OrdersCommand::Show { name, manager } => {
            println!("{:#}", manager.client()?.get(&Client::order_path(&name))?);
        }
        OrdersCommand::Cancel { name, immediate, manager } => {
            cancel(&manager.client()?, &name, immediate)?
        }
        OrdersCommand::Check { file, plant, json, layout } => {
            return check::run(&file, &plant, &layout, json);
        }
        OrdersCommand::Import { file, manager } => import(&manager.client()?, read_orders(&file)?)?,
    }
    Ok(ExitCode::SUCCESS)
}

fn cancel(client: &Client, name: &str, immediate: bool) -> Result<(), Failure> {
    let query = if immediate { "?immediate=true" } else { "" };
    let path = format!("{}/withdrawal{query}", Client::order_path(name));
    let answer = client.post(&path, &Value::Null)?;
    println!("{name}: {}", answer["state"].as_str().unwrap_or("cancelled"));
    Ok(())
}

fn import(client: &Client, orders: Vec<TimedDraft>) -> Result<(), Failure> {
    let lines: Vec<_> = orders.iter().map(|order| order.line).collect();
    let drafts = orders.into_iter().map(|TimedDraft { secs, mut draft, .. }| {
        // The API has no time of creation: a later order is one that starts later.
        let earliest = draft.earliest_start.unwrap_or(0.0).max(secs);
        draft.earliest_start = (earliest > 0.0).then_some(earliest);
        draft
    });
    let body = json!(drafts.collect::<Vec<_>>());
    let kept =
        client.post("/v1/transportOrders", &body).map_err(|error| with_line(error, &lines))?;
    println!("{} orders imported", kept.as_array().map_or(0, Vec::len));
    Ok(())
}

/// Replaces the number of an order in the reason by its line in the file.
fn with_line(error: ClientError, lines: &[usize]) -> Failure {
    let text = error.to_string();
    let place = text.strip_prefix("order ").and_then(|rest| rest.split_once(": "));
    let line = place
        .and_then(|(number, reason)| Some((lines.get(number.parse::<usize>().ok()? - 1)?, reason)));
    line.map_or_else(|| error.into(), |(line, reason)| format!("line {line}: {reason}").into())
}
