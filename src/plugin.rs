//! `regatta plugin NAME`: the built-in plugins.

use std::any::TypeId;

use clap::parser::ValueSource;
use clap::{Arg, Args, Command, CommandFactory, Parser};
use regatta_plugin::{Plugin, Rate};
use regatta_scenario::closest;

use crate::failure::{Failure, plugin_failure};
use crate::version;

/// Makes a plugin of its arguments, the first of which is its name.
type MakePlugin = fn(Vec<String>) -> regatta_plugin::Result<Box<dyn Plugin>>;

/// A built-in plugin.
struct BuiltIn {
    name: &'static str,
    about: &'static str,
    /// Runs the plugin with its arguments, the first of which is its name.
    run: fn(Vec<String>) -> regatta_plugin::Result,
    /// Makes the plugin for a run in one process; `None` if it waits for others there.
    make: Option<MakePlugin>,
    /// Adds the plugin's options, for completions and man pages.
    add_options: fn(Command) -> Command,
}

/// The built-in plugins. A new one is a crate under `plugins/` and an entry here.
const PLUGINS: &[BuiltIn] = &[
    BuiltIn {
        name: "collision",
        about: "Find robots that collide, now or soon",
        run: |args| regatta_collision::run_from(args),
        make: Some(|args| {
            let cli = regatta_collision::Cli::try_parse_from(args)?;
            Ok(Box::new(regatta_collision::plugin(&cli)?))
        }),
        add_options: |_| regatta_collision::Cli::command(),
    },
    BuiltIn {
        name: "fleet-manager",
        about: "Carry out transport orders, with robots that never touch each other",
        run: |args| regatta_fleet_manager::run_from(args),
        make: Some(|args| {
            let cli = regatta_fleet_manager::Cli::try_parse_from(args)?;
            Ok(Box::new(regatta_fleet_manager::plugin(cli)?))
        }),
        add_options: |_| regatta_fleet_manager::Cli::command(),
    },
    BuiltIn {
        name: "foxglove",
        about: "Show the fleet live in Foxglove or Lichtblick, which can pause and step it",
        run: |args| regatta_foxglove::run_from(args),
        make: None,
        add_options: |_| regatta_foxglove::Cli::command(),
    },
    BuiltIn {
        name: "hello",
        about: "Print the fleet's centre: the smallest plugin, to copy",
        run: |args| regatta_plugin::run_from(regatta_hello::Centre, args),
        make: Some(|_| Ok(Box::new(regatta_hello::Centre))),
        add_options: regatta_plugin::Options::augment_args,
    },
    BuiltIn {
        name: "meter",
        about: "Measure the throughput of the fleet: orders and their times",
        run: |args| regatta_meter::run_from(args),
        make: None,
        add_options: |_| regatta_meter::Cli::command(),
    },
    BuiltIn {
        name: "metrics",
        about: "Export metrics to Prometheus, and write them as CSV",
        run: |args| regatta_metrics::run_from(args, version::commit()),
        make: None,
        add_options: |_| regatta_metrics::exporter::Cli::command(),
    },
    BuiltIn {
        name: "record",
        about: "Record the fleet to an MCAP file",
        run: regatta_record::record_from,
        make: Some(|args| Ok(Box::new(regatta_record::plugin(args)?))),
        add_options: regatta_record::RecordArgs::augment_args,
    },
    #[cfg(feature = "ros2")]
    BuiltIn {
        name: "ros2",
        about: "Make the fleet part of ROS 2: poses, markers, goals, simulation services",
        run: |args| regatta_ros2::run_from(args),
        make: None,
        add_options: |_| regatta_ros2::Cli::command(),
    },
    BuiltIn {
        name: "traffic",
        about: "Publish figures of each edge: throughput, speed, waiting",
        run: |args| regatta_traffic::run_from(args),
        make: Some(|args| {
            Ok(Box::new(regatta_traffic::plugin(regatta_traffic::Cli::try_parse_from(args)?)))
        }),
        add_options: |_| regatta_traffic::Cli::command(),
    },
    BuiltIn {
        name: "udp",
        about: "Send poses over UDP, as lines of text",
        run: |args| regatta_udp::run(args),
        make: None,
        add_options: |command| command,
    },
    BuiltIn {
        name: "udp-source",
        about: "Publish poses that are received over UDP as a fleet",
        run: |args| regatta_udp::source::run(args),
        make: None,
        add_options: |command| command,
    },
    BuiltIn {
        name: "validator",
        about: "Validate the fleet: contacts, motion, orders",
        run: |args| regatta_validator::run_from(args),
        make: Some(|args| {
            Ok(Box::new(regatta_validator::plugin(regatta_validator::Cli::try_parse_from(args)?)))
        }),
        add_options: |_| regatta_validator::Cli::command(),
    },
    BuiltIn {
        name: "vda5050",
        about: "Make the robots vehicles of VDA 5050 on an MQTT broker",
        run: |args| regatta_vda5050::run_from(args),
        make: None,
        add_options: |_| regatta_vda5050::Cli::command(),
    },
];

#[derive(Args)]
pub struct PluginArgs {
    /// Name of the plugin, and its arguments; `NAME --help` lists them.
    #[arg(value_name = "NAME [ARG]", trailing_var_arg = true, allow_hyphen_values = true)]
    pub name_and_args: Vec<String>,
}

/// Whether a built-in plugin has this name.
pub fn is_built_in(name: &str) -> bool {
    PLUGINS.iter().any(|plugin| plugin.name == name)
}

/// Whether a built-in plugin does more with these arguments than take part in its fleet: they name
/// a file, an address, or something that isn't known, or it opens a network without any.
pub fn reaches_out(name: &str, args: &[String]) -> bool {
    let Some(plugin) = PLUGINS.iter().find(|plugin| plugin.name == name) else { return false };
    // They open ports, whatever the options: DDS to everybody.
    if ["foxglove", "ros2"].contains(&name) {
        return true;
    }
    if args.is_empty() {
        return false;
    }
    let command = (plugin.add_options)(Command::new(plugin.name));
    let words = std::iter::once(name).chain(args.iter().map(String::as_str));
    match command.clone().try_get_matches_from(words) {
        Ok(matches) => command.get_arguments().any(|argument| {
            let source = matches.value_source(argument.get_id().as_str());
            source == Some(ValueSource::CommandLine) && !is_harmless(argument)
        }),
        Err(_) => true,
    }
}

/// Whether an argument is a flag, a number or one of several words.
fn is_harmless(argument: &Arg) -> bool {
    let kind = argument.get_value_parser().type_id();
    let numbers = [
        TypeId::of::<u8>(),
        TypeId::of::<u16>(),
        TypeId::of::<u32>(),
        TypeId::of::<u64>(),
        TypeId::of::<usize>(),
        TypeId::of::<f32>(),
        TypeId::of::<f64>(),
        TypeId::of::<Rate>(),
    ];
    !argument.get_action().takes_values()
        || !argument.get_possible_values().is_empty()
        || numbers.iter().any(|number| kind == *number)
}

/// Makes a built-in plugin for a run in one process.
///
/// # Errors
/// If no built-in plugin has this name, if it can't run there, or if an argument is invalid.
pub fn make(name: &str, args: &[String]) -> Result<Box<dyn Plugin>, Failure> {
    let plugin = PLUGINS.iter().find(|plugin| plugin.name == name).ok_or_else(|| unknown(name))?;
    let Some(make) = plugin.make else {
        return Err(format!(
            "plugin '{name}' serves other processes, and has no place in a run in one process; \
             leave it out, or run without --in-process"
        )
        .into());
    };
    make(std::iter::once(name.to_owned()).chain(args.iter().cloned()).collect())
        .map_err(|error| format!("plugin '{name}': {error}").into())
}

/// Returns the error message for a name that no built-in plugin has.
pub fn unknown(name: &str) -> String {
    let suggestion = closest(name, PLUGINS.iter().map(|plugin| plugin.name));
    let suggestion = suggestion.map(|name| format!("; did you mean '{name}'?")).unwrap_or_default();
    format!("unknown plugin '{name}'{suggestion}; the built-in plugins are: {}", names())
}

fn names() -> String {
    PLUGINS.iter().map(|plugin| plugin.name).collect::<Vec<_>>().join(", ")
}

/// Turns `regatta plugin` into a command with a subcommand per plugin, as completions and man pages
/// show it. (To parse a command line, everything after the name goes to the plugin as it is.)
pub fn with_subcommands(command: Command) -> Command {
    let subcommands = PLUGINS.iter().map(|plugin| {
        (plugin.add_options)(Command::new(plugin.name)).name(plugin.name).about(plugin.about)
    });
    // A command's arguments can't be removed; only `about` is worth keeping.
    let about = command.get_about().cloned().unwrap_or_default();
    Command::new("plugin").about(about).subcommands(subcommands)
}

/// Runs `regatta plugin`.
pub fn run(args: PluginArgs) -> Result<(), Failure> {
    let Some(name) = args.name_and_args.first() else {
        return Err(format!(
            "the name of the plugin is missing; the built-in plugins are: {}",
            names()
        )
        .into());
    };
    if ["-h", "--help"].contains(&name.as_str()) {
        println!("Run one of the built-in plugins, in this process\n");
        println!("Usage: regatta plugin NAME [OPTIONS]\n\nPlugins:");
        for BuiltIn { name, about, .. } in PLUGINS {
            println!("  {name:<13}  {about}");
        }
        println!("\nFor a plugin's options: regatta plugin NAME --help");
        return Ok(());
    }
    let plugin = PLUGINS.iter().find(|plugin| plugin.name == name).ok_or_else(|| unknown(name))?;
    // The help begins with the name of the program.
    let program = format!("regatta plugin {name}");
    let args = std::iter::once(program).chain(args.name_and_args.iter().skip(1).cloned());
    (plugin.run)(args.collect()).map_err(plugin_failure)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(name: &str, args: &[&str]) -> bool {
        let args: Vec<String> = args.iter().map(|arg| (*arg).to_owned()).collect();
        reaches_out(name, &args)
    }

    #[test]
    fn arguments_with_files_and_addresses_reach_out_and_numbers_do_not() {
        for (name, args) in [
            ("fleet-manager", &["--planner", "pibt", "--in-turn", "--summary"][..]),
            ("collision", &["--margin", "0.3", "--rate", "10"]),
            ("traffic", &[]),
            ("nobody", &["x"]),
        ] {
            assert!(!of(name, args), "{name} {args:?}");
        }
        for (name, args) in [
            ("fleet-manager", &["--json", "x.json"][..]),
            ("fleet-manager", &["--http"]),
            ("fleet-manager", &["--no-such-option"]),
            ("metrics", &["--csv=x.csv"]),
            ("record", &["-o", "x.mcap"]),
            ("foxglove", &[]),
            #[cfg(feature = "ros2")]
            ("ros2", &[]),
            ("traffic", &["--summary", "--parquet", "x"]),
            ("udp", &["--to", "192.0.2.1:9001"]),
            ("udp-source", &["--listen", "0.0.0.0:9001"]),
            ("validator", &["--markdown", "x.md"]),
            ("vda5050", &["--broker", "mqtt://192.0.2.1"]),
        ] {
            assert!(of(name, args), "{name} {args:?}");
        }
    }
}
