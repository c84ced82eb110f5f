//! Tables that scroll sideways by themselves when the screen is narrow.

use maud::{Markup, html};

/// How a column is set.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Align {
    /// Words.
    Left,
    /// Numbers.
    Right,
}

/// A table with one header row. Its cells are text or markup.
#[derive(Debug, Clone, Default)]
pub struct Table {
    caption: Option<String>,
    columns: Vec<(String, Align)>,
    rows: Vec<(bool, Vec<Markup>)>,
    stacked: bool,
}

impl Table {
    /// A table with these column heads (units belong in them).
    #[must_use]
    pub fn new(columns: &[(&str, Align)]) -> Self {
        let columns = columns.iter().map(|(head, align)| ((*head).to_owned(), *align)).collect();
        Self { caption: None, columns, rows: Vec::new(), stacked: false }
    }

    /// A sentence above the table.
    #[must_use]
    pub fn caption(mut self, text: impl Into<String>) -> Self {
        self.caption = Some(text.into());
        self
    }

    /// On a narrow screen each row becomes a list of its cells with their heads, instead of
    /// scrolling sideways.
    #[must_use]
    pub fn stacked(mut self) -> Self {
        self.stacked = true;
        self
    }

    /// Adds a row of plain cells.
    pub fn row<T: AsRef<str>>(&mut self, cells: impl IntoIterator<Item = T>) {
        self.rows.push((false, cells.into_iter().map(|cell| html! { (cell.as_ref()) }).collect()));
    }

    /// Adds a row that stands out: the best of its kind.
    pub fn highlighted_row<T: AsRef<str>>(&mut self, cells: impl IntoIterator<Item = T>) {
        self.rows.push((true, cells.into_iter().map(|cell| html! { (cell.as_ref()) }).collect()));
    }

    /// Adds a row whose cells are markup.
    pub fn markup_row(&mut self, cells: Vec<Markup>) {
        self.rows.push((false, cells));
    }

    /// The table as HTML.
    #[must_use]
    pub fn markup(&self) -> Markup {
        let class = |index: usize| match self.columns.get(index) {
            Some((_, Align::Right)) => "n",
            _ => "w",
        };
        let head = |index: usize| self.columns.get(index).filter(|_| self.stacked).map(|(head, _)| head);
        html! {
            @if let Some(caption) = &self.caption { p.caption { (caption) } }
            div.scroll tabindex="0" {
                table.stacked[self.stacked] {
                    thead { tr { @for (i, (head, _)) in self.columns.iter().enumerate() { th class=(class(i)) { (head) } } } }
                    tbody {
                        @for (best, cells) in &self.rows {
                            tr.best[*best] { @for (i, cell) in cells.iter().enumerate() { td class=(class(i)) data-head=[head(i)] { (cell) } } }
                        }
                    }
                }
            }
        }
    }

    /// The same table as lines of text for a terminal, columns aligned. Markup cells are left out.
    #[must_use]
    pub fn text(head: &[&str], rows: &[Vec<String>]) -> String {
        let width = |column: usize| {
            let cells = rows.iter().filter_map(|r| r.get(column)).map(|c| c.chars().count());
            cells.chain(head.get(column).map(|h| h.chars().count())).max().unwrap_or(0)
        };
        let widths: Vec<usize> = (0..head.len()).map(width).collect();
        let line = |cells: &[String]| {
            let mut text = String::new();
            for (column, (cell, width)) in cells.iter().zip(&widths).enumerate() {
                // Names to the left, numbers to the right.
                if column == 0 {
                    text.push_str(&format!("{cell:<width$}"));
                } else {
                    text.push_str(&format!("  {cell:>width$}"));
                }
            }
            text.trim_end().to_owned()
        };
        let head: Vec<String> = head.iter().map(|h| (*h).to_owned()).collect();
        std::iter::once(line(&head)).chain(rows.iter().map(|r| line(r))).collect::<Vec<_>>().join("\n")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_escaped_and_text_is_aligned() {
        let mut table = Table::new(&[("name", Align::Left), ("kPa", Align::Right)]);
        table.row(["a<b", "1.0"]);
        let html = table.markup().into_string();
        assert!(html.contains("a&lt;b") && html.contains(r#"<td class="n">1.0</td>"#), "{html}");
        let rows = [vec!["linear".to_owned(), "1.25".to_owned()], vec!["x".to_owned(), "10.5".to_owned()]];
        assert_eq!(Table::text(&["model", "kPa"], &rows), "model    kPa\nlinear  1.25\nx       10.5");
    }
}
