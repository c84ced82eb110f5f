use pneudrive_protocol::{CHANNELS, Counts};

/// "Two agreeing requests before pressure may rise": a set point falls at once, and rises as far as
/// this request and the one before it both want.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Agreement {
    required: bool,
    /// What the last request wanted.
    before: [Counts; CHANNELS],
}

impl Agreement {
    pub(crate) fn new(required: bool, initial: Counts) -> Self {
        Self { required, before: [initial; CHANNELS] }
    }

    /// The set points after a request with `wanted`.
    pub(crate) fn take(&mut self, wanted: [Counts; CHANNELS]) -> [Counts; CHANNELS] {
        let before = core::mem::replace(&mut self.before, wanted);
        if !self.required {
            return wanted;
        }
        core::array::from_fn(|channel| wanted[channel].min(before[channel]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn set_points(required: bool, wanted: &[u16]) -> std::vec::Vec<u16> {
        let mut agreement = Agreement::new(required, Counts::ATMOSPHERE);
        let mut take = |wanted: &u16| agreement.take([Counts::saturating(*wanted); CHANNELS])[2].get();
        wanted.iter().map(&mut take).collect()
    }

    #[test]
    fn pressure_rises_when_two_agree_and_falls_at_once() {
        let wanted = [300, 300, 200, 200, 900, 210, 900, 900];
        assert_eq!(set_points(true, &wanted), [102, 300, 200, 200, 200, 210, 210, 900]);
        assert_eq!(set_points(false, &wanted), wanted);
    }

    #[test]
    fn a_ramp_is_followed_a_request_later() {
        assert_eq!(set_points(true, &[110, 120, 130, 125, 120]), [102, 110, 120, 125, 120]);
    }
}
