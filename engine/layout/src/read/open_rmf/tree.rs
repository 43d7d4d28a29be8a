//! A YAML text as a tree, with the byte offsets of its keys and of the first values of its tuples.
//!
//! The YAML library gives no positions, but returns plain text as slices of the file. Maps start
//! with a key, which is text. Vertices, lanes and walls are tuples of numbers: their first value is
//! read as text too, so that messages name its line.

use std::borrow::Cow;
use std::fmt;

use serde::de::{DeserializeSeed, Deserializer, Error, MapAccess, SeqAccess, Visitor};

use crate::model::value::{ReadValue, Scalar, Value, impl_deserialize_seed, shorten};
use crate::read::file::{MAX_ENTRIES, SyntaxError};

/// The keys whose values are lists of tuples.
const TUPLES: [&str; 7] =
    ["vertices", "lanes", "walls", "doors", "measurements", "fiducials", "human_lanes"];

/// A value with its place.
#[derive(Debug)]
pub(super) struct Tree<'text> {
    /// The byte offset of the value, or of a key shortly before it.
    pub at: u32,
    /// The byte offset of its key, for a value of a map.
    pub key_at: u32,
    pub content: Content<'text>,
}

#[derive(Debug)]
pub(super) enum Content<'text> {
    Scalar(Value<'text>),
    List(Vec<Tree<'text>>),
    Map(Vec<(String, Tree<'text>)>),
}

impl<'text> Tree<'text> {
    /// Parses a text that must be one map.
    pub fn parse(text: &'text str) -> Result<Self, SyntaxError> {
        let mut reader = Reader { text, at: 0, entries: 0 };
        let mut root = Tree::null(0);
        let seed = Seed { reader: &mut reader, tree: &mut root, mode: Mode::Any };
        let result = seed.deserialize(serde_yaml::Deserializer::from_str(text));
        let value = result.map_err(|error| SyntaxError {
            line: error.location().map_or(1, |location| location.line()),
            message: error.to_string(),
        })?;
        match root.content {
            Content::Map(_) => Ok(root),
            _ => Err(SyntaxError {
                line: 1,
                message: format!("expected a map with `levels`, found {}", value.describe()),
            }),
        }
    }

    fn null(at: u32) -> Self {
        Self { at, key_at: at, content: Content::Scalar(Value::Null) }
    }

    /// Returns the entries of a map; none if it is something else.
    pub fn entries(&self) -> &[(String, Tree<'text>)] {
        match &self.content {
            Content::Map(entries) => entries,
            _ => &[],
        }
    }

    /// Returns the items of a list; none if it is something else.
    pub fn items(&self) -> &[Tree<'text>] {
        match &self.content {
            Content::List(items) => items,
            _ => &[],
        }
    }

    /// Returns the first value of a key of a map.
    pub fn get(&self, key: &str) -> Option<&Tree<'text>> {
        self.entries().iter().find(|(name, _)| name == key).map(|(_, value)| value)
    }

    /// Returns a finite number, also if it is written as text.
    pub fn number(&self) -> Option<f64> {
        match &self.content {
            Content::Scalar(value) => value.number().filter(|number| number.is_finite()),
            _ => None,
        }
    }

    /// Returns the finite number of a key of a map.
    pub fn number_of(&self, key: &str) -> Option<f64> {
        self.get(key)?.number()
    }

    /// Returns a whole number from 0 that is an index.
    pub fn index(&self) -> Option<usize> {
        let number = self.number()?;
        (number >= 0.0 && number <= f64::from(u32::MAX) && number.fract() == 0.0)
            .then_some(number as usize)
    }

    /// Returns a text, number or truth value as text.
    pub fn text(&self) -> Option<String> {
        match &self.content {
            Content::Scalar(value) => value.text(),
            _ => None,
        }
    }

    /// Returns a description for messages.
    pub fn describe(&self) -> Cow<'static, str> {
        match &self.content {
            Content::Scalar(value) => value.describe(),
            Content::List(_) => "a list".into(),
            Content::Map(_) => "a map".into(),
        }
    }

    /// Whether there is nothing in it: no value, or only empty texts, lists and maps.
    pub fn is_empty(&self) -> bool {
        match &self.content {
            Content::Scalar(Value::Null) => true,
            Content::Scalar(value) => value.text().is_some_and(|text| text.is_empty()),
            Content::List(items) => items.iter().all(Tree::is_empty),
            Content::Map(entries) => entries.iter().all(|(_, value)| value.is_empty()),
        }
    }

    /// Whether there is no value.
    pub fn is_null(&self) -> bool {
        matches!(self.content, Content::Scalar(Value::Null))
    }
}

/// What the position in the file says about a value.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Mode {
    Any,
    /// A list of tuples.
    Tuples,
    Tuple,
    /// The first value of a tuple.
    First,
}

struct Reader<'text> {
    text: &'text str,
    /// The byte offset of the last text whose position is known.
    at: u32,
    /// The number of keys and items so far, those repeated by aliases included.
    entries: usize,
}

impl<'text> Reader<'text> {
    fn locate(&mut self, value: &Value<'text>) {
        // Aliases may repeat a long text many times: it counts as several entries.
        if let Value::Text(text) = value {
            self.entries += text.len() / 32;
        }
        let Value::Text(Cow::Borrowed(slice)) = value else { return };
        let offset = slice.as_ptr().addr().wrapping_sub(self.text.as_ptr().addr());
        if offset < self.text.len() {
            self.at = offset as u32;
        }
    }

    fn count<E: Error>(&mut self) -> Result<(), E> {
        self.entries += 1;
        if self.entries > MAX_ENTRIES {
            return Err(E::custom(format!(
                "more than {MAX_ENTRIES} entries, aliases included: split the map"
            )));
        }
        Ok(())
    }
}

/// The reader of one value into `tree`.
struct Seed<'a, 'text> {
    reader: &'a mut Reader<'text>,
    tree: &'a mut Tree<'text>,
    mode: Mode,
}

impl<'text> DeserializeSeed<'text> for Seed<'_, 'text> {
    type Value = Value<'text>;

    fn deserialize<D: Deserializer<'text>>(self, deserializer: D) -> Result<Self::Value, D::Error> {
        let Self { reader, tree, mode } = self;
        let value = if mode == Mode::First {
            deserializer.deserialize_str(FirstOfTuple)?
        } else {
            Nested { reader: &mut *reader, tree: &mut *tree, mode }.deserialize(deserializer)?
        };
        if value != Value::Read {
            reader.locate(&value);
            (tree.at, tree.content) = (reader.at, Content::Scalar(value.clone()));
        }
        Ok(value)
    }
}

struct Nested<'a, 'text> {
    reader: &'a mut Reader<'text>,
    tree: &'a mut Tree<'text>,
    mode: Mode,
}

impl_deserialize_seed!(Nested<'_, 'text>);

impl<'text> ReadValue<'text> for Nested<'_, 'text> {
    fn map<A: MapAccess<'text>>(self, mut map: A) -> Result<Value<'text>, A::Error> {
        let Self { reader, tree, .. } = self;
        let mut entries = Vec::new();
        tree.at = reader.at;
        while let Some(key) = map.next_key_seed(Scalar)? {
            reader.count()?;
            reader.locate(&key);
            if entries.is_empty() {
                tree.at = reader.at;
            }
            let name = key.text().unwrap_or_else(|| shorten(&key.describe()));
            let mode = if TUPLES.contains(&name.as_str()) { Mode::Tuples } else { Mode::Any };
            let mut value = Tree::null(reader.at);
            map.next_value_seed(Seed { reader: &mut *reader, tree: &mut value, mode })?;
            entries.push((name, value));
        }
        tree.content = Content::Map(entries);
        Ok(Value::Read)
    }

    fn list<A: SeqAccess<'text>>(self, mut list: A) -> Result<Value<'text>, A::Error> {
        let Self { reader, tree, mode } = self;
        let mut items = Vec::new();
        tree.at = reader.at;
        loop {
            let mode = match mode {
                Mode::Tuples => Mode::Tuple,
                Mode::Tuple if items.is_empty() => Mode::First,
                _ => Mode::Any,
            };
            let mut item = Tree::null(reader.at);
            if list
                .next_element_seed(Seed { reader: &mut *reader, tree: &mut item, mode })?
                .is_none()
            {
                break;
            }
            reader.count()?;
            if items.is_empty() {
                tree.at = item.at;
            }
            items.push(item);
        }
        tree.content = Content::List(items);
        Ok(Value::Read)
    }
}

struct FirstOfTuple;

impl<'text> Visitor<'text> for FirstOfTuple {
    type Value = Value<'text>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a number")
    }

    fn visit_borrowed_str<E>(self, value: &'text str) -> Result<Self::Value, E> {
        Ok(Value::Text(Cow::Borrowed(value)))
    }

    fn visit_str<E>(self, value: &str) -> Result<Self::Value, E> {
        Ok(Value::Text(Cow::Owned(value.to_owned())))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tuples_know_their_lines() {
        let text = "levels:\n  L1:\n    vertices:\n    - - 1.5\n      - -2\n      - {name: a}\n    - [3, 4, {}]\n";
        let root = Tree::parse(text).expect("yaml");
        let vertices = root
            .get("levels")
            .and_then(|levels| levels.get("L1"))
            .and_then(|level| level.get("vertices"));
        let vertices = vertices.expect("vertices").items();
        let line = |at: u32| text[..at as usize].lines().count();
        assert_eq!(vertices.iter().map(|vertex| line(vertex.at)).collect::<Vec<_>>(), [4, 7]);
        assert_eq!(vertices[0].items()[0].number(), Some(1.5));
        assert_eq!(vertices[0].items()[1].number(), Some(-2.0));
        assert_eq!(vertices[0].items()[2].get("name").and_then(Tree::text).as_deref(), Some("a"));
    }

    #[test]
    fn what_is_no_map_is_refused() {
        for text in ["- 1", "text", "a: [", "{a: &x [1], b: *y}", "vertices: [[[1]]]", ": :"] {
            assert!(Tree::parse(text).is_err(), "{text}");
        }
    }
}
