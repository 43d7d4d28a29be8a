//! One YAML value of any shape, and how a map or a list is handed on to whoever expected it.

use std::borrow::Cow;
use std::fmt;

use serde::de::{Deserializer, EnumAccess, IgnoredAny, MapAccess, SeqAccess, VariantAccess, Visitor};

/// A value as far as a route graph file can use it.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Value<'text> {
    /// A list or map that its [`Expect`] has read.
    Read,
    Number(f64),
    Text(Cow<'text, str>),
    /// `null`, `~` or nothing at all.
    Nothing,
    /// Something that no key has use for: what it is, with its article.
    Other(&'static str),
}

/// What to do with a value that is a list or a map. Both skip it unless told otherwise.
pub(super) trait Expect<'text>: Sized {
    fn map<A: MapAccess<'text>>(self, mut map: A) -> Result<Value<'text>, A::Error> {
        while map.next_entry::<IgnoredAny, IgnoredAny>()?.is_some() {}
        Ok(Value::Other("a map"))
    }

    fn list<A: SeqAccess<'text>>(self, mut list: A) -> Result<Value<'text>, A::Error> {
        while list.next_element::<IgnoredAny>()?.is_some() {}
        Ok(Value::Other("a list"))
    }
}

/// Reads the next value.
pub(super) fn read_value<'text, D: Deserializer<'text>>(
    expect: impl Expect<'text>,
    deserializer: D,
) -> Result<Value<'text>, D::Error> {
    deserializer.deserialize_any(AnyValue(expect))
}

/// Implements `DeserializeSeed` for an [`Expect`].
macro_rules! expect_seed {
    ($name:ident $(<$($life:lifetime),*>)?) => {
        impl<'text> serde::de::DeserializeSeed<'text> for $name $(<$($life),*>)? {
            type Value = $crate::graph::value::Value<'text>;

            fn deserialize<D: serde::de::Deserializer<'text>>(self, deserializer: D) -> Result<Self::Value, D::Error> {
                $crate::graph::value::read_value(self, deserializer)
            }
        }
    };
}
pub(super) use expect_seed;

/// A number, text or nothing: what a key's value should be.
pub(super) struct Scalar;

impl Expect<'_> for Scalar {}
expect_seed!(Scalar);

impl Value<'_> {
    /// What it is, for a message.
    pub fn describe(&self) -> Cow<'static, str> {
        match self {
            Self::Read => "a list or a map".into(),
            Self::Number(number) => format!("{number}").into(),
            Self::Text(text) => format!("`{}`", shorten(text)).into(),
            Self::Nothing => "empty".into(),
            Self::Other(what) => (*what).into(),
        }
    }

    /// The number, also if it is written as text.
    pub fn number(&self) -> Option<f64> {
        match self {
            Self::Number(number) => Some(*number),
            Self::Text(text) => text.trim().parse().ok(),
            _ => None,
        }
    }
}

/// At most 40 characters of a text, control characters escaped.
pub(super) fn shorten(text: &str) -> String {
    let mut characters = text.chars();
    let start: String = characters.by_ref().take(40).collect();
    let dots = if characters.next().is_some() { "…" } else { "" };
    format!("{}{dots}", start.escape_debug())
}

struct AnyValue<E>(E);

impl<'text, E: Expect<'text>> Visitor<'text> for AnyValue<E> {
    type Value = Value<'text>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("any value")
    }

    fn visit_map<A: MapAccess<'text>>(self, map: A) -> Result<Self::Value, A::Error> {
        self.0.map(map)
    }

    fn visit_seq<A: SeqAccess<'text>>(self, list: A) -> Result<Self::Value, A::Error> {
        self.0.list(list)
    }

    fn visit_f64<E2>(self, value: f64) -> Result<Self::Value, E2> {
        Ok(Value::Number(value))
    }

    // Rounds beyond 2⁵³, which is far outside of every range here.
    fn visit_u64<E2>(self, value: u64) -> Result<Self::Value, E2> {
        Ok(Value::Number(value as f64))
    }

    fn visit_i64<E2>(self, value: i64) -> Result<Self::Value, E2> {
        Ok(Value::Number(value as f64))
    }

    fn visit_u128<E2>(self, value: u128) -> Result<Self::Value, E2> {
        Ok(Value::Number(value as f64))
    }

    fn visit_i128<E2>(self, value: i128) -> Result<Self::Value, E2> {
        Ok(Value::Number(value as f64))
    }

    fn visit_borrowed_str<E2>(self, value: &'text str) -> Result<Self::Value, E2> {
        Ok(Value::Text(Cow::Borrowed(value)))
    }

    fn visit_str<E2>(self, value: &str) -> Result<Self::Value, E2> {
        Ok(Value::Text(Cow::Owned(value.to_owned())))
    }

    fn visit_bool<E2>(self, value: bool) -> Result<Self::Value, E2> {
        Ok(Value::Other(if value { "`true`" } else { "`false`" }))
    }

    fn visit_unit<E2>(self) -> Result<Self::Value, E2> {
        Ok(Value::Nothing)
    }

    fn visit_none<E2>(self) -> Result<Self::Value, E2> {
        Ok(Value::Nothing)
    }

    fn visit_enum<A: EnumAccess<'text>>(self, tagged: A) -> Result<Self::Value, A::Error> {
        let (IgnoredAny, content) = tagged.variant()?;
        let IgnoredAny = content.newtype_variant()?;
        Ok(Value::Other("a tagged value"))
    }
}
