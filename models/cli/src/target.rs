//! Where results go, looked at before any work: what a command reads is not replaced, and what
//! cannot be written is said at once.

use std::path::{Path, PathBuf};

use super::Failure;

/// Can results be written to the file at `path`, which the argument `option` names, without
/// replacing one of `inputs`?
///
/// # Errors
/// What is wrong with the path, and what to do.
pub fn file(option: &str, path: &Path, inputs: &[&Path]) -> Result<(), Failure> {
    if path.is_dir() {
        return Err(refused(option, path, "that is a folder; name a file in it"));
    }
    keeps(option, path, inputs)?;
    let folder = parent(path);
    if !folder.is_dir() {
        let why = format!("there is no folder {}; make it first", folder.display());
        return Err(refused(option, path, &why));
    }
    writable(option, path, &folder)
}

/// Can a folder of results be made at `path`, whose files have these names, without replacing one
/// of `inputs`?
///
/// # Errors
/// As [`file`].
pub fn folder(option: &str, path: &Path, names: &[&str], inputs: &[&Path]) -> Result<(), Failure> {
    for name in names {
        keeps(option, &path.join(name), inputs)?;
    }
    // The nearest folder that is there: those between are made when there is something to put in.
    let mut there = path.to_path_buf();
    while !there.is_dir() {
        if there.exists() {
            return Err(refused(option, path, &format!("{} is a file; name a folder", there.display())));
        }
        there = parent(&there);
    }
    writable(option, path, &there)
}

/// As [`file`], of a JSON of this schema: what something else wrote is not replaced. Commands name
/// theirs after another file, and several may do so after the same one.
///
/// # Errors
/// As [`file`].
pub fn json(option: &str, path: &Path, schema: &str, inputs: &[&Path]) -> Result<(), Failure> {
    file(option, path, inputs)?;
    let Ok(text) = std::fs::read(path) else { return Ok(()) };
    let found = serde_json::from_slice::<Written>(&text).ok();
    let kind = |schema: &str| schema.split('/').next().map(str::to_owned);
    if found.is_some_and(|found| kind(&found.schema) == kind(schema)) {
        return Ok(());
    }
    let why = "something else is in that file, which would be replaced; choose another name with --out, or move it away";
    Err(refused(option, path, why))
}

/// As [`file`], of a result with a JSON of this schema at `json`, which says that an earlier one is
/// there: that may be replaced, anything else, such as a recording, may not.
///
/// # Errors
/// As [`file`].
pub fn result(
    option: &str,
    path: &Path,
    json_path: &Path,
    schema: &str,
    inputs: &[&Path],
) -> Result<(), Failure> {
    file(option, path, inputs)?;
    json(option, json_path, schema, inputs)?;
    if path.exists() && !json_path.exists() {
        let why = "that file is there already and was not written by this command; choose another name, or move it away";
        return Err(refused(option, path, why));
    }
    Ok(())
}

/// Does the name of the file at `path` end in one of `endings`? Others would hold what their name
/// does not say.
///
/// # Errors
/// Names what is written, and the endings.
pub fn ending(option: &str, path: &Path, what: &str, endings: &[&str]) -> Result<(), Failure> {
    let name = path.to_string_lossy();
    if endings.iter().any(|ending| name.ends_with(ending)) {
        return Ok(());
    }
    let listed = match endings {
        [others @ .., last] if !others.is_empty() => format!("{} or {last}", others.join(", ")),
        _ => endings.concat(),
    };
    Err(refused(option, path, &format!("{what} written there; let the name end in {listed}")))
}

/// What every JSON of ours says first.
#[derive(serde::Deserialize)]
struct Written {
    schema: String,
}

fn keeps(option: &str, path: &Path, inputs: &[&Path]) -> Result<(), Failure> {
    let Ok(target) = path.canonicalize() else { return Ok(()) };
    if inputs.iter().any(|input| input.canonicalize().is_ok_and(|input| input == target)) {
        return Err(refused(option, path, "that file is read here; choose another name"));
    }
    Ok(())
}

fn writable(option: &str, path: &Path, folder: &Path) -> Result<(), Failure> {
    tempfile::tempfile_in(folder).map_or_else(
        |error| Err(refused(option, path, &format!("nothing can be written there: {error}"))),
        |_| Ok(()),
    )
}

fn parent(path: &Path) -> PathBuf {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent.to_path_buf(),
        Some(_) => PathBuf::from("."),
        None => path.to_path_buf(),
    }
}

fn refused(option: &str, path: &Path, why: &str) -> Failure {
    Failure::input(format!("{option} {}: {why}", path.display()))
}
