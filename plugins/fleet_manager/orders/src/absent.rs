//! Stands in for the store and the web API in programs that are built without them: opening one is
//! an error.

#[cfg(not(feature = "store"))]
pub mod store {
    //! The store of orders, which needs the feature `store`.

    use std::path::{Path, PathBuf};
    use std::sync::Arc;
    use std::sync::mpsc::Sender;

    use crate::order::Order;
    use crate::places::Places;
    use crate::pool::Restored;
    use crate::threads::{Job, Reply};

    /// The error of using a store.
    #[derive(Debug, thiserror::Error)]
    pub enum StoreError {
        /// The feature `store` is off.
        #[error("can't keep orders in {}: this program was built without the feature `store`", .0.display())]
        Missing(PathBuf),
    }

    /// A writer that doesn't exist.
    pub(crate) enum Writer {}

    impl Writer {
        pub(crate) fn sender(&self) -> Option<Sender<Job>> {
            match *self {}
        }

        pub(crate) fn update(&self, _: Vec<Arc<Order>>, _: Vec<Reply<()>>) {
            match *self {}
        }

        pub(crate) fn settle(&self) -> bool {
            match *self {}
        }
    }

    pub(crate) fn open(
        path: &Path,
        _: Arc<Places>,
        _run_id: u64,
        _now_secs: f64,
    ) -> Result<(Writer, Restored), StoreError> {
        Err(StoreError::Missing(path.to_owned()))
    }

    #[cfg(feature = "http")]
    pub(crate) use archive::Archive;

    #[cfg(feature = "http")]
    mod archive {
        use super::{Arc, Path, Places, StoreError};
        use crate::order::OrderName;
        use crate::view::{Page, TransportOrder};

        /// Stored orders that don't exist.
        pub(crate) enum Archive {}

        impl Archive {
            pub(crate) fn open(path: &Path, _: Arc<Places>) -> Result<Self, StoreError> {
                Err(StoreError::Missing(path.to_owned()))
            }

            pub(crate) fn order(
                &self,
                _: &OrderName,
            ) -> Result<Option<TransportOrder>, StoreError> {
                match *self {}
            }

            pub(crate) fn names(
                &self,
                _: &Page,
                _: impl Fn(&OrderName) -> bool,
            ) -> Result<Vec<OrderName>, StoreError> {
                match *self {}
            }

            pub(crate) fn last_number(&self) -> Result<u64, StoreError> {
                match *self {}
            }
        }
    }
}

#[cfg(not(feature = "http"))]
pub mod web {
    //! Orders over HTTP, which need the feature `http`.

    use std::net::SocketAddr;
    use std::path::Path;

    use crate::open::OrderSettings;
    use crate::pool::OrderPool;
    use crate::threads::{Channels, Update};

    /// The error of serving the web API.
    #[derive(Debug, thiserror::Error)]
    pub enum WebError {
        /// The feature `http` is off.
        #[error("can't serve orders: this program was built without the feature `http`")]
        Missing,
    }

    pub(crate) fn check(_: SocketAddr, _: Option<&Path>) -> Result<(), WebError> {
        Err(WebError::Missing)
    }

    /// A web API that doesn't exist.
    pub(crate) enum Web {}

    impl Web {
        pub(crate) fn start(
            _: &OrderSettings,
            _: &OrderPool,
            _now_secs: f64,
            _: Channels,
        ) -> Result<Self, WebError> {
            Err(WebError::Missing)
        }

        pub(crate) fn publish(&self, _: Update) {
            match *self {}
        }

        pub(crate) fn address(&self) -> Option<SocketAddr> {
            match *self {}
        }
    }
}
