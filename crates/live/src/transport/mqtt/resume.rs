//! What a program that comes back under its client id still knows: nothing.

use rumqttc::{
    MqttOptions, PersistedAckMode, PersistedSession, SessionStore, SessionStoreError,
    SessionStoreKey,
};
use std::pin::Pin;

/// What a store answers, at some time.
type Answer<'a, T> = Pin<Box<dyn Future<Output = Result<T, SessionStoreError>> + Send + 'a>>;

/// Has the client take up a session that an earlier run of this program began: the broker
/// then delivers what came in between. Nothing of what that run had under way is known
/// any more, and need not be: its tasks are sent again by other means.
#[derive(Debug)]
pub struct Resume {
    session: PersistedSession,
}

impl Resume {
    /// A beginning that fits `options`.
    pub fn new(options: &MqttOptions) -> Self {
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
    fn load<'a>(&'a self, _: &'a SessionStoreKey) -> Answer<'a, Option<PersistedSession>> {
        Box::pin(async { Ok(Some(self.session.clone())) })
    }

    fn save<'a>(&'a self, _: &'a SessionStoreKey, _: &'a PersistedSession) -> Answer<'a, ()> {
        Box::pin(async { Ok(()) })
    }

    fn clear<'a>(&'a self, _: &'a SessionStoreKey) -> Answer<'a, ()> {
        Box::pin(async { Ok(()) })
    }
}
