//! A file that is still being written: its end is not the end.

use std::cell::Cell;
use std::io::{self, Read};
use std::rc::Rc;

/// Bytes of a line that are looked at.
const LOOKED_AT: usize = 256;

/// Waits at the end of what there is; `wait` returns whether to look again.
pub(crate) struct Follow<R> {
    inner: R,
    wait: Box<dyn FnMut() -> bool>,
    ended: Rc<Cell<bool>>,
}

/// Passes a recording's text on, and notices the event that ends it.
pub(crate) struct EndNotice<R> {
    inner: R,
    line: Vec<u8>,
    ended: Rc<Cell<bool>>,
}

/// Follows `stored`; whoever decodes it hands the text to the [`EndNotice`] that belongs to it.
pub(crate) fn follow<R>(stored: R, wait: Box<dyn FnMut() -> bool>) -> (Follow<R>, Rc<Cell<bool>>) {
    let ended = Rc::new(Cell::new(false));
    (Follow { inner: stored, wait, ended: Rc::clone(&ended) }, ended)
}

impl<R> EndNotice<R> {
    pub(crate) fn new(text: R, ended: Rc<Cell<bool>>) -> Self {
        Self { inner: text, line: Vec::new(), ended }
    }
}

impl<R: Read> Read for Follow<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        loop {
            let read = self.inner.read(buffer)?;
            if read > 0 || buffer.is_empty() || self.ended.get() || !(self.wait)() {
                return Ok(read);
            }
        }
    }
}

impl<R: Read> Read for EndNotice<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let read = self.inner.read(buffer)?;
        for byte in &buffer[..read] {
            if *byte == b'\n' {
                self.ended.set(self.ended.get() || is_end(&self.line));
                self.line.clear();
            } else if self.line.len() < LOOKED_AT {
                self.line.push(*byte);
            }
        }
        Ok(read)
    }
}

fn is_end(line: &[u8]) -> bool {
    const KIND: &[u8] = b"\"kind\":\"end\"";
    line.starts_with(b"# event: ") && line.windows(KIND.len()).any(|part| part == KIND)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A file that grows by one piece each time that its end was met.
    struct Growing(Vec<&'static [u8]>, bool);

    impl Read for Growing {
        fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
            self.1 = !self.1;
            if self.1 || self.0.is_empty() {
                return Ok(0);
            }
            let (now, later) = self.0[0].split_at(self.0[0].len().min(buffer.len()));
            buffer[..now.len()].copy_from_slice(now);
            if later.is_empty() {
                self.0.remove(0);
            } else {
                self.0[0] = later;
            }
            Ok(now.len())
        }
    }

    fn read_all(pieces: Vec<&'static [u8]>, waits: usize) -> String {
        let mut left = waits;
        let wait = move || {
            left = left.saturating_sub(1);
            left > 0
        };
        let (stored, ended) = follow(Growing(pieces, false), Box::new(wait));
        let mut text = String::new();
        EndNotice::new(stored, ended).read_to_string(&mut text).unwrap();
        text
    }

    #[test]
    fn it_goes_on_until_the_recording_says_that_it_has_ended() {
        let pieces: Vec<&[u8]> = vec![
            b"t_s,b0_p0_kpa\n0,",
            b"1\n# event: {\"t_s\":1,\"ki",
            b"nd\":\"end\",\"text\":\"\"}\n",
            b"more",
        ];
        assert!(read_all(pieces, 100).ends_with("\"text\":\"\"}\n"));
    }

    #[test]
    fn an_end_in_the_words_of_another_event_is_none() {
        let pieces: Vec<&[u8]> = vec![b"# event: {\"kind\":\"key\",\"text\":\"end\"}\n", b"0,1\n"];
        assert!(read_all(pieces, 100).ends_with("0,1\n"));
    }

    #[test]
    fn whoever_waits_can_stop() {
        assert_eq!(read_all(vec![b"0,1\n", b"1,1\n", b"2,1\n"], 2), "0,1\n");
    }
}
