//! Lists put in the order of a number. The standard library's sort is compiled again for each
//! comparison; here it is compiled once.

/// Least first; equals stay in their order. NaN counts as in [`f64::total_cmp`].
pub(crate) fn ascending<T>(list: &mut [T], key: impl Fn(&T) -> f64) {
    permute(list, order(list.iter().map(key).collect()));
}

/// Greatest first; equals stay in their order. NaN counts as in [`f64::total_cmp`].
pub(crate) fn descending<T>(list: &mut [T], key: impl Fn(&T) -> f64) {
    // Changing the sign turns the total order round.
    permute(list, order(list.iter().map(|item| -key(item)).collect()));
}

/// Which item comes first, second, ..
fn order(keys: Vec<f64>) -> Vec<usize> {
    let mut order: Vec<usize> = (0..keys.len()).collect();
    order.sort_by(|&a, &b| keys[a].total_cmp(&keys[b]));
    order
}

/// Item `from[k]` becomes item k.
fn permute<T>(list: &mut [T], from: Vec<usize>) {
    for place in 0..list.len() {
        // Items before `place` are where they belong; what stood there has been swapped to where
        // its successor came from.
        let mut source = from[place];
        while source < place {
            source = from[source];
        }
        list.swap(place, source);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_what_a_stable_sort_does() {
        // Every list of five numbers of three, with equals and in every order.
        for list in 0..3_usize.pow(5) {
            let items: Vec<(u32, f64)> =
                (0..5).map(|k| (k, (list / 3_usize.pow(k) % 3) as f64 - 1.0)).collect();
            let (mut up, mut sorted) = (items.clone(), items.clone());
            ascending(&mut up, |item| item.1);
            sorted.sort_by(|a, b| a.1.total_cmp(&b.1));
            assert_eq!(up, sorted);
            let (mut down, mut sorted) = (items.clone(), items);
            descending(&mut down, |item| item.1);
            sorted.sort_by(|a, b| b.1.total_cmp(&a.1));
            assert_eq!(down, sorted);
        }
    }
}
