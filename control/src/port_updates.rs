//! Updates, as whoever runs the board sees them.

use crate::BusPort;
use crate::update::{Piece, RunningProgram, UpdateDesk, UpdateOrder};
use pneudrive_protocol::pages::UpdateOutcome;

impl BusPort {
    /// This board can be updated over the bus, and runs this program. Whoever says so calls
    /// [`take_piece`](Self::take_piece) after every byte, and [`take_update`](Self::take_update)
    /// now and then.
    pub fn support_updates(&mut self, program: RunningProgram) {
        self.update = UpdateDesk::new(program);
    }

    /// The piece of a new program that the last byte has completed, once.
    #[inline]
    pub fn take_piece(&mut self) -> Option<Piece> {
        self.update.take_piece()
    }

    /// What a host wants done with the program that it has sent, once. Ends with a restart, or with
    /// [`end_update`](Self::end_update).
    ///
    /// A trial ends here if the board [is not vented](Self::is_vented). One that is confirmed vents
    /// all the time.
    pub fn take_update(&mut self) -> Option<UpdateOrder> {
        // All interrupts wait while a board looks, many times a second.
        let order = self.update.take_order()?;
        if matches!(order, UpdateOrder::Try { .. }) && !self.is_vented() {
            self.end_update(UpdateOutcome::NotVented);
            return None;
        }
        Some(order)
    }

    /// Why what [`take_update`](Self::take_update) gave does not happen. What has come is
    /// forgotten.
    pub fn end_update(&mut self, outcome: UpdateOutcome) {
        self.update.end(outcome);
    }
}
