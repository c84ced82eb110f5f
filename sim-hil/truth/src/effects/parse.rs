//! Reading an effect from text.

use core::str::FromStr;

use super::super::error::EffectError;
use super::super::id::{CHANNELS_PER_BOARD, ChannelId};
use super::effect::{Effect, Scope};

impl FromStr for Effect {
    type Err = EffectError;

    fn from_str(text: &str) -> Result<Self, EffectError> {
        let refuse = |problem| EffectError::Syntax { text: text.to_owned(), problem };
        let (body, scope) = match text.split_once('@') {
            Some((body, place)) => {
                (body, scope(place).ok_or_else(|| refuse("the place after @ is not b0 or b0c2"))?)
            }
            None => (text, Scope::Rig),
        };
        let number = |value: &str| value.trim().parse::<f64>().map_err(|_| refuse("a value is not a number"));
        // The colon comes first: values never hold one, and `id:name=value` holds an equals sign
        // too.
        if let Some((id, list)) = body.split_once(':') {
            let mut values = Vec::new();
            for item in list.split(',') {
                let (name, value) =
                    item.split_once('=').ok_or_else(|| refuse("after the colon, name=value is missing"))?;
                if values.iter().any(|(earlier, _)| *earlier == name.trim()) {
                    return Err(refuse("a parameter is given twice"));
                }
                values.push((name.trim(), number(value)?));
            }
            return Effect::new(id.trim(), &values, scope);
        }
        match body.split_once('=') {
            Some((id, value)) => Effect::of_size(id.trim(), number(value)?, scope),
            None => Effect::new(body.trim(), &[], scope),
        }
    }
}

/// `b0` or `b0c2`.
fn scope(place: &str) -> Option<Scope> {
    let rest = place.trim().strip_prefix('b')?;
    match rest.split_once('c') {
        None => Some(Scope::Board(rest.parse().ok()?)),
        Some((board, channel)) => {
            let id = ChannelId { board: board.parse().ok()?, channel: channel.parse().ok()? };
            (usize::from(id.channel) < CHANNELS_PER_BOARD).then_some(Scope::Channel(id))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Effect {
        text.parse().unwrap()
    }

    fn refusal(text: &str) -> String {
        text.parse::<Effect>().unwrap_err().to_string()
    }

    #[test]
    fn all_forms_are_read() {
        assert_eq!(read("supply_sag=25").values(), [25.0, 0.03, 0.3]);
        assert_eq!(read("supply_sag:lag_s=0.1,drop_kpa=10").values(), [10.0, 0.1, 0.3]);
        assert_eq!(read("valve_lag").values(), [0.02]);
        let one = read("valve_hysteresis=0.06@b1c2");
        assert_eq!(one.scope(), Scope::Channel(ChannelId { board: 1, channel: 2 }));
        assert_eq!(read("chamber_coupling@b3").scope(), Scope::Board(3));
    }

    #[test]
    fn written_effects_read_back() {
        for definition in super::super::catalogue() {
            let effect = Effect::moderate(definition.id).unwrap();
            assert_eq!(read(&effect.to_string()), effect);
        }
        let text = "wall_creep:compliance_per_mpa=0.3,time_constant_s=2@b0c1";
        assert_eq!(read(text).to_string(), text);
    }

    #[test]
    fn refusals_say_what_is_wrong() {
        assert!(refusal("valve_lagg=1").contains("no effect \"valve_lagg\"; known: supply_sag, "));
        assert!(refusal("valve_lag=fast").contains("not a number"));
        assert!(refusal("valve_lag=7").contains("time_constant_s is 7 s: expected 0 to 0.5"));
        assert!(refusal("valve_lag=NaN").contains("NaN"));
        assert!(refusal("valve_lag:tau=1").contains("no parameter \"tau\"; it has time_constant_s"));
        assert!(refusal("valve_lag:0.1").contains("name=value is missing"));
        assert!(refusal("valve_lag:time_constant_s=0.1,time_constant_s=0.2").contains("twice"));
        assert!(refusal("valve_lag@c1").contains("not b0 or b0c2"));
        assert!(refusal("valve_lag@b0c4").contains("not b0 or b0c2"));
        assert!(refusal("supply_sag=5@b0").contains("acts on the whole rig: it cannot be limited to b0"));
        assert!(refusal("chamber_coupling=1@b0c0").contains("acts on a whole board"));
    }
}
