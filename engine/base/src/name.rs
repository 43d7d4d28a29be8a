//! Names of enum values, as files and the command line give them.

pub use strum::VariantArray;

/// The error of parsing the name of an enum value.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{}` is not {kind}: use {}", text.escape_debug(), listed(names))]
pub struct UnknownName {
    text: String,
    kind: &'static str,
    names: Vec<&'static str>,
}

/// Parses the name of an enum value, ignoring case and surrounding white space. `kind` names the
/// enum in the error, with an article.
///
/// # Errors
/// [`UnknownName`] if no value has this name.
///
/// ```
/// use regatta_base::graph::Rotation;
/// use regatta_base::name;
///
/// assert_eq!(name::parse(" CCW ", "a rotation"), Ok(Rotation::CounterClockwise));
/// let error = name::parse::<Rotation>("left", "a rotation").expect_err("no such rotation");
/// assert_eq!(error.to_string(), "`left` is not a rotation: use shorter, ccw, cw or none");
/// ```
pub fn parse<T>(text: &str, kind: &'static str) -> Result<T, UnknownName>
where
    T: VariantArray + Into<&'static str> + Copy,
{
    let text = text.trim();
    for &value in T::VARIANTS {
        if value.into().eq_ignore_ascii_case(text) {
            return Ok(value);
        }
    }
    let names = T::VARIANTS.iter().map(|&value| value.into()).collect();
    Err(UnknownName { text: text.to_owned(), kind, names })
}

/// Implements the names of an enum that derives `IntoStaticStr` and `VariantArray` of strum: the
/// list `ALL` of its values, `name`, and `FromStr`, which ignores case. The second argument names
/// the enum in errors, with an article.
#[macro_export]
macro_rules! named {
    ($type:ident, $kind:literal) => {
        impl $type {
            /// All values.
            pub const ALL: &[Self] = <Self as $crate::name::VariantArray>::VARIANTS;

            /// Returns the name that files and the command line use.
            pub fn name(self) -> &'static str {
                self.into()
            }
        }

        impl ::std::str::FromStr for $type {
            type Err = $crate::name::UnknownName;

            /// Parses a name, ignoring case.
            fn from_str(text: &str) -> Result<Self, $crate::name::UnknownName> {
                $crate::name::parse(text, $kind)
            }
        }
    };
}

/// Returns names as in 'a, b or c'.
fn listed(names: &[&str]) -> String {
    match names {
        [others @ .., last] if !others.is_empty() => format!("{} or {last}", others.join(", ")),
        _ => names.concat(),
    }
}
