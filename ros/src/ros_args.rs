//! The arguments that every ROS 2 node understands:
//! `--ros-args -r from:=to -p name:=value --params-file file.yaml`.

use std::ffi::OsString;
use std::path::PathBuf;

/// What stood between `--ros-args` and `--`.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct RosArgs {
    /// Names to replace and what by, in order.
    pub remaps: Vec<(String, String)>,
    /// Parameters, as written.
    pub parameters: Vec<(String, String)>,
    /// Files of parameters, in order: later ones win.
    pub files: Vec<PathBuf>,
}

/// A ROS argument that cannot be used.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum RosArgsError {
    /// No `from:=to`.
    #[error("{option} {text}: expected NAME:=VALUE")]
    NoAssignment {
        /// The option before it.
        option: String,
        /// What came.
        text: String,
    },
    /// The last argument wants another one.
    #[error("{option}: a value is missing")]
    NoValue {
        /// The option.
        option: String,
    },
    /// Not understood here.
    #[error(
        "{option}: not supported by this node; use -r (remap), -p (parameter), --params-file, or its own flags (--help)"
    )]
    Unsupported {
        /// The option.
        option: String,
    },
}

/// Takes the ROS arguments out of a command line; returns what is left, the program's name first.
pub fn split(line: impl Iterator<Item = OsString>) -> Result<(Vec<OsString>, RosArgs), RosArgsError> {
    let mut own = Vec::new();
    let mut ros = RosArgs::default();
    let mut inside = false;
    let mut line = line;
    while let Some(argument) = line.next() {
        let text = argument.to_string_lossy().into_owned();
        match (inside, text.as_str()) {
            (false, "--ros-args") => inside = true,
            (false, _) => own.push(argument),
            (true, "--") => inside = false,
            (true, "-r" | "--remap") => ros.remaps.push(assignment(&text, line.next())?),
            (true, "-p" | "--param") => ros.parameters.push(assignment(&text, line.next())?),
            (true, "--params-file") => ros.files.push(value(&text, line.next())?.into()),
            // What launch files add, and what has no meaning here.
            (true, "--log-level" | "--log-config-file" | "--log-file-name" | "-e" | "--enclave") => {
                drop(value(&text, line.next())?);
            }
            (true, option) if option.starts_with("--enable-") || option.starts_with("--disable-") => {}
            (true, _) => return Err(RosArgsError::Unsupported { option: text }),
        }
    }
    Ok((own, ros))
}

fn value(option: &str, argument: Option<OsString>) -> Result<String, RosArgsError> {
    let argument = argument.ok_or_else(|| RosArgsError::NoValue { option: option.to_owned() })?;
    Ok(argument.to_string_lossy().into_owned())
}

fn assignment(option: &str, argument: Option<OsString>) -> Result<(String, String), RosArgsError> {
    let text = value(option, argument)?;
    match text.split_once(":=") {
        Some((name, value)) if !name.is_empty() => Ok((name.to_owned(), value.to_owned())),
        _ => Err(RosArgsError::NoAssignment { option: option.to_owned(), text }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(line: &str) -> Result<(Vec<OsString>, RosArgs), RosArgsError> {
        split(line.split(' ').map(OsString::from))
    }

    #[test]
    fn ros_arguments_are_taken_out() {
        let (own, ros) =
            of("x --port a --ros-args -r __ns:=/arm --param rate_hz:=500.0 --log-level info --params-file a.yaml --params-file b.yaml -- --devices 2")
                .unwrap();
        assert_eq!(own, ["x", "--port", "a", "--devices", "2"].map(OsString::from));
        assert_eq!(ros.remaps, [("__ns".to_owned(), "/arm".to_owned())]);
        assert_eq!(ros.parameters, [("rate_hz".to_owned(), "500.0".to_owned())]);
        assert_eq!(ros.files, ["a.yaml", "b.yaml"].map(PathBuf::from));
    }

    #[test]
    fn what_is_not_understood_is_named() {
        assert!(of("x --ros-args -r a").unwrap_err().to_string().contains("-r a"));
        assert!(of("x --ros-args -p").unwrap_err().to_string().contains("-p: a value"));
        assert!(of("x --ros-args --what f").unwrap_err().to_string().contains("--what"));
        assert!(of("x --ros-args --params-file").unwrap_err().to_string().contains("--params-file: a value"));
    }
}
