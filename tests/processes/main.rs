//! Tests with whole processes: the real binary, real shared memory, real signals. Each test has its
//! own fleet name, so that all of them can run in parallel.

#[cfg(feature = "viewer")]
mod alarms;
mod closures;
mod collision;
mod command;
mod command_line;
mod control;
mod determinism;
mod ending;
mod facilities;
mod fleet;
mod fleet_manager;
mod fleets;
mod foxglove;
mod graph_command;
mod help_texts;
mod hostile;
mod in_process;
mod lockstep;
mod messages;
mod metrics;
mod orders;
mod orders_check;
mod producers;
mod readers;
mod record;
mod replay;
mod report;
mod robot_types;
#[cfg(feature = "ros2")]
mod ros2;
mod routes;
mod shared_memory;
mod strangers;
mod study;
mod study_faults;
mod study_master;
mod study_simpy;
mod study_stations;
mod study_targets;
mod study_theory;
mod study_twice;
mod terminal;
mod texts;
mod top;
mod traffic;
mod trust;
mod udp;
mod validator;
mod vda5050;
mod vda5050_check;
mod warm_up;
