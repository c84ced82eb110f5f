use super::Failure;
use crate::fault::FaultKind;
use crate::plant::{EffectGroup, catalogue};
use std::fmt::Write as _;
use std::io::{self, Write as _};

/// Prints to standard output. A reader that has seen enough (`| head`) is no failure.
pub(super) fn print(text: &str) -> Result<(), Failure> {
    match io::stdout().write_all(text.as_bytes()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            Err(Failure::running(format!("cannot write to standard output: {error}")))
        }
        _ => Ok(()),
    }
}

/// Every effect of the plant with its parameters.
pub(super) fn effects() -> String {
    let mut text = String::from(
        "--effect ID[=VALUE] or ID:NAME=VALUE,... and @b0 for one board or @b0c2 for one channel; repeatable\n",
    );
    let groups = [
        (EffectGroup::Structure, "Structure: what a model may lack"),
        (EffectGroup::Change, "Changes: what may have moved since the calibration"),
        (EffectGroup::OffCatalogue, "Off the catalogue: what no diagnosis knows by name"),
    ];
    for (group, title) in groups {
        let _ = writeln!(text, "\n{title}");
        for effect in catalogue().filter(|effect| effect.group == group) {
            let _ = writeln!(text, "\n  {:<22}{} ({})", effect.id, effect.meaning, effect.acts_on());
            for p in effect.parameters {
                let range = format!("{} to {}", p.min, p.max);
                let _ = writeln!(
                    text,
                    "      {:<24}{:<10}{:<22}default {:<8}{}",
                    p.name, p.unit, range, p.moderate, p.meaning
                );
            }
        }
    }
    text
}

/// Every fault with its unit, default duration and an example.
pub(super) fn faults() -> String {
    let mut text = String::from(
        "--fault KIND=RATE[,OPTION...] at random, or KIND@SECONDS[,OPTION...] once; repeatable\n\
         Options: ms=NUMBER how long it lasts; on=requests or on=answers which way (both unless given);\n\
         board=POSITION which board (one at random unless given)\n",
    );
    for kind in FaultKind::ALL {
        let duration =
            kind.default_duration_ns().map_or(String::new(), |ns| format!(", {} ms", ns as f64 / 1e6));
        let _ = writeln!(text, "\n  {:<13}{}", kind.name(), kind.summary());
        let _ = writeln!(text, "  {:<13}rate: {}{duration}", "", kind.rate_unit().name());
        let _ = writeln!(text, "  {:<13}--fault {}", "", kind.example());
    }
    text
}

#[cfg(test)]
mod tests {
    use crate::fault::FaultKind;
    use crate::plant::catalogue;

    #[test]
    fn the_lists_are_complete() {
        let effects = super::effects();
        assert!(catalogue().all(|effect| effects.contains(effect.id)));
        let faults = super::faults();
        assert!(FaultKind::ALL.iter().all(|kind| faults.contains(kind.example())));
    }
}
