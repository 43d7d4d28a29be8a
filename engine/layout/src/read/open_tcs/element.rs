//! The elements of an XML text, with their places.

use glam::DVec2;
use quick_xml::XmlVersion;
use quick_xml::events::{BytesStart, Event};
use quick_xml::reader::Reader;

use crate::model::value::shorten;
use crate::read::file::{Ignored, MAX_ENTRIES, SyntaxError, line_at, offset_of};

/// The largest depth of nested elements; plant models have 4.
const MAX_DEPTH: usize = 32;

/// The largest number of attributes of an element; those of plant models have at most 10.
const MAX_ATTRIBUTES: usize = 64;

/// An element. Readers take out the parts that they understand.
#[derive(Debug)]
pub(super) struct Element<'text> {
    /// The byte offset of its name.
    pub at: u32,
    /// The name without prefix.
    pub name: &'text str,
    /// The values by name; unescaped.
    pub attributes: Vec<(&'text str, Box<str>)>,
    pub children: Vec<Element<'text>>,
}

impl<'text> Element<'text> {
    /// Takes the value of the first given attribute of a list.
    pub fn take(&mut self, names: &[&str]) -> Option<Box<str>> {
        let index = self.attributes.iter().position(|(name, _)| names.contains(name))?;
        Some(self.attributes.remove(index).1)
    }

    /// Takes the number of an attribute; `None` if it isn't given or isn't a finite number.
    pub fn take_number(&mut self, names: &[&str]) -> Option<f64> {
        self.take(names)?.trim().parse().ok().filter(|number: &f64| number.is_finite())
    }

    /// Takes the value of an attribute; an empty text if it isn't given.
    pub fn take_text(&mut self, name: &str) -> String {
        self.take(&[name]).unwrap_or_default().into()
    }

    /// Takes a position in millimetres and returns it in metres.
    pub fn take_position(&mut self) -> Option<DVec2> {
        let [x, y] = [["positionX", "xPosition"], ["positionY", "yPosition"]]
            .map(|names| self.take_number(&names));
        Some(DVec2::new(x?, y?) / 1000.0)
    }

    /// Returns the value of an attribute without taking it.
    pub fn get(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|(key, _)| *key == name).map(|(_, value)| &**value)
    }

    /// Takes the children with a name.
    pub fn take_children(&mut self, name: &str) -> Vec<Self> {
        self.children.extract_if(.., |child| child.name == name).collect()
    }

    /// Counts the remaining attributes and children as ignored. `what` is the element with an
    /// article.
    pub fn ignore_rest(&self, what: &str, ignored: &mut Ignored) {
        for (name, _) in &self.attributes {
            ignored.add_named(self.at, format!("attribute `{}` of {what}", shorten(name)));
        }
        for child in &self.children {
            ignored.add_named(child.at, format!("element `{}` of {what}", shorten(child.name)));
        }
    }
}

/// Parses a text. Returns its outermost element.
///
/// # Errors
/// If the text isn't well-formed XML.
pub(super) fn parse<'text>(
    text: &'text str,
    ignored: &mut Ignored,
) -> Result<Element<'text>, SyntaxError> {
    let mut reader = Reader::from_str(text);
    reader.config_mut().expand_empty_elements = true;
    let mut open: Vec<Element<'text>> = Vec::new();
    let mut count = 0;
    loop {
        let position = reader.buffer_position() as usize;
        let error = |message| syntax_error(text, position, message);
        let event = reader.read_event().map_err(|error| {
            syntax_error(text, reader.error_position() as usize, error.to_string())
        })?;
        match event {
            Event::Start(start) => {
                count += 1;
                if count > MAX_ENTRIES || open.len() >= MAX_DEPTH {
                    let limit = format!(
                        "more than {MAX_ENTRIES} elements, or more than {MAX_DEPTH} nested ones"
                    );
                    return Err(error(limit));
                }
                open.push(element(text, position, &start).map_err(error)?);
            }
            Event::End(_) => {
                let Some(element) = open.pop() else {
                    return Err(error("an end without a start".to_owned()));
                };
                match open.last_mut() {
                    Some(parent) => parent.children.push(element),
                    None => return Ok(element),
                }
            }
            Event::Eof => return Err(error(unfinished(&open))),
            Event::Text(content) if content.trim().is_empty() => {}
            Event::Text(_) | Event::CData(_) | Event::GeneralRef(_) => {
                ignored.add(position as u32, "text between elements");
            }
            Event::DocType(_) => ignored.add(position as u32, "document type"),
            Event::Empty(_) | Event::Comment(_) | Event::Decl(_) | Event::PI(_) => {}
        }
    }
}

fn unfinished(open: &[Element<'_>]) -> String {
    match open.last() {
        Some(element) => {
            format!("the file ends inside element `{}`: is it complete?", shorten(element.name))
        }
        None => "the file has no element `model`: give a plant model of openTCS".to_owned(),
    }
}

fn element<'text>(
    text: &'text str,
    position: usize,
    start: &BytesStart<'_>,
) -> Result<Element<'text>, String> {
    let mut element = Element {
        at: position as u32,
        name: slice_of(text, start.local_name().into_inner()),
        attributes: Vec::new(),
        children: Vec::new(),
    };
    // The reader's check for duplicates takes quadratic time.
    for attribute in start.attributes().with_checks(false) {
        let attribute = attribute.map_err(|error| error.to_string())?;
        if element.attributes.len() >= MAX_ATTRIBUTES {
            return Err(format!("an element has more than {MAX_ATTRIBUTES} attributes"));
        }
        let value = attribute
            .normalized_value(XmlVersion::Implicit1_0)
            .map_err(|error| error.to_string())?;
        element.attributes.push((slice_of(text, attribute.key.into_inner()), value.into()));
    }
    Ok(element)
}

/// Returns a part of a text with the lifetime of the text.
fn slice_of<'text>(text: &'text str, part: &str) -> &'text str {
    offset_of(text, part).and_then(|at| text.get(at..at + part.len())).unwrap_or_default()
}

fn syntax_error(text: &str, at: usize, message: String) -> SyntaxError {
    SyntaxError::new(line_at(text.as_bytes(), at.min(text.len())), message)
}
