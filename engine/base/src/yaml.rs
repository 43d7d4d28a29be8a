//! YAML with the place of every value, for errors that name the line.
//!
//! [`parse`] reads a text as a tree of [`Node`]s. Each node knows its line and its byte offset, and
//! reports problems with them:
//!
//! ```
//! use regatta_base::yaml;
//!
//! let text = "pick: dock 1\nweight: heavy\n";
//! let root = yaml::parse(text)?;
//! let fields = root.fields(&["pick", "drop", "weight"])?;
//! assert_eq!(fields.required("pick")?.text()?, "dock 1");
//! assert!(fields.get("drop").is_none());
//!
//! let error = fields.required("weight")?.number().unwrap_err();
//! assert_eq!(error.to_string(), "line 2: expected a number");
//! # Ok::<(), yaml::Error>(())
//! ```
//!
//! Scalars are resolved by the core schema of YAML 1.2, except that digits with leading zeros are a
//! text: they are names, such as `007`. Aliases are expanded; a text that grows to more than
//! [`MAX_ENTRIES`] entries, or is nested more than [`MAX_DEPTH`] deep, is an error.

mod limits;

use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};

use saphyr_parser::{Event, Parser, ScalarStyle, Span, Tag};

pub use self::limits::check_limits;

/// The largest number of keys and items of a text, those of expanded aliases included. It protects
/// against alias bombs.
pub const MAX_ENTRIES: usize = 3_000_000;

/// The largest depth of nested lists and maps.
pub const MAX_DEPTH: usize = 100;

/// The error of reading a YAML text: its line, and the reason.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("line {line}: {reason}")]
pub struct Error {
    /// The line, from 1.
    pub line: usize,
    /// The problem and what to do about it.
    pub reason: String,
}

/// A value of a YAML text, with its place.
#[derive(Clone, Debug, PartialEq)]
pub struct Node<'text> {
    /// The line where the value begins, from 1.
    pub line: usize,
    /// The byte offset in the text where the value begins.
    pub offset: usize,
    /// The value.
    pub content: Content<'text>,
}

/// The content of a [`Node`].
#[derive(Clone, Debug, PartialEq)]
pub enum Content<'text> {
    /// `null`, `~` or no value at all.
    Null,
    /// `true` or `false`.
    Bool(bool),
    /// An integer: decimal, `0x` or `0o`.
    Integer(i64),
    /// Any other number that an `f64` can hold, also `.inf` and `.nan`.
    Float(f64),
    /// A quoted text, or a plain one that is none of the above.
    Text(Cow<'text, str>),
    /// A value with a tag of an application, such as `!degrees 90`.
    Tagged,
    /// A list.
    List(Vec<Node<'text>>),
    /// The keys and values of a map, in the order of the text. Keys may be repeated.
    Map(Vec<(Node<'text>, Node<'text>)>),
}

/// Returns the error of a tab in the indentation of a line, or of the one before it.
fn tab_before(text: &str, line: usize) -> Option<Error> {
    let lines = (1..).zip(text.lines()).skip(line.saturating_sub(2)).take(2);
    let mut with_tab = lines.filter(|(_, content)| {
        let indentation = content.len() - content.trim_start_matches([' ', '\t']).len();
        content[..indentation].contains('\t')
    });
    let (line, _) = with_tab.next()?;
    let reason = "the line begins with a tab, and YAML is indented with spaces only: replace tabs \
                  by spaces";
    Some(Error { line, reason: reason.to_owned() })
}

/// Parses the one document of a text. An empty text is [`Content::Null`].
///
/// # Errors
/// If the text isn't YAML, has several documents, or exceeds a limit.
pub fn parse(text: &str) -> Result<Node<'_>, Error> {
    if let Some(at) = text.bytes().position(is_control) {
        let line = 1 + text.bytes().take(at).filter(|byte| *byte == b'\n').count();
        return Err(Error { line, reason: "control characters are not allowed".to_owned() });
    }
    check_limits(text)?;
    let mut builder = Builder::new(text);
    for event in Parser::new_from_str(text) {
        let (event, span) = event.map_err(|error| {
            let (line, reason) = (error.marker().line(), error.info().to_owned());
            tab_before(text, line).unwrap_or(Error { line, reason })
        })?;
        builder.take(event, span)?;
    }
    match (builder.documents, builder.root) {
        (0 | 1, root) => Ok(root.unwrap_or(Node { line: 1, offset: 0, content: Content::Null })),
        (documents, _) => Err(Error {
            line: 1,
            reason: format!("more than one document: keep one of the {documents} documents"),
        }),
    }
}

impl<'text> Node<'text> {
    /// Returns the error that something is wrong with this value.
    pub fn error(&self, reason: impl Into<String>) -> Error {
        Error { line: self.line, reason: reason.into() }
    }

    /// Whether it is a map.
    pub fn is_map(&self) -> bool {
        matches!(self.content, Content::Map(_))
    }

    /// Returns the text of a scalar: of an integer, too, because names may look like numbers.
    ///
    /// # Errors
    /// If it is another value.
    pub fn text(&self) -> Result<Cow<'text, str>, Error> {
        match &self.content {
            Content::Text(text) => Ok(text.clone()),
            Content::Integer(number) => Ok(number.to_string().into()),
            _ => Err(self.error("expected a text")),
        }
    }

    /// Returns a finite number.
    ///
    /// # Errors
    /// If it is another value.
    pub fn number(&self) -> Result<f64, Error> {
        match self.content {
            Content::Integer(number) => Ok(number as f64),
            Content::Float(number) if number.is_finite() => Ok(number),
            _ => Err(self.error("expected a number")),
        }
    }

    /// Returns a finite number that is at least 0.
    ///
    /// # Errors
    /// If it is another value.
    pub fn non_negative(&self) -> Result<f64, Error> {
        match self.number()? {
            number if number >= 0.0 => Ok(number),
            number => Err(self.error(format!("{number} is below 0"))),
        }
    }

    /// Returns an integer from 0 to `max`.
    ///
    /// # Errors
    /// If it is another value.
    pub fn integer(&self, max: u64) -> Result<u64, Error> {
        if let Content::Integer(number) = self.content
            && let Ok(number) = u64::try_from(number)
            && number <= max
        {
            return Ok(number);
        }
        Err(self.error(format!("expected an integer from 0 to {max}")))
    }

    /// Returns the items of a list.
    ///
    /// # Errors
    /// If it is another value.
    pub fn list(&self) -> Result<&[Self], Error> {
        match &self.content {
            Content::List(items) => Ok(items),
            _ => Err(self.error("expected a list")),
        }
    }

    /// Returns the pairs of a map with texts as keys.
    ///
    /// # Errors
    /// If it is another value, or a key is no text.
    pub fn pairs(&self) -> Result<Vec<(Cow<'text, str>, &Self)>, Error> {
        let Content::Map(pairs) = &self.content else {
            return Err(self.error("expected `key: value` pairs"));
        };
        pairs.iter().map(|(key, value)| Ok((key.text()?, value))).collect()
    }

    /// Returns the fields of a map that has no other keys than these, and none of them twice.
    ///
    /// # Errors
    /// If it is another value, or has another key.
    pub fn fields(&self, names: &[&str]) -> Result<Fields<'_, 'text>, Error> {
        let fields = self.all_fields()?;
        for (key, value) in &fields.pairs {
            if !names.contains(&key.as_ref()) {
                let names = names.join(", ");
                return Err(value.error(format!("unknown field `{key}`; there are {names}")));
            }
        }
        Ok(fields)
    }

    /// Returns the fields of a map with any keys, none of them twice.
    ///
    /// # Errors
    /// If it is another value.
    pub fn all_fields(&self) -> Result<Fields<'_, 'text>, Error> {
        let pairs = self.pairs()?;
        let mut keys = BTreeSet::new();
        for (key, value) in &pairs {
            if !keys.insert(key) {
                return Err(value.error(format!("`{key}` is given twice; remove one")));
            }
        }
        Ok(Fields { map: self, pairs })
    }
}

/// The fields of a map.
#[derive(Debug)]
pub struct Fields<'node, 'text> {
    map: &'node Node<'text>,
    pairs: Vec<(Cow<'text, str>, &'node Node<'text>)>,
}

impl<'node, 'text> Fields<'node, 'text> {
    /// Returns the keys with their values, in the order of the text.
    pub fn pairs(&self) -> &[(Cow<'text, str>, &'node Node<'text>)] {
        &self.pairs
    }

    /// Returns a field if it is there.
    pub fn get(&self, name: &str) -> Option<&'node Node<'text>> {
        self.pairs.iter().find(|(key, _)| key == name).map(|(_, value)| *value)
    }

    /// Returns a field that has to be there.
    ///
    /// # Errors
    /// If it is missing.
    pub fn required(&self, name: &str) -> Result<&'node Node<'text>, Error> {
        self.get(name).ok_or_else(|| self.map.error(format!("`{name}` is missing")))
    }

    /// Reads a field if it is there.
    ///
    /// # Errors
    /// Those of `read`.
    pub fn optional<T>(
        &self,
        name: &str,
        read: impl FnOnce(&'node Node<'text>) -> Result<T, Error>,
    ) -> Result<Option<T>, Error> {
        self.get(name).map(read).transpose()
    }
}

/// Builds the tree of a document from the events of the parser.
struct Builder<'text> {
    position: Position<'text>,
    documents: usize,
    root: Option<Node<'text>>,
    /// The lists and maps that aren't complete, outermost first.
    open: Vec<Open<'text>>,
    /// The values of anchors, by their number.
    anchors: BTreeMap<usize, Node<'text>>,
    entries: usize,
}

/// A list or a map that isn't complete.
struct Open<'text> {
    node: Node<'text>,
    /// The key whose value comes next.
    key: Option<Node<'text>>,
    anchor: usize,
    is_tagged: bool,
}

impl<'text> Builder<'text> {
    fn new(text: &'text str) -> Self {
        Self {
            position: Position { text, line: 1, column: 0, offset: 0 },
            documents: 0,
            root: None,
            open: Vec::new(),
            anchors: BTreeMap::new(),
            entries: 0,
        }
    }

    fn take(&mut self, event: Event<'text>, span: Span) -> Result<(), Error> {
        let (line, column) = (span.start.line(), span.start.col());
        match event {
            Event::DocumentStart(_) => self.documents += 1,
            Event::Scalar(text, style, anchor, tag) => {
                let content = scalar(text, style, tag.as_deref());
                let offset = self.position.offset(line, column);
                self.add(Node { line, offset, content }, anchor)?;
            }
            Event::SequenceStart(anchor, tag) => {
                let content = Content::List(Vec::new());
                let offset = self.position.offset(line, column);
                self.begin(Node { line, offset, content }, anchor, tag.as_deref())?;
            }
            Event::MappingStart(anchor, tag) => {
                let content = Content::Map(Vec::new());
                let offset = self.position.offset(line, column);
                self.begin(Node { line, offset, content }, anchor, tag.as_deref())?;
            }
            Event::SequenceEnd | Event::MappingEnd => {
                if let Some(Open { mut node, anchor, is_tagged, .. }) = self.open.pop() {
                    if is_tagged {
                        node.content = Content::Tagged;
                    }
                    self.add(node, anchor)?;
                }
            }
            Event::Alias(anchor) => {
                let Some(value) = self.anchors.get(&anchor) else {
                    let reason = "an alias is inside its own anchor; write the value out";
                    return Err(Error { line, reason: reason.to_owned() });
                };
                let (entries, value) = (entries(value), value.clone());
                self.count(entries, line)?;
                self.add(value, 0)?;
            }
            Event::Nothing | Event::StreamStart | Event::StreamEnd | Event::DocumentEnd => {}
        }
        Ok(())
    }

    fn begin(&mut self, node: Node<'text>, anchor: usize, tag: Option<&Tag>) -> Result<(), Error> {
        if self.open.len() >= MAX_DEPTH {
            return Err(node.error(format!("more than {MAX_DEPTH} nested lists and maps")));
        }
        self.open.push(Open { node, key: None, anchor, is_tagged: tag.is_some_and(is_foreign) });
        Ok(())
    }

    /// Adds a complete value to the innermost open list or map.
    fn add(&mut self, node: Node<'text>, anchor: usize) -> Result<(), Error> {
        if anchor > 0 {
            self.count(entries(&node), node.line)?;
            self.anchors.insert(anchor, node.clone());
        }
        let is_map_value = self.open.last().is_some_and(|parent| parent.key.is_some());
        self.count(usize::from(!is_map_value), node.line)?;
        let Some(Open { node: parent, key, .. }) = self.open.last_mut() else {
            self.root.get_or_insert(node);
            return Ok(());
        };
        match &mut parent.content {
            Content::List(items) => items.push(node),
            Content::Map(pairs) => match key.take() {
                Some(key) => pairs.push((key, node)),
                None => *key = Some(node),
            },
            _ => {}
        }
        Ok(())
    }

    fn count(&mut self, entries: usize, line: usize) -> Result<(), Error> {
        self.entries += entries;
        if self.entries > MAX_ENTRIES {
            let reason =
                format!("more than {MAX_ENTRIES} entries, aliases included: split the file");
            return Err(Error { line, reason });
        }
        Ok(())
    }
}

/// Returns the number of keys and items in a tree, where a long text counts as several.
fn entries(node: &Node<'_>) -> usize {
    match &node.content {
        Content::List(items) => items.iter().map(|item| 1 + entries(item)).sum(),
        Content::Map(pairs) => {
            pairs.iter().map(|(key, value)| 1 + entries(key) + entries(value)).sum()
        }
        Content::Text(text) => text.len() / 32,
        _ => 0,
    }
}

/// Whether a byte is a character that YAML doesn't allow.
fn is_control(byte: u8) -> bool {
    byte.is_ascii_control() && !b"\t\n\r".contains(&byte)
}

/// Whether a tag is none of YAML itself.
fn is_foreign(tag: &Tag) -> bool {
    !tag.is_yaml_core_schema()
}

/// Resolves a scalar by the core schema.
fn scalar<'text>(text: Cow<'text, str>, style: ScalarStyle, tag: Option<&Tag>) -> Content<'text> {
    if tag.is_some_and(is_foreign) {
        return Content::Tagged;
    }
    let is_text = tag.is_some_and(|tag| tag.suffix == "str");
    if style != ScalarStyle::Plain || is_text {
        return Content::Text(text);
    }
    match text.as_ref() {
        "" | "~" | "null" | "Null" | "NULL" => return Content::Null,
        "true" | "True" | "TRUE" => return Content::Bool(true),
        "false" | "False" | "FALSE" => return Content::Bool(false),
        ".inf" | ".Inf" | ".INF" | "+.inf" | "+.Inf" | "+.INF" => {
            return Content::Float(f64::INFINITY);
        }
        "-.inf" | "-.Inf" | "-.INF" => return Content::Float(f64::NEG_INFINITY),
        ".nan" | ".NaN" | ".NAN" => return Content::Float(f64::NAN),
        _ => {}
    }
    let digits = text.trim_start_matches(['+', '-']);
    if digits.len() > 1
        && digits.starts_with('0')
        && digits.bytes().all(|byte| byte.is_ascii_digit())
    {
        return Content::Text(text);
    }
    let integer = match text.as_bytes() {
        [b'0', b'x', ..] => i64::from_str_radix(&text[2..], 16),
        [b'0', b'o', ..] => i64::from_str_radix(&text[2..], 8),
        _ => text.parse(),
    };
    if let Ok(integer) = integer {
        return Content::Integer(integer);
    }
    // Without a digit it is a word, such as `inf`, which Rust reads as a number.
    if text.bytes().any(|byte| byte.is_ascii_digit())
        && let Ok(number) = text.parse::<f64>()
        && number.is_finite()
    {
        return Content::Float(number);
    }
    Content::Text(text)
}

/// A place of the text. Places are looked up in ascending order, so that all of them together take
/// one pass.
struct Position<'text> {
    text: &'text str,
    /// From 1.
    line: usize,
    /// Characters from the start of the line.
    column: usize,
    /// Bytes.
    offset: usize,
}

impl Position<'_> {
    /// Returns the byte offset of a place.
    fn offset(&mut self, line: usize, column: usize) -> usize {
        if (line, column) < (self.line, self.column) {
            (self.line, self.column, self.offset) = (1, 0, 0);
        }
        let mut rest = self.text[self.offset..].chars().peekable();
        while (self.line, self.column) < (line, column) {
            let Some(character) = rest.next() else { break };
            self.offset += character.len_utf8();
            let ends_line = character == '\n' || (character == '\r' && rest.peek() != Some(&'\n'));
            if ends_line {
                (self.line, self.column) = (self.line + 1, 0);
            } else {
                self.column += 1;
            }
        }
        self.offset
    }
}

#[cfg(test)]
mod tests;
