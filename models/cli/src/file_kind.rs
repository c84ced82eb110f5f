//! What a file is that cannot be read as what it was given for: whoever mixes up two arguments is
//! not told what is wrong with line 1.

use std::fs::File;
use std::io::Read as _;
use std::path::Path;

use pneudrive_model::rig::Rig;

use super::Failure;

/// What this program reads and writes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FileKind {
    /// Rows of pressures and commands.
    Recording,
    /// The description of a rig.
    Rig,
    /// What `fit` and `diagnose` found, as TOML.
    Parameters,
    /// What commands say as JSON, too.
    Results,
}

impl FileKind {
    /// What the file at `path` begins like; nothing where that is none of these.
    fn of(path: &Path) -> Option<Self> {
        /// Ours say what they are within it; rig files are shorter.
        const BEGINNING: u64 = 64 * 1024;
        const COMPRESSED_OR_BAG: [&[u8]; 3] = [&[0x1f, 0x8b], &[0x28, 0xb5, 0x2f, 0xfd], b"\x89MCAP"];
        let mut begins = Vec::new();
        File::open(path).ok()?.take(BEGINNING).read_to_end(&mut begins).ok()?;
        if COMPRESSED_OR_BAG.iter().any(|magic| begins.starts_with(magic)) {
            return Some(Self::Recording);
        }
        let text = String::from_utf8_lossy(&begins);
        let mut lines = text.lines().map(str::trim).filter(|line| !line.is_empty() && !line.starts_with('#'));
        let first = lines.next()?;
        match first {
            "{" => text.contains("\"schema\"").then_some(Self::Results),
            _ if first.split(',').any(|name| name.trim() == "t_s") => Some(Self::Recording),
            _ if first.starts_with("schema = \"pneudrive-") => Some(Self::Parameters),
            _ => Rig::parse("", &text).is_ok_and(|rig| rig != Rig::default()).then_some(Self::Rig),
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Recording => "a recording",
            Self::Rig => "a rig file",
            Self::Parameters => "a parameter file",
            Self::Results => "a command's results",
        }
    }

    /// Where it belongs, to be said behind its name.
    fn place(self) -> &'static str {
        match self {
            Self::Recording => "",
            Self::Rig => ", which --rig takes",
            Self::Parameters => ", which `simulate --parameters` and `diagnose --reference` take",
            Self::Results => "; parameters are in the .toml, rows in the .csv of the same name",
        }
    }

    /// Who writes one, to be said where there is none.
    fn maker(self) -> Option<&'static str> {
        match self {
            Self::Rig => Some("`pneudrive-host init` writes a rig file"),
            Self::Parameters => Some("`fit --out` and `diagnose` write a parameter file"),
            Self::Recording | Self::Results => None,
        }
    }

    /// The failure to read the file at `path` as this: `error`, or that it is something else.
    pub fn refused(self, path: &Path, error: impl Into<Failure>) -> Failure {
        match Self::of(path).filter(|found| *found != self) {
            Some(found) => {
                let (path, place) = (path.display(), found.place());
                let (expected, found) = (self.name(), found.name());
                Failure::input(format!("{path}: expected {expected}, and this is {found}{place}"))
            }
            None => match self.maker().filter(|_| !path.exists()) {
                Some(maker) => Failure::input(format!("{}; {maker}", error.into())),
                None => error.into(),
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_told_by_how_they_begin() {
        let folder = tempfile::tempdir().expect("a folder for the test");
        let kind = |content: &[u8]| {
            let path = folder.path().join("file");
            std::fs::write(&path, content).expect("the folder can be written");
            FileKind::of(&path)
        };
        assert_eq!(kind(b"# created_utc: \"x\"\n\nb0_p0_kpa, t_s\n1,2\n"), Some(FileKind::Recording));
        assert_eq!(kind(b"\x89MCAP0\r\n"), Some(FileKind::Recording));
        assert_eq!(kind(b"# my rig\n[supply]\npressure_kpa = 300\n"), Some(FileKind::Rig));
        assert_eq!(kind(b"schema = \"pneudrive-extended/4\"\n"), Some(FileKind::Parameters));
        assert_eq!(kind(b"{\n \"schema\": \"pneudrive-show/1\" }"), Some(FileKind::Results));
        for neither in
            [&b"a,b\n1,2\n"[..], b"[supply]\npressure = 3\n", b"schema = \"other/1\"\n", b"", b"{}"]
        {
            assert_eq!(kind(neither), None, "{}", String::from_utf8_lossy(neither));
        }
        assert_eq!(FileKind::of(&folder.path().join("none")), None);
    }
}
