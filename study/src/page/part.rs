//! The words and the colours of the parts of time on the page: those of robots' activities, as all
//! programs show them, where a part is an activity. `study.json` keeps its own names.

use plotters::style::RGBColor;
use regatta_meter::{Activity, Ground};

use crate::outcome::{CHARGING, STORAGE};

/// The colours of parts that aren't activities: they are none of those of activities.
const AT_STATION: RGBColor = RGBColor(228, 130, 180);
const FOR_ROBOT: RGBColor = RGBColor(208, 214, 220);
const FOR_PLACE: RGBColor = RGBColor(166, 150, 40);

/// Returns the activity of robots in a part of time, by the part's name in `study.json`; `None` if
/// it isn't a single one.
fn activity(part: &str) -> Option<Activity> {
    Some(match part {
        "way empty" => Activity::Fetching,
        "way loaded" => Activity::Carrying,
        "waiting in traffic" => Activity::Waiting,
        "handling" => Activity::Handling,
        "parked" => Activity::Queued,
        "idle" => Activity::Idle,
        CHARGING => Activity::Charging,
        _ => return None,
    })
}

/// Returns the word of a part, by its name in `study.json`.
pub(super) fn word(part: &'static str) -> &'static str {
    activity(part).map_or(part, Activity::name)
}

/// Returns the colour of a part, by its name in `study.json`: the same for orders and robots.
pub(super) fn colour(part: &str) -> RGBColor {
    match (activity(part), part) {
        (Some(activity), _) => of_activity(activity),
        (None, "waiting for a robot") => FOR_ROBOT,
        (None, STORAGE) => FOR_PLACE,
        (None, "waiting at a station") => AT_STATION,
        // Robots out of service are held, broken, faulted or stalled.
        (None, _) => of_activity(Activity::Broken),
    }
}

fn of_activity(activity: Activity) -> RGBColor {
    let [red, green, blue] = activity.rgb(Ground::Light);
    RGBColor(red, green, blue)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;
    use crate::outcome::{ORDER_PARTS, ROBOT_PARTS};

    #[test]
    fn each_part_has_a_word_and_a_colour_of_its_own() {
        let parts: BTreeSet<_> = ORDER_PARTS.into_iter().chain(ROBOT_PARTS).collect();
        let words: BTreeSet<_> = parts.iter().map(|part| word(part)).collect();
        let colours: BTreeSet<_> = parts.iter().map(|part| colour(part)).map(numbers).collect();
        assert_eq!((words.len(), colours.len()), (parts.len(), parts.len()));
    }

    fn numbers(RGBColor(red, green, blue): RGBColor) -> [u8; 3] {
        [red, green, blue]
    }

    #[test]
    fn activities_have_the_words_and_the_colours_of_all_programs() {
        assert_eq!(word("way empty"), "fetching");
        assert_eq!(word("waiting in traffic"), "waiting");
        assert_eq!(word("parked"), "queued");
        assert_eq!(numbers(colour("way loaded")), Activity::Carrying.rgb(Ground::Light));
    }
}
