//! The columns and values of tables.

/// One value of a table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Value {
    Missing,
    U32(u32),
    U64(u64),
    F32(f32),
    F64(f64),
    Text(&'static str),
}

/// The type of a column's values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    U32,
    U64,
    F32,
    F64,
    Text,
}

/// A column of a table.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Column {
    /// The title names the unit.
    pub title: String,
    pub kind: Kind,
    /// Whether values may be missing.
    pub is_optional: bool,
}

impl Column {
    /// Returns a column that has a value in each row.
    pub fn new(title: &str, kind: Kind) -> Self {
        Self { title: title.to_owned(), kind, is_optional: false }
    }

    /// Returns a column in which values may be missing.
    pub fn optional(title: &str, kind: Kind) -> Self {
        Self { is_optional: true, ..Self::new(title, kind) }
    }
}

impl From<Option<u32>> for Value {
    fn from(value: Option<u32>) -> Self {
        value.map_or(Self::Missing, Self::U32)
    }
}

impl From<Option<f32>> for Value {
    fn from(value: Option<f32>) -> Self {
        value.map_or(Self::Missing, Self::F32)
    }
}
