//! What decides the result of a diagnosis: every level, prior and practical threshold, with its
//! unit, its reason and its source.
//!
//! Constants that decide only how long a fit takes, or how close to an optimum it ends, stay where
//! they are used.

/// One entry, as `report.json` and the page show it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Setting {
    /// Name, with the unit where it has one.
    pub name: &'static str,
    /// Value.
    pub value: f64,
    /// What it is.
    pub meaning: &'static str,
    /// Why it is what it is.
    pub reason: &'static str,
}

/// Defines the structure, its values and their list from one table.
macro_rules! settings {
    ($($name:ident: $kind:ty = $value:expr, $meaning:literal, $reason:literal;)*) => {
        /// The values.
        #[derive(Debug, Clone, Copy)]
        pub struct Settings {
            $(#[doc = $meaning] #[doc = ""] #[doc = $reason] pub $name: $kind,)*
        }

        /// The values that every diagnosis goes by.
        pub const SETTINGS: Settings = Settings { $($name: $value,)* };

        /// All of them, in the order of the pipeline.
        #[must_use]
        pub fn list() -> Vec<Setting> {
            vec![$(Setting {
                name: stringify!($name),
                value: f64::from(SETTINGS.$name),
                meaning: $meaning,
                reason: $reason,
            },)*]
        }
    };
}

settings! {
    // Split.
    longest_block_s: f64 = 5.0, "Longest block, s.", "The start pressure and a slow wander of the supply are free in each.";
    shortest_block_s: f64 = 1.0, "Shortest block, s.", "Several time constants of a chamber.";
    blocks_wanted: f64 = 24.0, "Blocks that a short recording is cut into.", "Half of them fit, a quarter each choose and test.";
    block_gap: f64 = 0.06, "Part of a block that is simulated and not compared.", "What is left of the block before dies away.";
    // Preconditions.
    least_blocks: u8 = 8, "Blocks without which nothing is diagnosed.", "Four fit, two choose, two test.";
    slowest_hz: f64 = 10.0, "Slowest sampling, Hz.", "Valves and lags of 50 ms and more are seen.";
    least_drive_movement: f64 = 0.01, "Smallest standard deviation of a drive that excites anything, -1 to 1.", "Less stays within a valve's dead band.";
    least_command_movement_kpa: f64 = 1.0, "Smallest standard deviation of a command, kPa.", "About one count of the board's converter.";
    clipped_share: f64 = 0.02, "Part of the rows exactly at the highest value that looks clipped.", "A pressure at rest scatters over several counts.";
    clipped_most: f64 = 0.5, "Part of a channel's rows that may be clipped.", "Of what is left nothing could be chosen and tested.";
    own_correlation: f64 = 0.4, "Correlation with its own command below which a channel does not follow it.", "Chosen on recordings with columns swapped on purpose.";
    other_correlation: f64 = 0.7, "Correlation with another one's above which it follows that.", "Chosen on recordings with columns swapped on purpose.";
    own_rate_correlation: f64 = 0.15, "As own_correlation, of drives and rates of pressure.", "Chosen on recordings with columns swapped on purpose.";
    other_rate_correlation: f64 = 0.4, "As other_correlation, of drives and rates of pressure.", "Chosen on recordings with columns swapped on purpose.";
    // Likelihood: what may wander in a block, as standard deviations.
    start_kpa: f64 = 10.0, "A block's start pressure, kPa, at most.", "What wander before the block leaves behind.";
    start_share: f64 = 0.05, "The same, over the range in which the pressure moves.", "What wander before the block leaves behind.";
    supply_level: f64 = 0.012, "The supply's level in a block, over its gauge pressure.", "A usual pressure regulator holds about 1 %.";
    supply_slope: f64 = 0.008, "The supply's change over half a block, over its gauge pressure.", "A usual pressure regulator holds about 1 %.";
    flow: f64 = 0.01, "The flow's level and slopes in a block, relative.", "No valve's curve is known better; with 0.5 % a sag of the supply was missed in a hard round.";
    widest_edge: f64 = 0.5, "Widest overlap or dead band of the base model's valve, as a drive.", "Beyond it a fit bends the valve's corner to imitate something else.";
    // Screening and selection.
    level: f64 = 0.05, "Level of the score test over the whole catalogue, and of the tests of what the residual depends on.", "The usual one.";
    practical: f64 = 0.01, "Smallest part of the error that is worth a name, on blocks that were not fitted, or that tells rivals apart.", "A hundredth of the error changes no decision about a rig.";
    practical_roughly_timed: f64 = 0.1, "The same in a board's loop beside what happens at times that the rows tell only roughly.", "There a simulation goes astray by itself.";
    practical_limit_cycle: f64 = 0.03, "The same beside what makes a loop hunt.", "By so much its likelihood differs by luck.";
    large_error: f64 = 2.0, "Mean squared weighted error, in variances of the noise, that is plainly not explained.", "Of sound rigs it is about 1 (hard rounds).";
    large_error_limit_cycle: f64 = 1.5, "The same beside a loop that hunts.", "Hunting takes up much of whatever is not explained.";
    forced: f64 = 0.3, "Names that leave more than this part of a large error are withdrawn.", "What takes so little only imitates it; chosen on own blind rounds.";
    forced_roughly_timed: f64 = 0.6, "The same where what was named happens at times that the rows tell only roughly.", "There a simulation goes astray by itself.";
    trace: f64 = 0.2, "An effect smaller than this part of another channel's, and than what is worth a name, does not act.", "However sure: something else is not described to the last digit.";
    tie_gain: f64 = 0.25, "A rival ties when blocks do not tell them apart and it leaves no more than this part of the gain.", "Chosen on own blind rounds.";
    most_causes: u8 = 4, "Causes that are looked for at most.", "A recording of minutes does not carry more.";
    restarted: f64 = 0.5, "Names give way to one found from other starts that leaves less than this part of their squared error.", "Chosen on own blind rounds.";
    step_error: f64 = 0.01, "Mean squared weighted change by half the integration step, in variances of the noise, that calls for finer steps.", "Far below large_error.";
    // The grey-box likelihood.
    astray: f64 = 5.0, "An error over the allowed one beyond which all models are fitted by the filter's likelihood.", "More than any weight accounts for.";
    greybox_least_nats: f64 = 20.0, "Least gain of the log-density that is worth a name, nats.", "More than a look at the whole catalogue finds in noise.";
    greybox_acts: f64 = 0.1, "Part of the largest channel's gain at which an effect acts on another channel.", "Chosen on the ventilator recordings.";
    greybox_as_likely: f64 = 0.9, "Part of the best effect's gain at which a rival ties, its rollouts' error being no more than that of the best over this part. A name may have as much more.", "Chosen on the ventilator recordings and one blind round.";
    greybox_worth: f64 = 0.2, "Part of the rollouts' error that a name must take.", "Where so much is wrong, what takes less only imitates it.";
    greybox_supply: f64 = 0.003, "Expected wander of the supply, relative.", "A pressure regulator of good quality.";
    greybox_supply_s: f64 = 20.0, "Time constant of that wander, s.", "The order of a compressor's cycle.";
    greybox_discrepancy: f64 = 0.3, "Expected discrepancy of the reading, over the movement of the pressure.", "Wide: it is estimated.";
    greybox_discrepancy_s: f64 = 0.3, "Time constant of the discrepancy, s.", "A longer one forgives a simulation that goes astray for seconds, a shorter one is hardly told from noise.";
    greybox_outlier: f64 = 6.0, "Prediction errors beyond this many standard deviations move the state no further.", "Once in 5e8 rows of noise.";
    greybox_huber: f64 = 4.0, "Prediction errors beyond this many standard deviations count by their size.", "P. J. Huber, Annals of Mathematical Statistics 35, 1964.";
    // Discrepancy.
    poor: f64 = 0.3, "A base model whose error is more than this part of the pressure's movement describes nothing.", "The movement itself is 1.";
    beyond: f64 = 1.7, "An error over the allowed one beyond which something else is there.", "Chosen on own blind rounds.";
    dependence_share: f64 = 0.03, "Part of the squared residual that a dependence must account for.", "Less is hardly seen in a plot.";
    // Inference: what is taken for known and is not, as standard deviations.
    known_volume: f64 = 0.058, "The rig file's volume, relative.", "A tenth at most, evenly: 0.1 over the root of 3.";
    known_supply: f64 = 0.029, "The rig file's supply, over its gauge pressure.", "A twentieth at most, evenly: 0.05 over the root of 3.";
    misfit: f64 = 2.0, "Factor by which residuals leave room for these quantities.", "The world is not made of them alone.";
    size_spread: f64 = 0.1, "Relative spread of a cause's size that is expected between channels, and counts as one channel more where they differ.", "Two channels alone tell next to nothing of a spread; valves of one make differ by a few percent, wear and walls by more.";
    // Report.
    flat: f64 = 0.8, "An interval wider than this part of the bounds, on the scale of fitting, determines nothing.", "Neither size nor sign could be used.";
    usual_doubtful: f64 = 2.0, "Usual sizes up to which a size is no more than usual where its interval reaches none, the drive being recorded. In closed loop such a size is never more.", "Chosen on hard rounds.";
    coarsening_rows: f64 = 100.0, "Rows that the choosing blocks count as at most when explanations are weighed.", "A model is wrong in ways that last: many rows of one error are not much evidence; chosen on half of a hard round.";
    not_fitted: f64 = 0.1, "Probability of a set of causes that was not fitted.", "Of 2 in 22 recordings of a hard round the hidden set was only screened.";
    unnamed: f64 = 0.1, "What a set of causes counts that the tests for names have turned down, over one that they have not.", "A likelihood ratio: with 0.3, 0.1 and 0.03 the mean logarithmic loss of fifteen hard rounds is 0.58, 0.55 and 0.56 with the drive, 0.74, 0.63 and 0.59 without.";
    sure_gain: f64 = 0.05, "A cause whose gain may be smaller than this is only probable.", "Five times practical.";
    sure_probability: f64 = 0.5, "A cause that is less probable than this is only probable.", "Something else is more so.";
    sure_p: f64 = 0.01, "A cause whose trace chance makes more often is only probable.", "The usual one.";
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_are_fewer_than_sixty_and_each_says_what_and_why() {
        let all = list();
        assert!(all.len() < 60, "{}", all.len());
        for setting in &all {
            assert!(setting.meaning.ends_with('.') && setting.reason.ends_with('.'), "{setting:?}");
            assert!(setting.value.is_finite() && setting.value > 0.0, "{setting:?}");
        }
    }
}
