//! The thread that writes to the store, many changes in one commit.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::Duration;

use parking_lot::{Condvar, Mutex};
use regatta_plugin::tell;
use rusqlite::{ErrorCode, Transaction, params};

use super::OrderStore;
use super::row::{stop_rows, types_column};
use crate::order::{NewOrder, Order, OrderName};
use crate::places::Places;
use crate::threads::{InsertError, Job, Reply};

/// The largest number of jobs in a commit.
const MAX_JOBS: usize = 4_096;
/// The delay after a commit failed: the disk may have room again.
const RETRY_DELAY: Duration = Duration::from_secs(1);
/// The longest time to wait for the changes of a tick: a disk that hangs doesn't end the work.
const LONGEST_WAIT: Duration = Duration::from_secs(2);

/// The updates that the thread has not written yet.
#[derive(Default)]
struct Progress {
    unsaved: Mutex<Unsaved>,
    changed: Condvar,
}

#[derive(Default)]
struct Unsaved {
    updates: usize,
    /// Whether the last commit failed, so that nobody knows when the next one succeeds.
    has_failed: bool,
}

/// The handle of the thread. Dropping it waits until all jobs are done or have failed.
pub(crate) struct Writer {
    jobs: Option<Sender<Job>>,
    progress: Arc<Progress>,
    thread: Option<JoinHandle<()>>,
}

impl Writer {
    /// Starts the thread.
    pub(super) fn start(store: OrderStore) -> std::io::Result<Self> {
        let (jobs, receiver) = channel();
        let progress = Arc::new(Progress::default());
        let mut thread = Thread {
            store,
            pending: BTreeMap::new(),
            replies: Vec::new(),
            progress: progress.clone(),
            taken: 0,
        };
        let thread = std::thread::Builder::new()
            .name("order-store".to_owned())
            .spawn(move || thread.run(&receiver))?;
        Ok(Self { jobs: Some(jobs), progress, thread: Some(thread) })
    }

    /// Returns a way to send jobs from other threads.
    pub(crate) fn sender(&self) -> Option<Sender<Job>> {
        self.jobs.clone()
    }

    /// Sends orders to be written, without waiting.
    pub(crate) fn update(&self, orders: Vec<Arc<Order>>, done: Vec<Reply<()>>) {
        if let Some(jobs) = &self.jobs
            && !(orders.is_empty() && done.is_empty())
        {
            self.progress.unsaved.lock().updates += 1;
            // The thread ends only after this sender.
            let _ = jobs.send(Job::Update { orders, done });
        }
    }

    /// Waits until all updates are written, but not for a store that can't be written to, nor
    /// longer than [`LONGEST_WAIT`]. Returns whether they are.
    pub(crate) fn settle(&self) -> bool {
        let mut unsaved = self.progress.unsaved.lock();
        self.progress.changed.wait_while_for(
            &mut unsaved,
            |unsaved| unsaved.updates > 0 && !unsaved.has_failed,
            LONGEST_WAIT,
        );
        unsaved.updates == 0
    }
}

impl Drop for Writer {
    fn drop(&mut self) {
        self.jobs = None;
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

struct Thread {
    store: OrderStore,
    /// Updates that aren't written yet: the newest of each order.
    pending: BTreeMap<OrderName, Arc<Order>>,
    replies: Vec<Reply<()>>,
    progress: Arc<Progress>,
    /// The number of updates in `pending`.
    taken: usize,
}

type Insertion = (Vec<NewOrder>, f64, Reply<Result<(), InsertError>>);

impl Thread {
    fn run(&mut self, jobs: &Receiver<Job>) {
        loop {
            let first = match self.taken == 0 {
                true => jobs.recv().map_err(|_| RecvTimeoutError::Disconnected),
                false => jobs.recv_timeout(RETRY_DELAY),
            };
            let is_end = matches!(first, Err(RecvTimeoutError::Disconnected));
            let batch = first.into_iter().chain(jobs.try_iter()).take(MAX_JOBS).collect();
            self.write(batch);
            if is_end {
                return;
            }
        }
    }

    fn write(&mut self, batch: Vec<Job>) {
        let mut insertions = Vec::new();
        for job in batch {
            match job {
                Job::Insert { orders, created_secs, done } => {
                    insertions.push((orders, created_secs, done))
                }
                Job::Update { orders, done } => {
                    self.pending.extend(
                        orders.into_iter().map(|order| (order.content.name.clone(), order)),
                    );
                    self.replies.extend(done);
                    self.taken += 1;
                }
            }
        }
        if insertions.is_empty() && self.taken == 0 {
            return;
        }
        let result = self.commit(&insertions);
        self.report(result.as_ref().err());
        if result.is_ok() {
            self.pending.clear();
            for reply in self.replies.drain(..) {
                reply(());
            }
        }
        answer(insertions, result);
    }

    /// Writes everything in one transaction. Returns the result of each insertion.
    fn commit(
        &mut self,
        insertions: &[Insertion],
    ) -> rusqlite::Result<Vec<Result<(), InsertError>>> {
        let mut transaction = self.store.connection.transaction()?;
        let mut results = Vec::with_capacity(insertions.len());
        for (orders, created_secs, _) in insertions {
            results.push(insert_all(&mut transaction, orders, *created_secs, &self.store.places)?);
        }
        for order in self.pending.values() {
            upsert(&transaction, order, &self.store.places)?;
        }
        transaction.commit()?;
        Ok(results)
    }

    /// Tells those who wait how it went, and the user once when writing fails, and once when it
    /// works again.
    fn report(&mut self, error: Option<&rusqlite::Error>) {
        let path = self.store.path.display();
        let mut unsaved = self.progress.unsaved.lock();
        let had_failed = std::mem::replace(&mut unsaved.has_failed, error.is_some());
        if error.is_none() {
            unsaved.updates -= std::mem::take(&mut self.taken);
        }
        drop(unsaved);
        self.progress.changed.notify_all();
        match error {
            Some(error) if !had_failed => tell!(
                "fleet-manager: can't write to {path} ({}); acknowledged orders are kept, new ones \
                 are refused",
                cause(error)
            ),
            None if had_failed => tell!("fleet-manager: writing to {path} works again"),
            _ => {}
        }
    }
}

fn answer(insertions: Vec<Insertion>, result: rusqlite::Result<Vec<Result<(), InsertError>>>) {
    match result {
        Ok(results) => {
            for ((_, _, done), result) in insertions.into_iter().zip(results) {
                done(result);
            }
        }
        Err(error) => {
            let error = InsertError::Write(cause(&error));
            for (_, _, done) in insertions {
                done(Err(error.clone()));
            }
        }
    }
}

fn cause(error: &rusqlite::Error) -> String {
    match error.sqlite_error_code() {
        Some(ErrorCode::DiskFull) => "the disk is full".to_owned(),
        _ => error.to_string(),
    }
}

/// Inserts all orders, or none if one of them is there already.
fn insert_all(
    transaction: &mut Transaction,
    orders: &[NewOrder],
    created_secs: f64,
    places: &Places,
) -> rusqlite::Result<Result<(), InsertError>> {
    let savepoint = transaction.savepoint()?;
    for order in orders {
        let inserted = savepoint
            .prepare_cached(
                "INSERT INTO transport_order
                (name, state, priority, created, earliest, deadline, handled_stops, reason, stops,
                 history, intended_robot, robot_types)
             VALUES (?, 'created', ?, ?, ?, ?, 0, '', ?, '[]', ?, ?)",
            )?
            .execute(params![
                order.name.as_str(),
                order.priority,
                created_secs,
                order.earliest_secs,
                order.deadline_secs,
                stop_rows(&order.stops, places),
                order.intended_robot,
                types_column(&order.robot_types, places),
            ]);
        match inserted {
            Err(error) if error.sqlite_error_code() == Some(ErrorCode::ConstraintViolation) => {
                // Dropped, the savepoint is rolled back.
                return Ok(Err(InsertError::Duplicate(order.name.clone())));
            }
            other => other?,
        };
    }
    savepoint.commit()?;
    Ok(Ok(()))
}

fn upsert(transaction: &Transaction, order: &Order, places: &Places) -> rusqlite::Result<usize> {
    let content = &order.content;
    let history = serde_json::to_string(&order.history).unwrap_or_else(|_| "[]".to_owned());
    transaction
        .prepare_cached(
            "INSERT INTO transport_order
                (name, id, state, priority, created, earliest, deadline, robot, handled_stops,
                 reason, stops, history, intended_robot, robot_types)
             VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11, ?12, ?13, ?14)
             ON CONFLICT (name) DO UPDATE SET id = ?2, state = ?3, created = ?5, earliest = ?6,
                deadline = ?7, robot = ?8, handled_stops = ?9, reason = ?10, history = ?12",
        )?
        .execute(params![
            content.name.as_str(),
            order.id.0,
            order.state.name(),
            content.priority,
            order.created_secs,
            content.earliest_secs,
            content.deadline_secs,
            order.state.robot(),
            order.handled_stops,
            order.reason,
            stop_rows(&content.stops, places),
            history,
            content.intended_robot,
            types_column(&content.robot_types, places),
        ])
}
