//! The session store of a program that reconnects under its client id: empty.

use rumqttc::{
    MqttOptions, PersistedAckMode, PersistedSession, SessionStore, SessionStoreError,
    SessionStoreKey,
};
use std::pin::Pin;

/// The future answer of a store.
type StoreFuture<'a, T> = Pin<Box<dyn Future<Output = Result<T, SessionStoreError>> + Send + 'a>>;

/// Makes the client resume a session of an earlier run of this program, so that the broker delivers
/// the messages since then. What that run had in transit is not known and not needed, because its
/// tasks are sent again by other means.
#[derive(Debug)]
pub(crate) struct Resume {
    session: PersistedSession,
}

impl Resume {
    /// A store that fits `options`.
    pub(crate) fn new(options: &MqttOptions) -> Self {
        Self {
            session: PersistedSession {
                format_version: 1,
                client_id: options.client_id(),
                clean_start: false,
                session_expiry_interval: options.session_expiry_interval(),
                outgoing_inflight_upper_limit: options.get_outgoing_inflight_upper_limit(),
                ack_mode: PersistedAckMode::Manual,
                last_pkid: 0,
                last_puback: 0,
                replay: Vec::new(),
                incoming_qos2: Vec::new(),
            },
        }
    }
}

impl SessionStore for Resume {
    fn load<'a>(&'a self, _: &'a SessionStoreKey) -> StoreFuture<'a, Option<PersistedSession>> {
        Box::pin(async { Ok(Some(self.session.clone())) })
    }

    fn save<'a>(&'a self, _: &'a SessionStoreKey, _: &'a PersistedSession) -> StoreFuture<'a, ()> {
        Box::pin(async { Ok(()) })
    }

    fn clear<'a>(&'a self, _: &'a SessionStoreKey) -> StoreFuture<'a, ()> {
        Box::pin(async { Ok(()) })
    }
}
