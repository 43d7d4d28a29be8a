//! Opens the pool of a running manager with its files, its store and its web API.

use std::net::SocketAddr;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::mpsc::channel;

use clap::Args;
use regatta_plugin::tell;

use super::file::{FileError, read_orders};
use super::load::Load;
use super::places::Places;
use super::pool::{Known, OrderPool};
use super::store::{self, StoreError, Writer};
use super::threads::{Channels, Threads};
use super::web::{self, Web, WebError};

/// The groups of options in the help.
const ORDERS: &str = "Orders";
const WEB: &str = "Web API";

/// The sources of a manager's orders, and their store.
#[derive(Args, Clone, Debug, Default)]
pub struct OrderSettings {
    /// File of transport orders with times: CSV, XLSX, Parquet or YAML
    #[arg(long, value_name = "FILE", help_heading = ORDERS)]
    pub orders: Option<PathBuf>,
    /// YAML file with a load: generators of orders [default: that of the scenario, under `regatta
    /// run`]
    #[arg(long, value_name = "FILE", help_heading = ORDERS)]
    pub load: Option<PathBuf>,
    /// Seed of the load, instead of its own
    #[arg(long, value_name = "N", help_heading = ORDERS)]
    pub seed: Option<u64>,
    /// Keep orders in this SQLite file: they survive the manager [default: in memory]
    #[arg(long, value_name = "FILE", help_heading = ORDERS)]
    pub store: Option<PathBuf>,
    /// Serve orders over HTTP at this address, too; port 0 is any free one [default: only at a
    /// Unix socket of this user, which `regatta orders` finds]
    #[arg(long, value_name = "ADDRESS", help_heading = WEB)]
    pub http: Option<SocketAddr>,
    /// File with the token that requests to that address must have; addresses other than loopback
    /// need one [default: this user's token, which `regatta orders` finds]
    #[arg(long, value_name = "FILE", requires = "http", help_heading = WEB)]
    pub token_file: Option<PathBuf>,
    /// The Unix socket at which orders are served.
    #[arg(skip)]
    pub socket: Option<PathBuf>,
}

/// The error of opening a pool.
#[derive(Debug, thiserror::Error)]
pub enum PoolError {
    /// A file of orders or a load.
    #[error(transparent)]
    File(#[from] FileError),
    /// The store.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// The web API.
    #[error(transparent)]
    Web(#[from] WebError),
}

impl OrderSettings {
    /// Serves orders at the Unix socket of a fleet. Where there are none, or its name is too long,
    /// they are not served there.
    #[cfg(feature = "http")]
    pub fn serve_at_socket_of(&mut self, fleet: &regatta_plugin::FleetName) {
        if !cfg!(unix) {
            return;
        }
        match regatta_kit::server::socket_path(fleet, web::SERVICE) {
            Ok(path) => self.socket = Some(path),
            Err(error) => tell!("fleet-manager: orders can't be served at a Unix socket: {error}"),
        }
    }

    /// The file with the token that requests over TCP must have.
    pub fn token_place(&self) -> String {
        #[cfg(feature = "http")]
        if self.token_file.is_none()
            && let Ok(path) = regatta_kit::private::token_file()
        {
            return path.display().to_string();
        }
        self.token_file.iter().map(|path| path.display().to_string()).collect()
    }

    /// Checks that the web API can be served: this needs no world.
    ///
    /// # Errors
    /// [`WebError`] if the address needs a token or can't be listened on, or the token can't be
    /// read.
    pub fn check(&self) -> Result<(), WebError> {
        match self.http {
            Some(address) => web::check(address, self.token_file.as_deref()),
            None => Ok(()),
        }
    }
}

impl OrderPool {
    /// Opens the pool of a run: restores the store's open orders, reads the files, and starts the
    /// web API. `run_id` is that of the world; orders of the store continue where they were only in
    /// the same run.
    ///
    /// # Errors
    /// [`PoolError`] if a file is wrong, the store can't be used, or the address can't be listened
    /// on.
    pub fn open(
        settings: &OrderSettings,
        places: Arc<Places>,
        run_id: u64,
        now_secs: f64,
    ) -> Result<Self, PoolError> {
        let mut pool = Self::new(places.clone());
        let orders = settings.orders.as_deref().map(read_orders).transpose()?.unwrap_or_default();
        let load = settings.load.as_deref().map(|path| Load::read(path, &places)).transpose()?;
        let load = load.unwrap_or_default();
        let load = Load { seed: settings.seed.unwrap_or(load.seed), ..load };
        pool.set_storages(&load);
        let (store, known) = match &settings.store {
            Some(path) => pool.open_store(path, run_id, now_secs)?,
            None => (None, Known::default()),
        };
        if let Some(path) = &settings.orders {
            pool.add_new_orders(&orders, &known)
                .map_err(|error| FileError::Invalid { path: path.clone(), error })?;
        }
        pool.continue_load(&load, &known);
        pool.open_threads(settings, store, now_secs)?;
        Ok(pool)
    }

    fn open_store(
        &mut self,
        path: &std::path::Path,
        run_id: u64,
        now_secs: f64,
    ) -> Result<(Option<Writer>, Known), PoolError> {
        let (writer, restored) = store::open(path, self.places().clone(), run_id, now_secs)?;
        if restored.unplaced > 0 {
            let (count, path) = (restored.unplaced, path.display());
            tell!(
                "fleet-manager: {count} open orders of {path} name nodes that this world doesn't \
                 have; they stay in the file"
            );
        }
        self.restore(restored.orders, restored.next_id, now_secs);
        Ok((Some(writer), restored.known))
    }

    fn open_threads(
        &mut self,
        settings: &OrderSettings,
        store: Option<Writer>,
        now_secs: f64,
    ) -> Result<(), PoolError> {
        let (requests_in, requests) = channel();
        let mut threads = Threads { requests, web: None, store };
        if settings.http.is_some() || settings.socket.is_some() {
            let jobs = threads.store.as_ref().and_then(Writer::sender);
            let channels = Channels { jobs, requests: requests_in };
            threads.web = Some(Web::start(settings, self, now_secs, channels)?);
        }
        self.threads = Some(threads);
        Ok(())
    }
}
