//! The origins of LIF 2: lists of layouts with one coordinate system.

use super::Sheet;
use super::object::{Context, Object, Raw};

/// Returns the layouts of all origins.
pub(super) fn sheets<'text>(
    origins: Vec<Raw<'text>>,
    context: &mut Context<'_, 'text>,
) -> Vec<Sheet<'text>> {
    if let [_, second, ..] = origins.as_slice() {
        let (at, count) = (context.at(second), origins.len());
        let message = format!(
            "the layouts of {count} origins lie in one plane, though their positions don't relate \
             to each other: to read only those of one, name its `originId` with --level"
        );
        context.warning(at, message);
    }
    origins.into_iter().flat_map(|raw| sheets_of_origin(raw, context)).collect()
}

fn sheets_of_origin<'text>(raw: Raw<'text>, context: &mut Context<'_, 'text>) -> Vec<Sheet<'text>> {
    let Some(mut origin) = Object::parse(raw, "an origin", context) else { return Vec::new() };
    let id = origin.take_text("originId", context);
    let layouts = origin.take_list("layouts", context);
    origin.ignore_rest(context);
    layouts.into_iter().filter_map(|raw| Sheet::parse(raw, id.as_deref(), context)).collect()
}
