//! What peripherals do by themselves, and the interrupt lines.

use super::Bus;

/// Interrupt numbers (2.3.2).
mod irq {
    pub const TIMER_IRQ_0: u32 = 0;
    pub const PWM_IRQ_WRAP: u32 = 4;
    pub const DMA_IRQ_0: u32 = 11;
    pub const DMA_IRQ_1: u32 = 12;
    pub const IO_IRQ_BANK0: u32 = 13;
    pub const UART0_IRQ: u32 = 20;
    pub const UART1_IRQ: u32 = 21;
    pub const ADC_IRQ_FIFO: u32 = 22;
    pub const I2C0_IRQ: u32 = 23;
    pub const I2C1_IRQ: u32 = 24;
}

impl Bus {
    /// Does everything due up to now, in order of time.
    pub fn advance(&mut self) {
        let now = self.now;
        while self.next_event <= now {
            let at = self.next_event;
            // What DMA reads and writes happens at the time of the event too.
            self.now = at;
            for (number, uart) in self.uarts.iter_mut().enumerate() {
                if uart.next_event() <= at {
                    uart.advance(at, self.pins.uart_receives(number));
                }
            }
            for i2c in &mut self.i2c {
                i2c.advance(at);
            }
            self.adc.advance(at);
            self.timer.advance(at);
            self.watchdog.advance(at);
            self.pwm.advance(at);
            self.dma.advance(at);
            self.pace_dma_by_pwm();
            self.run_dma(at);
            self.update_pwm_pins(at);
            self.note_reset_request();
            self.update_interrupt_lines();
            self.reschedule();
        }
        self.now = now;
    }

    /// After a register access: lets DMA answer new requests, and sets lines and the next event
    /// right.
    pub(super) fn settle(&mut self) {
        let now = self.now;
        self.pace_dma_by_pwm();
        self.run_dma(now);
        self.note_reset_request();
        self.update_interrupt_lines();
        self.reschedule();
    }

    /// Something outside changed: a byte on a wire, a pin.
    pub fn outside_changed(&mut self) {
        self.update_interrupt_lines();
        self.reschedule();
    }

    fn note_reset_request(&mut self) {
        if let Some(reason) = self.watchdog.take_reset() {
            self.reset_request = Some(reason);
            self.pause_core();
        }
    }

    fn reschedule(&mut self) {
        let uarts = self.uarts[0].next_event().min(self.uarts[1].next_event());
        let i2c = self.i2c[0].next_event().min(self.i2c[1].next_event());
        self.next_event = uarts
            .min(i2c)
            .min(self.adc.next_event())
            .min(self.timer.next_event())
            .min(self.watchdog.next_event())
            .min(self.pwm.next_event())
            .min(self.dma.next_event())
            .min(self.next_dma_transfer());
        self.set_budget();
    }

    pub(super) fn update_interrupt_lines(&mut self) {
        let line = |raised: bool, number: u32| u32::from(raised) << number;
        let lines = self.timer.interrupts() << irq::TIMER_IRQ_0
            | line(self.pwm.interrupt(), irq::PWM_IRQ_WRAP)
            | line(self.dma.interrupt(0), irq::DMA_IRQ_0)
            | line(self.dma.interrupt(1), irq::DMA_IRQ_1)
            | line(self.io.interrupt(), irq::IO_IRQ_BANK0)
            | line(self.uarts[0].interrupt(), irq::UART0_IRQ)
            | line(self.uarts[1].interrupt(), irq::UART1_IRQ)
            | line(self.adc.interrupt(), irq::ADC_IRQ_FIFO)
            | line(self.i2c[0].interrupt(), irq::I2C0_IRQ)
            | line(self.i2c[1].interrupt(), irq::I2C1_IRQ);
        let rising = lines & !self.interrupt_lines;
        self.interrupt_lines = lines;
        self.interrupt_edges |= rising;
        if rising != 0 {
            self.notice_interrupts();
        }
    }
}
