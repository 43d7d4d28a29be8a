//! A YAML text as a tree with lenient conversions.

use std::borrow::Cow;

use regatta_base::yaml::{self, Node};

use crate::model::value::{Value, shorten};
use crate::read::file::SyntaxError;

/// A value with its place.
#[derive(Debug)]
pub(super) struct Tree<'text> {
    /// The byte offset of the value, or of its key if there is no value.
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
        let root = Self::from(yaml::parse(text)?);
        match root.content {
            Content::Map(_) => Ok(root),
            _ => {
                let message = format!("expected a map with `levels`, found {}", root.describe());
                Err(SyntaxError::new(1, message))
            }
        }
    }

    /// Returns the entries of a map; empty for other values.
    pub fn entries(&self) -> &[(String, Tree<'text>)] {
        match &self.content {
            Content::Map(entries) => entries,
            _ => &[],
        }
    }

    /// Returns the items of a list; empty for other values.
    pub fn items(&self) -> &[Tree<'text>] {
        match &self.content {
            Content::List(items) => items,
            _ => &[],
        }
    }

    /// Returns the items of the list at a key of a map; empty if there is no such list.
    pub fn items_of(&self, key: &str) -> &[Tree<'text>] {
        self.get(key).map(Tree::items).unwrap_or_default()
    }

    /// Returns the entries of the map at a key of a map; empty if there is no such map.
    pub fn entries_of(&self, key: &str) -> &[(String, Tree<'text>)] {
        self.get(key).map(Tree::entries).unwrap_or_default()
    }

    /// Returns the text at a key of a map.
    pub fn text_of(&self, key: &str) -> Option<String> {
        self.get(key)?.text()
    }

    /// Returns the first value at a key of a map.
    pub fn get(&self, key: &str) -> Option<&Tree<'text>> {
        self.entries().iter().find(|(name, _)| name == key).map(|(_, value)| value)
    }

    /// Returns a finite number, even if it is written as text.
    pub fn number(&self) -> Option<f64> {
        match &self.content {
            Content::Scalar(value) => value.number().filter(|number| number.is_finite()),
            _ => None,
        }
    }

    /// Returns the finite number at a key of a map.
    pub fn number_of(&self, key: &str) -> Option<f64> {
        self.get(key)?.number()
    }

    /// Returns an index: a whole number from 0.
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

    /// Whether the value is empty: null, or only empty texts, lists and maps.
    pub fn is_empty(&self) -> bool {
        match &self.content {
            Content::Scalar(Value::Null) => true,
            Content::Scalar(value) => value.text().is_some_and(|text| text.is_empty()),
            Content::List(items) => items.iter().all(Tree::is_empty),
            Content::Map(entries) => entries.iter().all(|(_, value)| value.is_empty()),
        }
    }

    /// Whether the value is null.
    pub fn is_null(&self) -> bool {
        matches!(self.content, Content::Scalar(Value::Null))
    }
}

impl<'text> From<Node<'text>> for Tree<'text> {
    fn from(node: Node<'text>) -> Self {
        let at = node.offset as u32;
        let content = match node.content {
            yaml::Content::List(items) => {
                Content::List(items.into_iter().map(Self::from).collect())
            }
            yaml::Content::Map(pairs) => Content::Map(pairs.into_iter().map(entry).collect()),
            scalar => Content::Scalar(scalar.into()),
        };
        Self { at, key_at: at, content }
    }
}

fn entry<'text>((key, value): (Node<'text>, Node<'text>)) -> (String, Tree<'text>) {
    let key_at = key.offset as u32;
    let name = Value::from(key.content);
    let name = name.text().unwrap_or_else(|| shorten(&name.describe()));
    let tree = Tree::from(value);
    let at = if tree.is_null() { key_at } else { tree.at };
    (name, Tree { at, key_at, ..tree })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tuples_know_their_lines() {
        let text = concat!(
            "levels:\n  L1:\n    vertices:\n",
            "    - - 1.5\n      - -2\n      - {name: a}\n",
            "    - [3, 4, {}]\n",
        );
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
        for text in ["- 1", "text", "a: [", "{a: &x [1], b: *y}"] {
            assert!(Tree::parse(text).is_err(), "{text}");
        }
    }
}
