//! How many clients there are.

use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::time::Duration;

/// Counts connections, up to a limit.
#[derive(Debug, Clone)]
pub(super) struct Connections {
    shared: Arc<(Mutex<usize>, Condvar)>,
    most: usize,
}

/// One of them, until dropped.
#[derive(Debug)]
pub(super) struct Place(Connections);

impl Connections {
    pub(super) fn new(most: usize) -> Self {
        Self { shared: Arc::default(), most }
    }

    /// A place, if there is one.
    pub(super) fn place(&self) -> Option<Place> {
        let mut count = self.shared.0.lock().unwrap_or_else(PoisonError::into_inner);
        if *count >= self.most {
            return None;
        }
        *count += 1;
        Some(Place(self.clone()))
    }

    /// Waits until nobody is left, but not for ever.
    pub(super) fn wait_until_none(&self, patience: Duration) {
        let (count, changed) = &*self.shared;
        let count = count.lock().unwrap_or_else(PoisonError::into_inner);
        // Whoever has not gone by then is left behind.
        let _ = changed.wait_timeout_while(count, patience, |count| *count > 0);
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        let (count, changed) = &*self.0.shared;
        *count.lock().unwrap_or_else(PoisonError::into_inner) -= 1;
        changed.notify_all();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_limited_and_come_back() {
        let connections = Connections::new(2);
        let (one, two) = (connections.place(), connections.place());
        assert!(one.is_some() && two.is_some() && connections.place().is_none());
        drop(one);
        assert!(connections.place().is_some());
    }
}
