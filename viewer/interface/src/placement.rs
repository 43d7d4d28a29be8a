//! The places of elements over the picture: none covers a panel or another element.

use egui::{Align2, Rect, Vec2, pos2};

/// The distance from the edge of the picture, in points.
pub const MARGIN: f32 = 10.0;
/// The least distance between two elements, in points.
const GAP: f32 = 6.0;
/// The greatest error of a rounded place, in points.
const ROUNDING: f32 = 0.5;

/// The places of the elements over one picture. They are taken in the order of their importance, so
/// that the least important elements are left out where there is no room for all.
#[derive(Clone, Debug)]
pub struct Placement {
    room: Rect,
    taken: Vec<(&'static str, Rect)>,
}

impl Placement {
    /// Begins with nothing over a picture of which no panel covers this part.
    pub fn new(visible: Rect) -> Self {
        Self { room: visible.shrink(MARGIN), taken: Vec::new() }
    }

    /// The part of the picture in which elements may lie.
    pub fn room(&self) -> Rect {
        self.room
    }

    /// The names and the places of the elements so far.
    pub fn taken(&self) -> &[(&'static str, Rect)] {
        &self.taken
    }

    /// The place of an element, unless it is left out.
    pub fn place_of(&self, name: &str) -> Option<Rect> {
        self.taken.iter().find(|(taken, _)| *taken == name).map(|(_, place)| *place)
    }

    /// Takes the free place that is the nearest to a corner, a side or the centre of the picture.
    /// Returns `None` if there is no room: the element is left out.
    pub fn take(&mut self, name: &'static str, size: Vec2, at: Align2) -> Option<Rect> {
        self.take_near(name, at.align_size_within_rect(size, self.room))
    }

    /// Like [`Self::take`], with the place where the element would be alone.
    pub fn take_near(&mut self, name: &'static str, wanted: Rect) -> Option<Rect> {
        let size = wanted.size();
        let (mut lefts, mut tops) = (Vec::new(), Vec::new());
        for (_, taken) in &self.taken {
            lefts.extend([taken.left() - GAP - size.x, taken.right() + GAP]);
            tops.extend([taken.top() - GAP - size.y, taken.bottom() + GAP]);
        }
        lefts.push(wanted.left());
        tops.push(wanted.top());
        let places = tops.iter().flat_map(|top| {
            lefts.iter().map(move |left| Rect::from_min_size(pos2(*left, *top), size))
        });
        let free = places.filter(|place| self.is_free(*place));
        let distances = free.map(|place| ((place.min - wanted.min).length_sq(), place));
        let (_, nearest) = distances.min_by(|(a, _), (b, _)| a.total_cmp(b))?;
        self.taken.push((name, nearest));
        Some(nearest)
    }

    /// Takes a place that can't be another one. Returns whether it is free.
    pub fn take_exactly(&mut self, name: &'static str, place: Rect) -> bool {
        let is_clear = self.is_clear(place);
        if is_clear {
            self.taken.push((name, place));
        }
        is_clear
    }

    /// Whether no element lies there.
    pub fn is_clear(&self, place: Rect) -> bool {
        self.taken.iter().all(|(_, taken)| !taken.intersects(place))
    }

    fn is_free(&self, place: Rect) -> bool {
        self.room.expand(ROUNDING).contains_rect(place)
            && !self.taken.iter().any(|(_, taken)| taken.expand(GAP - ROUNDING).intersects(place))
    }
}

#[cfg(test)]
mod tests {
    use egui::vec2;

    use super::*;

    fn placement(width: f32, height: f32) -> Placement {
        Placement::new(Rect::from_min_size(pos2(100.0, 50.0), vec2(width, height)))
    }

    #[test]
    fn elements_lie_where_they_are_wanted_while_there_is_room() {
        let mut placement = placement(800.0, 600.0);
        let size = vec2(100.0, 50.0);
        assert_eq!(
            placement.take("one", size, Align2::LEFT_BOTTOM).map(|place| place.min),
            Some(pos2(110.0, 590.0))
        );
        assert_eq!(
            placement.take("other", size, Align2::RIGHT_TOP).map(|place| place.min),
            Some(pos2(790.0, 60.0))
        );
    }

    #[test]
    fn elements_never_overlap_and_the_last_ones_are_left_out() {
        let corners = [
            Align2::LEFT_BOTTOM,
            Align2::CENTER_BOTTOM,
            Align2::RIGHT_BOTTOM,
            Align2::CENTER_TOP,
            Align2::RIGHT_TOP,
        ];
        let names = ["a", "b", "c", "d", "e"];
        for (width, height) in [(30.0, 900.0), (250.0, 140.0), (400.0, 200.0), (900.0, 500.0)] {
            let mut placement = placement(width, height);
            let room = placement.room();
            for (name, at) in names.into_iter().zip(corners) {
                let size = vec2(150.0, 60.0);
                let placed = placement.take(name, size, at);
                assert_eq!(placed, placement.place_of(name));
                assert!(
                    placed.is_none_or(|place| room.contains_rect(place) && place.size() == size),
                    "{placed:?}"
                );
            }
            let places = placement.taken();
            for (i, (_, one)) in places.iter().enumerate() {
                assert!(places[..i].iter().all(|(_, other)| !one.intersects(*other)), "{places:?}");
            }
            let wanted = [(30.0, 0), (250.0, 1), (400.0, 4), (900.0, 5)];
            assert!(wanted.contains(&(width, places.len())), "{width}: {places:?}");
        }
    }
}
