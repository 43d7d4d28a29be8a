//! Lists of topics on a command line.

use std::str::FromStr;

use regatta_plugin::ColumnName;

use crate::schema::Topic;

/// A set of topics: `frames,events,columns` contains frames, events and all columns.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TopicSet {
    /// `None` for all topics.
    names: Option<Vec<String>>,
}

/// The names that a command line can have, besides those of columns.
const NAMES: [&str; 10] = [
    "frames",
    "events",
    "orders",
    "tasks",
    "contacts",
    "contact_events",
    "columns",
    "poses",
    "robots",
    "graph",
];

impl TopicSet {
    /// Returns the set of all topics.
    pub fn all() -> Self {
        Self { names: None }
    }

    /// Whether a topic is in the set. The world always is: nothing can be read without it.
    pub fn includes(&self, topic: &Topic) -> bool {
        let Some(names) = &self.names else { return true };
        let has = |name: &str| names.iter().any(|given| given == name);
        match topic {
            Topic::World => true,
            Topic::Frames => has("frames"),
            Topic::Events => has("events"),
            Topic::Orders => has("orders"),
            Topic::Tasks => has("tasks"),
            Topic::Contacts | Topic::ContactUpdates => has("contacts"),
            Topic::ContactEvents => has("contact_events"),
            Topic::Column(name) => has("columns") || has(&format!("columns/{name}")),
            Topic::Poses => has("poses"),
            Topic::Robots => has("robots"),
            Topic::Graph | Topic::GraphPoints => has("graph"),
        }
    }
}

impl FromStr for TopicSet {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let names: Vec<_> =
            text.split(',').map(|name| name.trim().trim_start_matches('/').to_owned()).collect();
        let is_column = |name: &str| {
            name.strip_prefix("columns/").is_some_and(|name| name.parse::<ColumnName>().is_ok())
        };
        match names.iter().find(|name| !NAMES.contains(&name.as_str()) && !is_column(name)) {
            None => Ok(Self { names: Some(names) }),
            Some(unknown) => Err(format!(
                "unknown topic '{unknown}'; the topics are {}, and columns/NAME",
                NAMES.join(", ")
            )),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_set_has_the_listed_topics_and_the_world() {
        let set: TopicSet = "frames, /contacts,columns/load".parse().unwrap();
        let has = |name: &str| set.includes(&Topic::from_name(name).unwrap());
        for name in ["/frames", "/contacts", "/contact_updates", "/columns/load", "/world"] {
            assert!(has(name), "{name}");
        }
        for name in [
            "/events",
            "/orders",
            "/contact_events",
            "/columns/type",
            "/poses",
            "/robots",
            "/graph_points",
        ] {
            assert!(!has(name), "{name}");
        }
        assert!(
            "columns"
                .parse::<TopicSet>()
                .unwrap()
                .includes(&Topic::Column("type".parse().unwrap()))
        );
        assert!(Topic::FIXED.iter().all(|topic| TopicSet::all().includes(topic)));
    }

    #[test]
    fn unknown_topics_are_refused() {
        for bad in ["", "frame", "frames,", "columns/", "columns/a b", "world"] {
            let error = bad.parse::<TopicSet>().unwrap_err();
            assert!(error.contains("the topics are frames, events"), "{error}");
        }
    }
}
