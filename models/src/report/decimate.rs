//! Fewer points that look the same.

/// Reduces a curve to at most two points for each of `columns` pixel columns between `from` and
/// `to`: the smallest and the largest value there, in their order in time. Breaks the curve where a
/// value is not finite; each returned piece is one unbroken line.
///
/// `points` must be ordered by their first coordinate.
#[must_use]
pub fn min_max(
    points: impl IntoIterator<Item = (f64, f64)>,
    (from, to): (f64, f64),
    columns: usize,
) -> Vec<Vec<(f64, f64)>> {
    let mut pieces = Vec::new();
    let mut piece = Piece::default();
    // A pixel count is far below 2^52.
    let per_column = columns as f64 / (to - from);
    for (x, y) in points {
        if !(x.is_finite() && y.is_finite()) {
            piece.finish(&mut pieces);
            continue;
        }
        if x < from || x > to {
            continue;
        }
        piece.add(((x - from) * per_column).floor(), (x, y));
    }
    piece.finish(&mut pieces);
    pieces
}

/// One unbroken line, and the pixel column that is being gathered.
#[derive(Default)]
struct Piece {
    done: Vec<(f64, f64)>,
    column: Option<Column>,
}

struct Column {
    number: f64,
    lowest: (f64, f64),
    highest: (f64, f64),
    /// Did the largest value come after the smallest? Of two at one time, as at the edge of a step,
    /// their order is that of the points.
    rises: bool,
}

impl Piece {
    fn add(&mut self, number: f64, point: (f64, f64)) {
        match &mut self.column {
            Some(column) if column.number.total_cmp(&number).is_eq() => {
                if point.1 < column.lowest.1 {
                    (column.lowest, column.rises) = (point, false);
                }
                if point.1 > column.highest.1 {
                    (column.highest, column.rises) = (point, true);
                }
            }
            _ => {
                self.flush();
                self.column = Some(Column { number, lowest: point, highest: point, rises: true });
            }
        }
    }

    fn flush(&mut self) {
        let Some(Column { lowest, highest, rises, .. }) = self.column.take() else { return };
        let (first, second) = if rises { (lowest, highest) } else { (highest, lowest) };
        self.done.push(first);
        if lowest.1 < highest.1 {
            self.done.push(second);
        }
    }

    fn finish(&mut self, pieces: &mut Vec<Vec<(f64, f64)>>) {
        self.flush();
        if !self.done.is_empty() {
            pieces.push(std::mem::take(&mut self.done));
        }
    }
}

/// Thins a cloud of points to at most one per cell of a `columns` by `rows` grid over the given
/// ranges. Points outside are dropped.
#[must_use]
pub fn thin(
    points: impl IntoIterator<Item = (f64, f64)>,
    (x_from, x_to): (f64, f64),
    (y_from, y_to): (f64, f64),
    (columns, rows): (usize, usize),
) -> Vec<(f64, f64)> {
    let mut taken = vec![false; columns * rows];
    let place = |value: f64, from: f64, to: f64, cells: usize| {
        let share = (value - from) / (to - from);
        // Inside 0 to 1, so the cast cannot overflow.
        (0.0..=1.0).contains(&share).then(|| ((share * cells as f64) as usize).min(cells - 1))
    };
    points
        .into_iter()
        .filter(|&(x, y)| {
            let cell = place(x, x_from, x_to, columns).zip(place(y, y_from, y_to, rows));
            cell.is_some_and(|(column, row)| !std::mem::replace(&mut taken[row * columns + column], true))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spike_survives_and_the_count_is_bounded() {
        let points =
            (0..1_000_000).map(|k| (f64::from(k), if k == 123_456 { 9.0 } else { f64::from(k % 2) }));
        let pieces = min_max(points, (0.0, 1e6), 500);
        assert_eq!(pieces.len(), 1);
        assert!(pieces[0].len() <= 1001);
        assert!(pieces[0].contains(&(123_456.0, 9.0)));
        assert!(pieces[0].windows(2).all(|w| w[0].0 < w[1].0), "time runs forward");
    }

    #[test]
    fn a_step_is_as_high_as_it_was() {
        let steps = [0.0, 1.0, 0.0, 3.0].iter().enumerate();
        let edges = |(second, count): (usize, &f64)| [(second as f64, *count), (second as f64 + 1.0, *count)];
        let corners: Vec<(f64, f64)> = steps.flat_map(edges).collect();
        assert_eq!(min_max(corners.clone(), (0.0, 4.0), 400), [corners]);
    }

    #[test]
    fn missing_values_break_the_line() {
        let points = [(0.0, 1.0), (1.0, 2.0), (2.0, f64::NAN), (3.0, 3.0)];
        assert_eq!(min_max(points, (0.0, 3.0), 100), [vec![(0.0, 1.0), (1.0, 2.0)], vec![(3.0, 3.0)]]);
    }

    #[test]
    fn a_cloud_keeps_one_point_per_cell() {
        let points = (0..10_000).map(|k| (f64::from(k % 100), f64::from(k / 100)));
        assert_eq!(thin(points, (0.0, 100.0), (0.0, 100.0), (10, 10)).len(), 100);
        assert_eq!(thin([(5.0, f64::NAN), (-1.0, 0.0)], (0.0, 10.0), (0.0, 1.0), (4, 4)), []);
    }
}
