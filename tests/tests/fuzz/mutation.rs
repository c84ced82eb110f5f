//! Damage to a file that was good: what a fuzzer's bytes mean to a format that random bytes never
//! get into.

/// What has meaning in one of the formats, and what is at the edge of having one.
const WORDS: &[&str] = &[
    "t_s",
    "b0_cmd0_kpa",
    "b0_p0_kpa",
    "b0_u0",
    "supply_kpa",
    "b255_p3_kpa",
    "NaN",
    "inf",
    "-inf",
    "1e999",
    "1e300",
    "-1e300",
    "5e-324",
    "-1",
    "0",
    "-0.0",
    "1e-320",
    "18446744073709551616",
    "9007199254740993",
    "0.1",
    "1e9",
    ",",
    "\n",
    "\r\n",
    "\"",
    "\"\"",
    ";",
    "\t",
    "\u{feff}",
    "[",
    "]",
    "=",
    "[[",
    "#",
    "\0",
    "\u{e9}",
    "true",
    "{",
    "}",
    "'''",
    "_",
    "1_0",
    "0x10",
];

/// What `script` makes of a good file: its first byte decides between anything at all and one to
/// four edits. After more the file is refused for the first of them, and the rest of the loader is
/// not reached.
pub fn contents(seed: &[u8], script: &[u8]) -> Vec<u8> {
    match script {
        [0..16, anything @ ..] => anything.to_vec(),
        [few, edits @ ..] => mutated(seed, &edits[..edits.len().min(4 + 4 * usize::from(few % 4))]),
        [] => seed.to_vec(),
    }
}

/// `seed` after the edits that `script` stands for: four bytes each.
fn mutated(seed: &[u8], script: &[u8]) -> Vec<u8> {
    let mut text = seed.to_vec();
    for edit in script.chunks_exact(4) {
        let at = usize::from(u16::from_le_bytes([edit[1], edit[2]])) % (text.len() + 1);
        let length = usize::from(edit[3]).min(text.len() - at);
        match edit[0] % 8 {
            0 => text.truncate(at),
            1 => drop(text.drain(at..at + length)),
            2 => {
                let copy = text[at..at + length].to_vec();
                text.splice(at..at, copy);
            }
            3 => {
                if let Some(byte) = text.get_mut(at) {
                    *byte = edit[3];
                }
            }
            4 => {
                if let Some(byte) = text.get_mut(at) {
                    *byte ^= 1 << (edit[3] % 8);
                }
            }
            5 => {
                let word = WORDS[usize::from(edit[3]) % WORDS.len()];
                text.splice(at..at, word.bytes());
            }
            6 => {
                // In place of the cell or value that stands there.
                let word = WORDS[usize::from(edit[3]) % WORDS.len()];
                let ends = |byte: &u8| b",\n= ".contains(byte);
                let end = text[at..].iter().position(ends).map_or(text.len(), |n| at + n);
                text.splice(at..end, word.bytes());
            }
            _ => {
                let lines = text[at..].iter().position(|&byte| byte == b'\n').map(|n| at + n + 1);
                if let Some(end) = lines {
                    text.drain(at..end);
                }
            }
        }
    }
    text.truncate(1 << 16);
    text
}
