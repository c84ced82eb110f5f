//! Work shared between the cores of the processor.
//!
//! The one place that is compiled against rayon: an iterator of rayon's was some 2000 lines of
//! LLVM's code (`cargo llvm-lines`) at each of 91 places.

use rayon::prelude::*;
use std::sync::{Mutex, PoisonError};

/// Results of `work` on all items, in their order, on all threads of the current rayon pool.
/// Nothing but the time that it takes depends on the number of threads. For items that take
/// microseconds or more.
pub fn map<T: Send, R: Send>(items: impl IntoIterator<Item = T>, work: impl Fn(T) -> R + Sync) -> Vec<R> {
    let places: Vec<Mutex<Place<T, R>>> =
        items.into_iter().map(|item| Mutex::new(Place::Waiting(item))).collect();
    each(places.len(), &|k| {
        let mut place = places[k].lock().unwrap_or_else(PoisonError::into_inner);
        if let Place::Waiting(item) = std::mem::replace(&mut *place, Place::Taken) {
            *place = Place::Done(work(item));
        }
    });
    let done = places.into_iter().map(|place| place.into_inner().unwrap_or_else(PoisonError::into_inner));
    done.filter_map(|place| if let Place::Done(result) = place { Some(result) } else { None }).collect()
}

enum Place<T, R> {
    Waiting(T),
    Taken,
    Done(R),
}

fn each(count: usize, work: &(dyn Fn(usize) + Sync)) {
    (0..count).into_par_iter().for_each(work);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_are_in_the_order_of_the_items() {
        let squares = map(0..1000_u64, |k| map(0..k % 7, move |_| k).iter().sum::<u64>());
        assert!(squares.iter().zip(0..).all(|(&sum, k)| sum == k * (k % 7)));
    }

    #[test]
    fn parts_of_a_slice_are_written_side_by_side() {
        let mut rows = vec![0_usize; 10];
        let lengths = map(rows.chunks_mut(3).enumerate(), |(k, part)| {
            part.fill(k);
            part.len()
        });
        assert_eq!((rows, lengths), (vec![0, 0, 0, 1, 1, 1, 2, 2, 2, 3], vec![3, 3, 3, 1]));
    }

    #[test]
    #[should_panic(expected = "the fourth")]
    fn a_panic_reaches_the_caller() {
        map(0..8, |k| assert!(k != 3, "the fourth"));
    }
}
