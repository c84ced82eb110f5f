use std::fmt;

/// The first bytes that came in an exchange, for error messages.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct HeardBytes {
    first: [u8; Self::KEPT],
    count: usize,
}

impl HeardBytes {
    /// An echo and an answer, and a few more.
    const KEPT: usize = 24;

    pub(super) fn push(&mut self, byte: u8) {
        if let Some(slot) = self.first.get_mut(self.count) {
            *slot = byte;
        }
        self.count = self.count.saturating_add(1);
    }

    /// How many came in all.
    pub fn count(&self) -> usize {
        self.count
    }

    /// The first of them, at most 24.
    pub fn first(&self) -> &[u8] {
        &self.first[..self.count.min(Self::KEPT)]
    }
}

impl Extend<u8> for HeardBytes {
    fn extend<T: IntoIterator<Item = u8>>(&mut self, bytes: T) {
        bytes.into_iter().for_each(|byte| self.push(byte));
    }
}

impl fmt::Display for HeardBytes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let unit = if self.count == 1 { "byte" } else { "bytes" };
        write!(f, "{} {unit} (", self.count)?;
        for (index, byte) in self.first().iter().enumerate() {
            write!(f, "{}{byte:02X}", if index == 0 { "" } else { " " })?;
        }
        f.write_str(if self.count > Self::KEPT { " ..)" } else { ")" })
    }
}

#[cfg(test)]
mod tests {
    use super::HeardBytes;

    #[test]
    fn many_bytes_are_cut_short_but_counted() {
        let mut heard = HeardBytes::default();
        heard.extend([0xFF, 0x03]);
        assert_eq!(heard.to_string(), "2 bytes (FF 03)");
        heard.extend([0; 40]);
        assert_eq!(heard.count(), 42);
        assert!(heard.to_string().ends_with(" 00 ..)"), "{heard}");
    }
}
