use super::*;
use glam::Vec3;
use regatta_plugin::world::{DoorRecord, EdgeRecord, NodeRecord, Role, WorldData};

const SIZE: Vec2 = Vec2::new(1280.0, 720.0);

fn labels(nodes: impl Iterator<Item = NodeRecord>) -> Labels {
    Labels::new(&WorldData { nodes: nodes.collect(), ..WorldData::default() }.view(1, 1), None)
}

fn row(count: u32) -> Labels {
    labels((0..count).map(|i| NodeRecord { id: i, x: i as f32 * 2.0, ..NodeRecord::default() }))
}

fn over(x: f32, distance: f32) -> Camera {
    Camera { target: Vec3::new(x, 0.0, 0.0), pitch: 1.2, distance, ..Camera::default() }
}

#[test]
fn only_ids_that_are_near_and_in_sight_are_drawn() {
    let labels = row(100_000);
    assert!(
        labels.visible(&over(5_000.0, 200.0), Vec2::ZERO, SIZE).is_empty(),
        "the camera is too far away"
    );
    let near = labels.visible(&over(5_000.0, 20.0), Vec2::ZERO, SIZE);
    assert!(
        near.iter().any(|(label, at)| label.id == 2_500 && at.distance(SIZE / 2.0) < 1.0),
        "{near:?}"
    );
    assert!(near.len() > 5 && near.iter().all(|(label, _)| (label.place.x - 5_000.0).abs() < 40.0));
    let moved = labels.visible(&over(5_007.0, 20.0), Vec2::new(7.0, 0.0), SIZE);
    assert_eq!(moved.len(), near.len(), "the offset moves the labels");
}

#[test]
fn ids_do_not_overlap_and_their_number_is_limited() {
    let nodes = (0..40_000).map(|i| NodeRecord {
        id: i,
        x: (i % 200) as f32 * 0.1 - 10.0,
        y: (i / 200) as f32 * 0.1 - 10.0,
        ..NodeRecord::default()
    });
    let labels = labels(nodes);
    let near = labels.visible(&over(0.0, 20.0), Vec2::ZERO, SIZE);
    assert!(near.len() > 100 && near.len() <= MAX_LABELS, "{}", near.len());
    for (i, (_, a)) in near.iter().enumerate() {
        assert!(near[..i].iter().all(|(_, b)| (a.y / CELL.y).floor() != (b.y / CELL.y).floor()
            || (a.x - b.x).abs() >= CELL.x));
    }
}

#[test]
fn doors_have_their_names() {
    let mut world = WorldData::default();
    let name = world.texts.add("gate");
    world.add_edge(EdgeRecord::default(), []);
    world.add_door(DoorRecord { name, ..DoorRecord::default() }, [0]);
    let labels = Labels::new(&world.view(1, 1), None);
    let near = labels.visible(&over(0.0, 20.0), Vec2::ZERO, SIZE);
    let texts: Vec<_> = near.iter().map(|(label, _)| label.text()).collect();
    assert_eq!(texts, ["gate"]);
}

#[test]
fn a_fitted_plant_has_some_names_and_more_of_them_nearer() {
    let mut world = WorldData::default();
    for id in 0..100 {
        let name = world.texts.add(&format!("rack {id}"));
        let (x, role) = (id as f32, Role::Pick as u32);
        world.nodes.push(NodeRecord { id, name, x, role, ..NodeRecord::default() });
    }
    let labels = Labels::new(&world.view(1, 1), None);
    let tried = |width: f32| {
        let bounds = Bounds { low: Vec2::ZERO, high: Vec2::new(width, 1.0) };
        let camera = Camera::top(bounds, SIZE.x / SIZE.y);
        let visible = labels.visible(&camera, Vec2::ZERO, SIZE);
        visible.iter().map(|(label, _)| label.text()).collect::<Vec<_>>()
    };
    let [all, half] = [tried(100.0), tried(50.0)];
    assert!((5..60).contains(&all.len()) && half.len() >= 5, "{all:?} {half:?}");
    let number = |name: &String| name.trim_start_matches("rack ").parse().unwrap_or(0);
    let kept = all.iter().filter(|&name| number(name) < 50);
    assert!(kept.clone().count() > 2 && kept.into_iter().all(|name| half.contains(name)));
}

#[test]
fn a_name_may_lie_on_each_side_of_its_station() {
    let (at, size) = (pos2(100.0, 100.0), egui::vec2(80.0, 14.0));
    let sides = Kind::Station.sides(at, size);
    let badge = Rect::from_center_size(at, egui::vec2(16.0, 16.0));
    assert!(sides.iter().all(|side| side.size() == size && !side.intersects(badge)), "{sides:?}");
    assert_eq!(sides[0].left_bottom(), pos2(114.0, 90.0), "right above it");
    for (index, side) in sides.iter().enumerate() {
        assert!(!sides[..index].contains(side), "{side:?}");
    }
    assert_eq!(Kind::Node.sides(at, size).len(), 2);
}

#[test]
fn a_station_has_its_name() {
    let mut world = WorldData::default();
    let [name, corner] = ["inbound dock 4", "corner"].map(|name| world.texts.add(name));
    let station = |id, name, x, role: Role| NodeRecord {
        id,
        name,
        x,
        role: role as u32,
        ..NodeRecord::default()
    };
    world.nodes = vec![
        station(1, name, 0.0, Role::Pick),
        station(2, 0, 6.0, Role::Charge),
        station(3, corner, -6.0, Role::None),
        station(4, 0, -8.0, Role::None),
    ];
    let labels = Labels::new(&world.view(1, 1), None);
    let near = labels.visible(&over(0.0, 20.0), Vec2::ZERO, SIZE);
    let texts: Vec<_> = near.iter().map(|(label, _)| label.text()).collect();
    assert_eq!(texts, ["inbound dock 4", "charge 2", "corner", "4"]);
}
