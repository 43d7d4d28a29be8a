//! A YAML value of any type, and the trait of the readers of lists and maps.

use std::borrow::Cow;
use std::fmt;

use serde::de::{
    Deserializer, EnumAccess, IgnoredAny, MapAccess, SeqAccess, VariantAccess, Visitor,
};

/// A value, as far as a route graph file can use it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Value<'text> {
    /// A list or map that its [`ReadValue`] has read.
    Read,
    Number(f64),
    Text(Cow<'text, str>),
    /// `null`, `~` or no value at all.
    Null,
    /// A value that no key accepts: its description, with an article.
    Other(&'static str),
}

/// A reader of a list or a map. The default methods skip the value.
pub(crate) trait ReadValue<'text>: Sized {
    fn map<A: MapAccess<'text>>(self, mut map: A) -> Result<Value<'text>, A::Error> {
        while map.next_entry::<IgnoredAny, IgnoredAny>()?.is_some() {}
        Ok(Value::Other("a map"))
    }

    fn list<A: SeqAccess<'text>>(self, mut list: A) -> Result<Value<'text>, A::Error> {
        while list.next_element::<IgnoredAny>()?.is_some() {}
        Ok(Value::Other("a list"))
    }
}

/// Reads the next value: lists and maps with `reader`.
pub(crate) fn read_value<'text, D: Deserializer<'text>>(
    reader: impl ReadValue<'text>,
    deserializer: D,
) -> Result<Value<'text>, D::Error> {
    deserializer.deserialize_any(AnyValue(reader))
}

/// Implements `DeserializeSeed` for a [`ReadValue`].
macro_rules! impl_deserialize_seed {
    ($name:ident $(<$($life:lifetime),*>)?) => {
        impl<'text> serde::de::DeserializeSeed<'text> for $name $(<$($life),*>)? {
            type Value = $crate::model::value::Value<'text>;

            fn deserialize<D: serde::de::Deserializer<'text>>(self, deserializer: D) -> Result<Self::Value, D::Error> {
                $crate::model::value::read_value(self, deserializer)
            }
        }
    };
}
pub(crate) use impl_deserialize_seed;

/// The reader of a scalar: a number, a text or null.
pub(crate) struct Scalar;

impl ReadValue<'_> for Scalar {}
impl_deserialize_seed!(Scalar);

impl Value<'_> {
    /// Returns a description for messages.
    pub fn describe(&self) -> Cow<'static, str> {
        match self {
            Self::Read => "a list or a map".into(),
            Self::Number(number) => format!("{number}").into(),
            Self::Text(text) => format!("`{}`", shorten(text)).into(),
            Self::Null => "empty".into(),
            Self::Other(what) => (*what).into(),
        }
    }

    /// Returns a text trimmed and in lower case; an empty text if the value is something else.
    pub fn lowercase(&self) -> String {
        match self {
            Self::Text(text) => text.trim().to_ascii_lowercase(),
            _ => String::new(),
        }
    }

    /// Returns a text, a number or a truth value as trimmed text.
    pub fn text(&self) -> Option<String> {
        match self {
            Self::Text(text) => Some(text.trim().to_owned()),
            Self::Number(number) => Some(number.to_string()),
            Self::Other(word) => {
                word.strip_prefix('`').and_then(|word| word.strip_suffix('`')).map(str::to_owned)
            }
            Self::Read | Self::Null => None,
        }
    }

    /// Returns the number, also if it is written as text.
    pub fn number(&self) -> Option<f64> {
        match self {
            Self::Number(number) => Some(*number),
            Self::Text(text) => text.trim().parse().ok(),
            _ => None,
        }
    }
}

/// Returns at most 40 characters of a text, with control characters escaped.
pub(crate) fn shorten(text: &str) -> String {
    let mut characters = text.chars();
    let start: String = characters.by_ref().take(40).collect();
    let dots = if characters.next().is_some() { "…" } else { "" };
    format!("{}{dots}", start.escape_debug())
}

/// Returns a number of things in words.
pub(crate) fn plural(count: usize, noun: &str) -> String {
    format!("{count} {noun}{}", if count == 1 { "" } else { "s" })
}

struct AnyValue<E>(E);

impl<'text, E: ReadValue<'text>> Visitor<'text> for AnyValue<E> {
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

    // Rounds above 2⁵³, which is far outside every valid range.
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
        Ok(Value::Null)
    }

    fn visit_none<E2>(self) -> Result<Self::Value, E2> {
        Ok(Value::Null)
    }

    fn visit_enum<A: EnumAccess<'text>>(self, tagged: A) -> Result<Self::Value, A::Error> {
        let (IgnoredAny, content) = tagged.variant()?;
        let IgnoredAny = content.newtype_variant()?;
        Ok(Value::Other("a tagged value"))
    }
}
