//! A whole page.

use maud::{DOCTYPE, Markup, PreEscaped, html};

/// One self-contained HTML page: a title, a lead, sections, and a footer that says where it came
/// from.
#[derive(Debug, Clone)]
pub struct Page {
    title: String,
    lead: String,
    sections: Vec<Markup>,
    footer: String,
}

impl Page {
    /// A page whose `lead` says the result in a sentence or two; `footer` names program, data and
    /// date.
    #[must_use]
    pub fn new(title: impl Into<String>, lead: impl Into<String>, footer: impl Into<String>) -> Self {
        Self { title: title.into(), lead: lead.into(), sections: Vec::new(), footer: footer.into() }
    }

    /// Adds a section.
    pub fn section(&mut self, heading: &str, content: Markup) {
        self.sections.push(html! { section { h2 { (heading) } (content) } });
    }

    /// The file's content.
    #[must_use]
    pub fn html(&self) -> String {
        html! {
            (DOCTYPE)
            html lang="en" {
                head {
                    meta charset="utf-8";
                    meta name="viewport" content="width=device-width, initial-scale=1";
                    title { (self.title) }
                    style { (PreEscaped(include_str!("style.css"))) }
                }
                body {
                    main {
                        h1 { (self.title) }
                        p.lead { (self.lead) }
                        @for section in &self.sections { (section) }
                        footer { (self.footer) }
                    }
                    script { (PreEscaped(include_str!("downloads.js"))) }
                }
            }
        }
        .into_string()
    }
}

/// Content for a place inside somebody else's page, such as a notebook: with as much style as it
/// needs, for itself alone.
#[must_use]
pub fn fragment(content: &Markup) -> Markup {
    html! { div.pneudrive { style { (PreEscaped(include_str!("fragment.css"))) } (content) } }
}

/// Details that a reader opens by its heading; printed in full.
#[must_use]
pub fn folded(heading: &str, content: &Markup) -> Markup {
    html! { details { summary { (heading) } (content) } }
}

/// A paragraph of plain text.
#[must_use]
pub fn paragraph(text: &str) -> Markup {
    html! { p { (text) } }
}

/// A paragraph of plain text in which what stands between backticks is code.
#[must_use]
pub fn with_code(text: &str) -> Markup {
    html! {
        p { @for (k, part) in text.split('`').enumerate() {
            @if k % 2 == 1 { code { (part) } } @else { (part) }
        } }
    }
}

/// A list of remarks; nothing when there are none.
#[must_use]
pub fn notes<T: AsRef<str>>(lines: &[T]) -> Markup {
    html! { @if !lines.is_empty() { ul.notes { @for line in lines { li { (line.as_ref()) } } } } }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn code_is_marked() {
        assert_eq!(with_code("play `a b` <now>").into_string(), "<p>play <code>a b</code> &lt;now&gt;</p>");
    }

    #[test]
    fn a_page_is_complete_escaped_and_asks_nobody() {
        let mut page = Page::new("A & B", "Lead <here>.", "made by a test");
        page.section("One", paragraph("x < y"));
        let html = page.html();
        assert!(html.starts_with("<!DOCTYPE html>") && html.ends_with("</html>"));
        assert!(
            html.contains("A &amp; B") && html.contains("Lead &lt;here&gt;.") && html.contains("x &lt; y")
        );
        for outside in ["href=", "src=", "@import", "url(", "http:", "https:", "fetch(", "XMLHttpRequest"] {
            assert!(!html.contains(outside), "{outside}");
        }
    }
}
