//! The FMI 3.0 unit of a parameter file: its variables, its settings and its
//! `modelDescription.xml`.
//!
//! Each channel of the file has the same [`Quantity`]s; [`reference()`] numbers them.

use std::fmt::Write as _;

use serde::{Deserialize, Serialize};

use crate::rig::Rig;

/// Name of the library in a unit, without its ending; of its model too.
pub const IDENTIFIER: &str = "pneudrive_chamber";
/// Settings in a unit's resources.
pub const SETTINGS_FILE: &str = "settings.toml";
/// The parameter file in a unit's resources.
pub const PARAMETERS_FILE: &str = "parameters.toml";
/// Value references between one channel and the next; the first channel begins there, and time
/// is 0.
const BLOCK: u32 = 100;

/// What the library must know beside the parameter file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Settings {
    /// Tells the unit from others.
    pub token: String,
    /// Length of the internal step, s.
    pub step_s: f64,
    /// Does the set point drive the channels, or the valve's drive?
    pub set_point: bool,
    /// The channels, in the order of their value references.
    pub channels: Vec<String>,
}

/// A variable of a channel. Pressures are gauge.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// Input: the set point, kPa.
    SetPoint,
    /// Input: drive of the spool or the fill valve.
    Fill,
    /// Input: drive of the vent valve.
    Vent,
    /// Input: supply pressure, kPa.
    Supply,
    /// Input: volume of the chamber, m^3.
    Volume,
    /// Input: its rate, m^3/s.
    VolumeRate,
    /// Parameter: pressure at the start, kPa.
    Start,
    /// Output: pressure in the chamber, kPa.
    Pressure,
    /// Output: pressure at the valve, kPa.
    Port,
    /// Output: what the board reports, kPa.
    Reading,
    /// Output: temperature of the gas, K.
    Temperature,
    /// Output: position of the spool or the fill valve.
    Spool,
    /// Output: rate of the pressure, mean over the last internal step, kPa/s.
    Rate,
}

/// What a variable is for its user.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Causality {
    /// Given by others at every step.
    Input,
    /// Given before the start.
    Parameter,
    /// Given by the unit.
    Output,
}

impl Quantity {
    /// All of them, in the order of their numbers.
    pub const ALL: [Self; 13] = [
        Self::SetPoint,
        Self::Fill,
        Self::Vent,
        Self::Supply,
        Self::Volume,
        Self::VolumeRate,
        Self::Start,
        Self::Pressure,
        Self::Port,
        Self::Reading,
        Self::Temperature,
        Self::Spool,
        Self::Rate,
    ];

    /// Name, unit, use, and meaning.
    #[must_use]
    pub fn describe(self) -> (&'static str, &'static str, Causality, &'static str) {
        use Causality::{Input, Output, Parameter};
        match self {
            Self::SetPoint => ("set_point", "kPa", Input, "set point of the board's loop, gauge"),
            Self::Fill => ("fill", "1", Input, "drive of the spool (-1 to 1) or the fill valve (0 to 1)"),
            Self::Vent => ("vent", "1", Input, "drive of the vent valve, where it is one of its own"),
            Self::Supply => ("supply", "kPa", Input, "supply pressure, gauge"),
            Self::Volume => ("volume", "m3", Input, "volume of the chamber as its joint stands"),
            Self::VolumeRate => ("volume_rate", "m3/s", Input, "rate of that volume"),
            Self::Start => ("start", "kPa", Parameter, "pressure at the start, gauge"),
            Self::Pressure => ("pressure", "kPa", Output, "pressure in the chamber, gauge"),
            Self::Port => ("port", "kPa", Output, "pressure at the valve, gauge"),
            Self::Reading => ("reading", "kPa", Output, "what the board reports, gauge"),
            Self::Temperature => ("temperature", "K", Output, "temperature of the gas"),
            Self::Spool => ("spool", "1", Output, "position of the spool or the fill valve"),
            Self::Rate => ("rate", "kPa/s", Output, "rate of the pressure, mean over the last step"),
        }
    }

    /// Whether a unit driven by set points, or by drives, has it.
    #[must_use]
    pub fn is_in(self, set_point: bool) -> bool {
        match self {
            Self::SetPoint => set_point,
            Self::Fill | Self::Vent => !set_point,
            _ => true,
        }
    }
}

/// The value reference of a channel's quantity.
#[must_use]
pub fn reference(channel: usize, quantity: Quantity) -> u32 {
    let number = Quantity::ALL.iter().position(|q| *q == quantity).unwrap_or(0);
    u32::try_from((channel + 1) * BLOCK as usize + number).unwrap_or(u32::MAX)
}

/// Channel and quantity of a value reference; `None` of time and of what is none.
#[must_use]
pub fn referenced(reference: u32) -> Option<(usize, Quantity)> {
    let channel = (reference / BLOCK).checked_sub(1)?;
    let quantity = Quantity::ALL.get((reference % BLOCK) as usize)?;
    Some((channel as usize, *quantity))
}

/// `modelDescription.xml` of a unit; `created` is the date and time of the export, RFC 3339.
#[must_use]
pub fn model_description(settings: &Settings, rig: &Rig, created: &str) -> String {
    let supply = rig.supply.as_ref().map_or(0.0, |s| s.pressure_kpa);
    let (mut variables, mut outputs, mut unknowns) = (String::new(), String::new(), String::new());
    for (k, channel) in settings.channels.iter().enumerate() {
        // The names come from a calibrated model, and are channels.
        let chamber = channel.parse().map_or_else(|_| rig.chamber.clone(), |id| rig.at(id).chamber);
        let volume = chamber.map_or(1e-4, |chamber| chamber.rest_volume_m3());
        for quantity in Quantity::ALL.into_iter().filter(|q| q.is_in(settings.set_point)) {
            let (name, unit, causality, meaning) = quantity.describe();
            let number = reference(k, quantity);
            let start = match quantity {
                Quantity::Supply => supply,
                Quantity::Volume => volume,
                _ => 0.0,
            };
            let kind = match causality {
                Causality::Input => {
                    format!("causality=\"input\" variability=\"continuous\" start=\"{start}\"")
                }
                Causality::Parameter => {
                    format!(
                        "causality=\"parameter\" variability=\"fixed\" initial=\"exact\" start=\"{start}\""
                    )
                }
                Causality::Output => {
                    let _ = writeln!(outputs, "    <Output valueReference=\"{number}\"/>");
                    let _ = writeln!(unknowns, "    <InitialUnknown valueReference=\"{number}\"/>");
                    "causality=\"output\" variability=\"continuous\" initial=\"calculated\"".to_owned()
                }
            };
            let unit = if unit == "1" { String::new() } else { format!(" unit=\"{unit}\"") };
            let _ = writeln!(
                variables,
                "    <Float64 name=\"{channel}.{name}\" valueReference=\"{number}\" {kind}{unit} \
description=\"{meaning}\"/>"
            );
        }
    }
    let (token, step_s) = (&settings.token, settings.step_s);
    let version = env!("CARGO_PKG_VERSION");
    format!(
        r#"<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="3.0" modelName="PneuDrive chambers" instantiationToken="{token}" version="{version}" generationTool="pneudrive-model {version}" generationDateAndTime="{created}" variableNamingConvention="structured">
  <CoSimulation modelIdentifier="{IDENTIFIER}" canHandleVariableCommunicationStepSize="true" fixedInternalStepSize="{step_s}" canGetAndSetFMUState="true" canSerializeFMUState="true"/>
  <UnitDefinitions>
    <Unit name="kPa"><BaseUnit kg="1" m="-1" s="-2" factor="1000"/></Unit>
    <Unit name="kPa/s"><BaseUnit kg="1" m="-1" s="-3" factor="1000"/></Unit>
    <Unit name="m3"><BaseUnit m="3"/></Unit>
    <Unit name="m3/s"><BaseUnit m="3" s="-1"/></Unit>
    <Unit name="K"><BaseUnit K="1"/></Unit>
    <Unit name="s"><BaseUnit s="1"/></Unit>
  </UnitDefinitions>
  <DefaultExperiment startTime="0" stopTime="10" stepSize="{step_s}"/>
  <ModelVariables>
    <Float64 name="time" valueReference="0" causality="independent" variability="continuous" unit="s" description="time since the start"/>
{variables}  </ModelVariables>
  <ModelStructure>
{outputs}{unknowns}  </ModelStructure>
</fmiModelDescription>
"#
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_channel_starts_with_the_volume_of_its_own_chamber() {
        let text = "[chamber]\nvolume_m3 = 0.5\n[boards.0.channels.1.chamber]\nvolume_m3 = 0.25\n";
        let rig = Rig::parse("rig.toml", text).unwrap();
        let channels = vec!["b0c0".to_owned(), "b0c1".to_owned()];
        let settings = Settings { token: String::new(), step_s: 0.001, set_point: true, channels };
        let description = model_description(&settings, &rig, "");
        let starts = |name: &str| {
            let volume = format!("name=\"{name}.{}\"", Quantity::Volume.describe().0);
            let line = description.lines().find(|line| line.contains(&volume)).unwrap();
            line.split("start=\"").nth(1).unwrap().split('"').next().unwrap().to_owned()
        };
        assert_eq!((starts("b0c0").as_str(), starts("b0c1").as_str()), ("0.5", "0.25"));
    }

    #[test]
    fn references_go_round() {
        for channel in [0, 3, 40] {
            for quantity in Quantity::ALL {
                assert_eq!(referenced(reference(channel, quantity)), Some((channel, quantity)));
            }
        }
        assert_eq!([referenced(0), referenced(99), referenced(199)], [None; 3]);
    }
}
