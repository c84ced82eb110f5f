//! `pneudrive-model effects`

use pneudrive_model::effects::catalogue::CATALOGUE;
use pneudrive_model::effects::{EffectInfo, Question};
use pneudrive_model::report::{Table, significant};

use super::Failure;
use super::print::outln;

/// List the physical effects that a diagnosis can name
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  pneudrive-model effects\n  pneudrive-model effects valve_hysteresis")]
pub struct Args {
    /// Show this effect in full
    #[arg(value_name = "ID")]
    id: Option<String>,
}

impl Args {
    pub fn run(self) -> Result<(), Failure> {
        match self.id {
            None => {
                outln!("{}", list());
                Ok(())
            }
            Some(id) => match CATALOGUE.iter().find(|effect| effect.id == id) {
                Some(effect) => {
                    outln!("{}", full(effect));
                    Ok(())
                }
                None => {
                    let known: Vec<&str> = CATALOGUE.iter().map(|effect| effect.id).collect();
                    Err(Failure::input(format!("no effect is called {id}; there are {}", known.join(", "))))
                }
            },
        }
    }
}

fn list() -> String {
    let rows = |question: Question| -> Vec<Vec<String>> {
        let of = CATALOGUE.iter().filter(|effect| effect.question == question);
        of.map(|effect| vec![effect.id.to_owned(), effect.title.to_owned()]).collect()
    };
    let table = |head: &str, question| {
        rows(question)
            .into_iter()
            .fold(format!("{head}\n"), |text, row| format!("{text}  {:<22}{}\n", row[0], row[1]))
    };
    format!(
        "{}\n{}\n{}",
        table("What a model can lack (found in one recording):", Question::Structure),
        table("What can have changed (found with --reference):", Question::Change),
        table("Fitted along and never named (what it explains as well gets no name):", Question::Foil)
    )
}

fn full(effect: &EffectInfo) -> String {
    let parameters: Vec<Vec<String>> = effect
        .parameters
        .iter()
        .map(|p| {
            let range = format!("{} to {}", significant(p.lower, 3), significant(p.upper, 3));
            vec![p.name.to_owned(), p.unit.to_owned(), range, significant(p.null, 3), p.meaning.to_owned()]
        })
        .collect();
    format!(
        "{} ({})\n\n{}\n\n  {}\n  Source: {}\n\n{}\n\nConfused with: {}\nTold apart by: {}\nAt the rig: {}",
        effect.id,
        effect.title,
        effect.physics,
        effect.equation,
        effect.source,
        Table::text(&["parameter", "unit", "range", "absent at", "meaning"], &parameters),
        if effect.rivals.is_empty() {
            "nothing in the catalogue".to_owned()
        } else {
            effect.rivals.join(", ")
        },
        effect.separated_by,
        effect.check
    )
}
