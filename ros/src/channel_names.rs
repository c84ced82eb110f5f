//! What messages call the channels of a joint: by number, or by the names of the rig file.

use pneudrive_host::rig::Rig;
use pneudrive_protocol::CHANNELS;
use pneudrive_record::messages::command_name;

/// Names of a joint's channels.
///
/// A channel that the rig file calls `left` has `left_p_kpa` and `left_cmd_kpa` where others have
/// `b0_p3_kpa` and `b0_cmd3_kpa`; commands may say either, or `left`. Two channels of a board with
/// the same name keep their numbers.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct ChannelNames {
    joint: u16,
    board: Option<String>,
    own: [Option<String>; CHANNELS],
}

impl ChannelNames {
    /// Of `joint`, which is `board` on its bus.
    pub fn new(joint: u16, rig: Option<&Rig>, board: u8) -> Self {
        let named = std::array::from_fn(|channel| rig?.channel_name(board, channel));
        let own = named.map(|name: Option<&str>| {
            let alone = named.iter().filter(|other| **other == name).count() == 1;
            name.filter(|_| alone).map(str::to_owned)
        });
        Self { joint, board: rig.and_then(|rig| rig.board_name(board)).map(str::to_owned), own }
    }

    /// Number in names of topics and values.
    pub fn joint(&self) -> u16 {
        self.joint
    }

    /// What people call the board.
    pub fn board(&self) -> Option<&str> {
        self.board.as_deref()
    }

    /// The names of a state's eight values: four pressures, four commands.
    pub fn of_state(&self) -> Vec<String> {
        let pressure = |(k, own): (usize, &Option<String>)| match own {
            Some(own) => format!("{own}_p_kpa"),
            None => format!("b{}_p{k}_kpa", self.joint),
        };
        self.own.iter().enumerate().map(pressure).chain((0..CHANNELS).map(|k| self.command(k))).collect()
    }

    /// The channel that a command calls so.
    pub fn channel(&self, name: &str) -> Option<usize> {
        let find = |is: &dyn Fn(usize) -> bool| (0..CHANNELS).find(|&channel| is(channel));
        find(&|k| command_name(self.joint, k) == name)
            .or_else(|| find(&|k| self.command(k) == name))
            .or_else(|| find(&|k| self.own[k].as_deref() == Some(name)))
    }

    /// What commands may call the channels, for messages.
    pub fn known(&self) -> String {
        let numbered =
            format!("{} to {}", command_name(self.joint, 0), command_name(self.joint, CHANNELS - 1));
        let own: Vec<_> = self.own.iter().flatten().map(String::as_str).collect();
        if own.is_empty() { numbered } else { format!("{numbered}, or {}", own.join(", ")) }
    }

    fn command(&self, channel: usize) -> String {
        match &self.own[channel] {
            Some(own) => format!("{own}_cmd_kpa"),
            None => command_name(self.joint, channel),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RIG: &str = "[boards.1]\nname = \"arm\"\n[boards.1.channels.0]\nname = \"left\"\n[boards.1.channels.2]\nname = \"same\"\n\
                       [boards.1.channels.3]\nname = \"same\"\n";

    #[test]
    fn channels_have_the_names_of_the_rig_file() {
        let rig = Rig::parse("rig.toml", RIG).unwrap();
        let names = ChannelNames::new(5, Some(&rig), 1);
        let state = names.of_state();
        assert_eq!((state[0].as_str(), state[1].as_str()), ("left_p_kpa", "b5_p1_kpa"));
        assert_eq!((state[4].as_str(), state[6].as_str()), ("left_cmd_kpa", "b5_cmd2_kpa"));
        for name in ["left", "left_cmd_kpa", "b5_cmd0_kpa"] {
            assert_eq!(names.channel(name), Some(0), "{name}");
        }
        assert_eq!((names.channel("b5_cmd3_kpa"), names.channel("same")), (Some(3), None));
        assert_eq!(
            (names.board(), names.known().as_str()),
            (Some("arm"), "b5_cmd0_kpa to b5_cmd3_kpa, or left")
        );
    }

    #[test]
    fn without_a_rig_file_they_have_numbers() {
        let names = ChannelNames::new(0, None, 0);
        assert_eq!(names.of_state()[3], "b0_p3_kpa");
        assert_eq!(
            (names.channel("b0_cmd2_kpa"), names.channel("left"), names.board()),
            (Some(2), None, None)
        );
    }
}
