//! `pneudrive-model export mujoco`

use std::fmt::Write as _;

use pneudrive_model::data::ChannelId;
use pneudrive_model::report::{Table, number, significant};
use pneudrive_model::rig::Rig;
use pneudrive_model::simulation::{CalibratedModel, FirstOrder, first_order};

use super::c::HEADER;
use super::library::{FILE, LibraryArgs};
use super::{Failure, From, PARAMETERS};
use crate::print::outln;

const PLUGIN: &str = include_str!("../../../../capi/mujoco/pneudrive_actuator.c");
const BUILD: &str = include_str!("../../../../capi/mujoco/build.sh");

/// Set points that a first-order actuator is fitted on go up to this share of the supply's gauge
/// pressure.
const HIGHEST: f64 = 0.6;

/// Actuators for MuJoCo: the calibrated chambers as a plugin, or the nearest built-in ones
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  \
pneudrive-model export mujoco --parameters extended.toml --out robot\n  \
sh robot/build.sh python3      # against the headers of that Python's mujoco package\n  \
pneudrive-model export mujoco --native --parameters extended.toml --out robot\n\n\
Without --native, actuators.xml uses the plugin pneudrive.chamber (load it with mujoco.mj_loadPluginLibrary). With it, native.xml \
has MuJoCo's own first-order actuators with the best time constant, gain and bias, and what they leave of the calibrated model's \
pressure in kPa: the price of going without the plugin. Controls are set points in kPa. Put the actuators on your joints or tendons: \
their length is the chamber's.")]
pub struct Args {
    #[command(flatten)]
    from: From,
    #[command(flatten)]
    library: LibraryArgs,
    /// MuJoCo's own first-order actuators, with their error, instead of the plugin
    #[arg(long)]
    native: bool,
    /// Highest set point, kPa gauge [default: 0.6 times the supply]
    #[arg(long, value_name = "KPA", allow_negative_numbers = true)]
    max_kpa: Option<f64>,
}

impl Args {
    pub fn run(self) -> Result<(), Failure> {
        let max_kpa = self.max_kpa;
        if max_kpa.is_some_and(|kpa| !(kpa > 0.0 && kpa < 1e4)) {
            return Err(Failure::input("--max-kpa must be above 0 and below 10000"));
        }
        let model = self.from.load()?;
        let library = if self.native { None } else { Some(self.library.find()?) };
        let rig = model.rig();
        let highest_kpa =
            max_kpa.or_else(|| rig.supply.as_ref().map(|supply| HIGHEST * supply.pressure_kpa)).ok_or_else(
                || Failure::input("the rig has no [supply]; say how far set points go with --max-kpa"),
            )?;
        self.from.make_folder()?;
        let Some(library) = library else {
            let fitted = first_order(&model, highest_kpa)?;
            outln!("{}", table(&fitted));
            return self.from.text("native.xml", &native(&fitted, rig, highest_kpa));
        };
        self.from.copy_parameters()?;
        self.from.copy(&library, FILE)?;
        self.from.text("pneudrive.h", HEADER)?;
        self.from.text("pneudrive_actuator.c", PLUGIN)?;
        self.from.text("build.sh", BUILD)?;
        self.from.text("actuators.xml", &plugin(&model, highest_kpa))
    }
}

fn table(fitted: &[FirstOrder]) -> String {
    let row = |f: &FirstOrder| {
        vec![
            f.channel.to_string(),
            significant(f.time_constant_s, 4),
            number(f.gain, 4),
            number(f.bias_kpa, 2),
            number(f.rms_kpa, 2),
            number(f.largest_kpa, 1),
        ]
    };
    let head = ["channel", "time constant (s)", "gain", "bias (kPa)", "error, RMS (kPa)", "largest (kPa)"];
    Table::text(&head, &fitted.iter().map(row).collect::<Vec<_>>())
}

/// Area of a channel's chamber, m^2: of its radius, or of its volume as if it were 0.2 m long.
fn area_m2(rig: &Rig, channel: ChannelId) -> f64 {
    const LENGTH_M: f64 = 0.2;
    let rig = rig.at(channel);
    let chamber = rig.chamber.as_ref();
    let radius = chamber.and_then(|c| c.radius_m);
    let volume = chamber.map_or(1e-4, |c| c.rest_volume_m3());
    radius.map_or(volume / LENGTH_M, |r| std::f64::consts::PI * r * r)
}

fn native(fitted: &[FirstOrder], rig: &Rig, highest_kpa: f64) -> String {
    let mut xml = "<!-- MuJoCo's first-order actuators nearest to the calibrated chambers. Control: set point, kPa. Force: N.\n     \
Put them on your joints or tendons in the place of JOINT. -->\n<mujoco>\n  <actuator>\n"
        .to_owned();
    for f in fitted {
        // Newtons per kPa of the activation, and at none.
        let area = area_m2(rig, f.channel);
        let (gain, bias) = (1e3 * area * f.gain, 1e3 * area * f.bias_kpa);
        let _ = writeln!(
            xml,
            "    <!-- {}: leaves {} kPa RMS, {} kPa at most, of the calibrated pressure -->\n    \
<general name=\"{}\" joint=\"JOINT\" dyntype=\"filterexact\" dynprm=\"{}\" gaintype=\"fixed\" gainprm=\"{}\" \
biastype=\"affine\" biasprm=\"{} 0 0\" ctrllimited=\"true\" ctrlrange=\"0 {}\"/>",
            f.channel,
            number(f.rms_kpa, 2),
            number(f.largest_kpa, 1),
            f.channel,
            significant(f.time_constant_s, 6),
            significant(gain, 6),
            significant(bias, 6),
            significant(highest_kpa, 6),
        );
    }
    xml + "  </actuator>\n</mujoco>\n"
}

fn plugin(model: &CalibratedModel, highest_kpa: f64) -> String {
    let channels: Vec<ChannelId> = match model {
        CalibratedModel::Fitted { file, .. } => file.channels.keys().copied().collect(),
        CalibratedModel::Extended { file, .. } => {
            file.channels.keys().filter_map(|name| name.parse().ok()).collect()
        }
    };
    let mut xml = "<!-- The calibrated chambers. Control: set point, kPa. Activation: pressure, kPa gauge. Force: N.\n     \
Put them on your joints or tendons in the place of JOINT; `length` is the actuator's length where\n     \
the chamber has its volume at rest. -->\n<mujoco>\n  <extension>\n    <plugin plugin=\"pneudrive.chamber\"/>\n  \
</extension>\n  <actuator>\n"
        .to_owned();
    for name in channels {
        let area = area_m2(model.rig(), name);
        let _ = writeln!(
            xml,
            "    <plugin name=\"{name}\" joint=\"JOINT\" plugin=\"pneudrive.chamber\" actdim=\"1\" ctrllimited=\"true\" \
ctrlrange=\"0 {}\">\n      <config key=\"parameters\" value=\"{PARAMETERS}\"/>\n      \
<config key=\"channel\" value=\"{name}\"/>\n      <config key=\"area\" value=\"{}\"/>\n      \
<config key=\"length\" value=\"0\"/>\n    </plugin>",
            significant(highest_kpa, 6),
            significant(area, 6),
        );
    }
    xml + "  </actuator>\n</mujoco>\n"
}
