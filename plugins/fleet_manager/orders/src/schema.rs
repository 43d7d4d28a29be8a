//! The values of requests in the OpenAPI document, as strict as their checks.

use std::borrow::Cow;

use utoipa::openapi::schema::{Object, ObjectBuilder, OneOfBuilder, Type};
use utoipa::openapi::{RefOr, Schema};
use utoipa::{PartialSchema, ToSchema};

use crate::draft::MAX_SECS;
use crate::order::{Action, OrderName, State, UNSEEN};

impl PartialSchema for OrderName {
    fn schema() -> RefOr<Schema> {
        order_name().into()
    }
}

impl ToSchema for OrderName {
    fn name() -> Cow<'static, str> {
        "OrderName".into()
    }
}

/// The name of a new order. The prefixes of generated ones are reserved.
fn order_name() -> Object {
    let unseen: String = UNSEEN.iter().map(|(first, last)| range(*first, *last)).collect();
    let controls = range('\0', '\u{1f}') + &range('\u{7f}', '\u{9f}');
    let (load, sent) = (OrderName::GENERATED, OrderName::REQUESTED);
    let pattern = format!(r"^(?!{load}|{sent}|\.$)(?!.*\.\.)[^/{controls}{unseen}]+$");
    let text = text().min_length(Some(1)).max_length(Some(OrderName::MAX_CHARS));
    text.pattern(Some(pattern)).build()
}

/// A range of characters in a pattern of JSON Schema.
fn range(first: char, last: char) -> String {
    format!(r"\u{{{:x}}}-\u{{{:x}}}", u32::from(first), u32::from(last))
}

/// A name of an action, in any case.
pub(crate) fn operation() -> Object {
    let names: Vec<_> = Action::NAMES.iter().map(|name| in_any_case(name)).collect();
    text().pattern(Some(format!("^({})$", names.join("|")))).build()
}

fn in_any_case(name: &str) -> String {
    let letters = name.chars().map(|letter| match letter {
        ' ' => " ".to_owned(),
        letter => format!("[{letter}{}]", letter.to_ascii_uppercase()),
    });
    letters.collect()
}

/// A number of seconds.
pub(crate) fn seconds() -> Object {
    ObjectBuilder::new()
        .schema_type(Type::Number)
        .minimum(Some(0.0))
        .maximum(Some(MAX_SECS))
        .build()
}

/// The name or the id of a node.
pub(crate) fn location() -> Schema {
    OneOfBuilder::new().item(id()).item(text().build()).build().into()
}

/// The id of a robot, as a number or a text.
pub(crate) fn robot() -> Schema {
    let number = text().pattern(Some("^[0-9]{1,9}$")).build();
    OneOfBuilder::new().item(id()).item(number).build().into()
}

/// The states by which orders are listed.
pub(crate) fn listed_states() -> Object {
    text().enum_values(Some(["open"].into_iter().chain(State::NAMES.iter().copied()))).build()
}

fn id() -> Object {
    ObjectBuilder::new()
        .schema_type(Type::Integer)
        .minimum(Some(0))
        .maximum(Some(f64::from(u32::MAX)))
        .build()
}

fn text() -> ObjectBuilder {
    ObjectBuilder::new().schema_type(Type::String)
}
