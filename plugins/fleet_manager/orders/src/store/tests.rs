use std::sync::mpsc::channel;

use super::*;
use crate::order::{Action, NewOrder, Order, OrderId, Stop};
use crate::places::Place;
use crate::threads::{InsertError, Job};
use crate::{Candidate, OrderPool, OrderSettings};

fn places() -> Arc<Places> {
    Arc::new(Places::new((0..4).map(|id| Place { id: id + 10, ..Place::default() }).collect()))
}

fn folder() -> tempfile::TempDir {
    tempfile::tempdir().expect("a folder")
}

fn order(name: &str) -> NewOrder {
    let stop = |node, action| Stop { node, action, dwell_secs: 2.5 };
    NewOrder {
        name: OrderName::parse(name).expect("a name"),
        stops: vec![stop(1, Action::Pick), stop(2, Action::Drop)],
        priority: 7,
        earliest_secs: 0.0,
        deadline_secs: Some(90.0),
        intended_robot: Some(5),
        robot_types: Vec::new(),
    }
}

fn insert(writer: &Writer, orders: Vec<NewOrder>) -> Result<(), InsertError> {
    let (sender, receiver) = channel();
    let done = Box::new(move |result| sender.send(result).expect("a receiver"));
    writer
        .sender()
        .expect("running")
        .send(Job::Insert { orders, created_secs: 3.5, done })
        .expect("running");
    receiver.recv().expect("an answer")
}

fn restored(path: &Path, run_id: u64) -> Restored {
    OrderStore::open(path, places()).expect("a store").restore(run_id, 0.0).expect("orders")
}

fn open(path: &Path) -> Result<OrderStore, StoreError> {
    OrderStore::open(path, places())
}

#[test]
fn orders_come_back_in_their_order() {
    let folder = folder();
    let path = folder.path().join("orders.db");
    assert!(restored(&path, 1).orders.is_empty());
    let writer = Writer::start(open(&path).expect("a store")).expect("a thread");
    assert_eq!(insert(&writer, vec![order("z"), order("a")]), Ok(()));
    let duplicate = InsertError::Duplicate(OrderName::parse("a").expect("a name"));
    assert_eq!(
        insert(&writer, vec![order("b"), order("a")]),
        Err(duplicate),
        "and b isn't kept either"
    );
    drop(writer);
    let orders = restored(&path, 1).orders;
    let contents: Vec<_> = orders.iter().map(|order| order.content.clone()).collect();
    assert_eq!(contents, [order("z"), order("a")]);
    assert_eq!(orders.iter().map(|order| order.id.0).collect::<Vec<_>>(), [1, 2]);
}

#[test]
fn what_a_robot_has_begun_stays_with_it_in_the_same_run() {
    let folder = folder();
    let path = folder.path().join("orders.db");
    let settings = OrderSettings { store: Some(path.clone()), ..OrderSettings::default() };
    let reopen = |run_id| OrderPool::open(&settings, places(), run_id, 100.0).expect("a pool");
    let mut pool = reopen(1);
    let text = "- {name: begun, stops: [11, 12]}\n- {name: assigned, stops: [13]}\n- {name: over, stops: [10]}\n";
    pool.add_orders(&crate::file::parse_yaml(text).expect("orders")).expect("valid");
    pool.generate_until(0.0, 3);
    let robots = [0, 1, 2].map(|robot| Candidate { robot, ..Candidate::default() });
    pool.assign(0.0, &robots, &|robot, node| Some(f64::from((robot + 1).abs_diff(node))));
    let robot_of = |pool: &OrderPool, name: &str| {
        let order = pool.open_orders().find(|order| order.content.name.as_str() == name);
        order.and_then(|order| order.state.robot())
    };
    let (begun, over) =
        (robot_of(&pool, "begun").expect("assigned"), robot_of(&pool, "over").expect("assigned"));
    assert!(pool.arrived(begun, 1.0).is_some() && pool.handled(begun, 2.0).is_some());
    assert!(pool.arrived(over, 1.0).is_some() && pool.handled(over, 2.0).is_some());
    pool.publish(2.0);
    drop(pool);

    let pool = reopen(1);
    assert_eq!((robot_of(&pool, "begun"), robot_of(&pool, "assigned")), (Some(begun), None));
    let assigned =
        pool.open_orders().find(|order| order.content.name.as_str() == "assigned").expect("open");
    let times: Vec<_> = assigned.history.iter().map(|entry| entry.secs).collect();
    assert_eq!(times, [0.0, 0.0, 100.0], "it was withdrawn when the pool was opened");
    assert_eq!(pool.current_stop(begun).map(|stop| stop.node), Some(2));
    assert_eq!(pool.open_orders().count(), 2, "one is over");
    drop(pool);
    let pool = reopen(2);
    assert_eq!(
        (robot_of(&pool, "begun"), pool.open_orders().count()),
        (None, 2),
        "another run has other robots"
    );
    assert!(
        pool.open_orders()
            .all(|order| order.created_secs == 100.0 && order.history[0].secs == 100.0)
    );
}

#[test]
fn files_and_loads_continue_where_they_were() {
    let folder = folder();
    let (load, orders) = (folder.path().join("load.yaml"), folder.path().join("orders.csv"));
    std::fs::write(&load, "load: {per_hour: 3600}").expect("written");
    std::fs::write(&orders, "name,time,stops\na,1,10\nb,500,11\n").expect("written");
    let store = Some(folder.path().join("orders.db"));
    let settings =
        OrderSettings { load: Some(load), orders: Some(orders), store, ..OrderSettings::default() };
    let mut names = Vec::new();
    let mut run = |run_id, until: f64| {
        let mut pool = OrderPool::open(&settings, places(), run_id, 0.0).expect("a pool");
        pool.generate_until(until, 0);
        pool.publish(until);
        names = pool.open_orders().map(|order| order.content.name.to_string()).collect();
        names.len()
    };
    let first = run(1, 300.0);
    let second = run(1, 600.0);
    assert!(second > first + 200, "{first} {second}");
    let whole = {
        let mut pool =
            OrderPool::open(&OrderSettings { store: None, ..settings.clone() }, places(), 1, 0.0)
                .expect("a pool");
        pool.generate_until(600.0, 0);
        pool.open_orders().count()
    };
    assert_eq!(second, whole, "none twice");
    assert!(run(2, 10.0) > second, "another run has new ones");
    assert!(names.iter().any(|name| name == "load:2:1-1"), "{names:?}");
}

#[test]
fn a_store_belongs_to_one_process() {
    let folder = folder();
    let path = folder.path().join("orders.db");
    let first = open(&path).expect("a store");
    let error = open(&path).expect_err("in use").to_string();
    assert!(
        error.contains("another process keeps its orders in") && !error.contains('\n'),
        "{error}"
    );
    drop(first);
    assert!(open(&path).is_ok());
}

#[test]
fn other_files_are_refused_and_left_as_they_are() {
    let folder = folder();
    let path = folder.path().join("other");
    let database = |setup: &str| {
        let path = folder.path().join(format!("{}.db", setup.len()));
        Connection::open(&path)
            .and_then(|connection| connection.execute_batch(setup))
            .expect("a database");
        path
    };
    std::fs::write(&path, "name,stops\n").expect("written");
    assert!(matches!(open(&path), Err(StoreError::Foreign(_))));
    let foreign = database("CREATE TABLE songs (title TEXT)");
    let newer = database(&format!(
        "PRAGMA application_id = {APPLICATION_ID}; PRAGMA user_version = 99; CREATE TABLE a (b)"
    ));
    for (path, expected) in
        [(&path, "not a store"), (&foreign, "not a store"), (&newer, "tables 99, not 3")]
    {
        let before = std::fs::read(path).expect("readable");
        let error = open(path).expect_err("refused").to_string();
        assert!(error.contains(expected), "{error}");
        assert!(std::fs::read(path).expect("readable") == before, "{}", path.display());
    }
    assert!(matches!(open(&folder.path().join("no/such/folder")), Err(StoreError::Io { .. })));
    assert!(matches!(open(folder.path()), Err(StoreError::Io { .. })));
}

#[test]
fn a_store_of_the_first_version_is_continued() {
    let folder = folder();
    let path = folder.path().join("old.db");
    let setup = format!(
        "PRAGMA application_id = {APPLICATION_ID}; PRAGMA user_version = 1; {SCHEMA}
         INSERT INTO transport_order (name, state, priority, created, earliest, handled_stops, reason, stops, history)
         VALUES ('a', 'created', 3, 1.0, 0.0, 0, '', '[{{\"node\": 10, \"action\": \"pick\", \"dwell\": 0}}]', '[]')"
    );
    Connection::open(&path)
        .and_then(|connection| connection.execute_batch(&setup))
        .expect("a database");
    let restored = open(&path).and_then(|mut store| store.restore(1, 0.0)).expect("a store");
    let [order] = &restored.orders[..] else { panic!("{restored:?}") };
    assert_eq!((order.content.priority, order.content.intended_robot), (3, None));
    assert!(open(&path).is_ok(), "it is of the new version now");
}

#[test]
fn where_a_robot_was_sent_ends_with_its_run() {
    let folder = folder();
    let path = folder.path().join("orders.db");
    let open_in = |run_id| {
        open(&path).and_then(|mut store| store.restore(run_id, 0.0)).expect("a store").orders
    };
    assert!(open_in(1).is_empty());
    let setup = "INSERT INTO transport_order (name, state, priority, created, earliest, handled_stops, reason, stops, history)
         VALUES ('sent:3-7-00000001', 'waiting', 255, 1.0, 0.0, 0, '', '[{\"node\": 10, \"action\": \"none\", \"dwell\": 0}]', '[]')";
    Connection::open(&path)
        .and_then(|connection| connection.execute_batch(setup))
        .expect("a database");
    assert_eq!(open_in(1).len(), 1, "in the same run it goes on");
    assert!(open_in(2).is_empty());
}

#[test]
fn a_damaged_store_is_refused() {
    let folder = folder();
    let path = folder.path().join("orders.db");
    let writer = Writer::start(open(&path).expect("a store")).expect("a thread");
    insert(&writer, (0..2_000).map(|number| order(&format!("order-{number}"))).collect())
        .expect("kept");
    drop(writer);
    let mut bytes = std::fs::read(&path).expect("readable");
    let middle = bytes.len() / 2;
    bytes[middle..middle + 20_000].fill(0xa5);
    std::fs::write(&path, &bytes).expect("written");
    let error = open(&path).expect_err("damaged").to_string();
    assert!(error.contains("is damaged") && !error.contains('\n'), "{error}");
    assert!(std::fs::read(&path).expect("readable") == bytes);
}

#[test]
fn a_full_disk_is_told_and_what_was_acknowledged_is_kept() {
    let folder = folder();
    let path = folder.path().join("orders.db");
    let store = open(&path).expect("a store");
    store.connection.pragma_update(None, "max_page_count", 60).expect("a limit");
    let writer = Writer::start(store).expect("a thread");
    let mut kept = 0;
    let error = loop {
        match insert(&writer, vec![order(&format!("order-{kept}"))]) {
            Ok(()) => kept += 1,
            Err(error) => break error,
        }
    };
    assert_eq!(error, InsertError::Write("the disk is full".to_owned()));
    drop(writer);
    assert!(kept > 100);
    assert_eq!(restored(&path, 1).orders.len(), kept);
}

#[test]
fn orders_of_nodes_that_are_gone_stay_in_the_store() {
    let folder = folder();
    let path = folder.path().join("orders.db");
    let writer = Writer::start(open(&path).expect("a store")).expect("a thread");
    insert(&writer, vec![order("a")]).expect("kept");
    drop(writer);
    let fewer = Arc::new(Places::new(vec![Place { id: 10, ..Place::default() }]));
    let found = OrderStore::open(&path, fewer).expect("a store").restore(1, 0.0).expect("read");
    assert_eq!((found.orders.len(), found.unplaced), (0, 1));
    assert_eq!(restored(&path, 1).orders.len(), 1);
}

#[test]
fn settled_changes_are_in_the_store() {
    let folder = folder();
    let path = folder.path().join("orders.db");
    let writer = Writer::start(open(&path).expect("a store")).expect("a thread");
    let reader = Connection::open(&path).expect("a second connection");
    for number in 1..=200 {
        let order = Order::new(OrderId(number), order(&format!("order {number}")), 0.0);
        writer.update(vec![Arc::new(order)], Vec::new());
        assert!(writer.settle());
        let count = reader.query_row("SELECT count(*) FROM transport_order", [], |row| row.get(0));
        assert_eq!(count, Ok(number));
    }
}

#[test]
fn robot_types_are_kept_by_their_names() {
    let folder = folder();
    let path = folder.path().join("orders.db");
    let open = |types: &[&str]| {
        let places = Places::new((10..14).map(|id| Place { id, ..Place::default() }).collect());
        let types = types.iter().map(|name| (*name).to_owned()).collect();
        OrderStore::open(&path, Arc::new(places.with_robot_types(types))).expect("a store")
    };
    let writer = Writer::start(open(&["amr", "forklift"])).expect("a thread");
    let for_forklifts = NewOrder { robot_types: vec![1], intended_robot: None, ..order("a") };
    insert(&writer, vec![for_forklifts]).expect("kept");
    drop(writer);
    let found = open(&["forklift", "amr"]).restore(1, 0.0).expect("read");
    assert_eq!(found.orders[0].content.robot_types, [0]);
    let found = open(&["amr"]).restore(1, 0.0).expect("read");
    assert_eq!((found.orders.len(), found.unplaced), (0, 1), "it stays in the store");
}
