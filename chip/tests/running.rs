//! The chip as a whole, driven through its public interface by small programs.

use crate::common::*;
use pneudrive_chip::{Chip, Fault, Level, LineErrors, ResetReason, Ticks};

/// GPIO registers of SIO.
const OUT_SET: u32 = SIO + 0x14;
const OUT_XOR: u32 = SIO + 0x1c;
const OE_SET: u32 = SIO + 0x24;

/// A cycle of the 6.5 MHz the chip starts with is 250/13 ticks.
fn cycles(cycles: u64) -> Ticks {
    Ticks::new(cycles * 250 / 13)
}

fn chip(main: Program, handlers: &[(usize, Program)]) -> Chip {
    Chip::from_flash(&flash(main, handlers)).expect("a program")
}

/// Releases every peripheral from reset.
fn released() -> Program {
    Program::new().store(RESETS, 0)
}

/// Switches a pin to SIO and drives it low.
fn output(program: Program, pin: u32) -> Program {
    program.store(IO_BANK0 + 8 * pin + 4, 5).store(OE_SET, 1 << pin)
}

/// Reads of registers that have nothing to do with time (a UART's flags) and of those that have (an
/// alarm) take the same time.
#[test]
fn a_loop_toggles_a_pin_every_few_cycles_exactly() {
    // loop: STR r1, [r0]; B loop: one cycle at the IO port and two for the branch; four more for
    // LDR r2, [r3, #0x18].
    for (read, each) in [(None, 3), (Some(UART0), 7), (Some(TIMER), 7)] {
        let program = output(released(), 25).load(0, OUT_XOR).load(1, 1 << 25).load(3, read.unwrap_or(0));
        let program = program.op(0x6001);
        let program = if read.is_some() { program.op(0x699a).op(0xe7fc) } else { program.op(0xe7fd) };
        let mut chip = chip(program, &[]);
        chip.watch_pins(1 << 25);
        chip.run_until(Ticks::from_millis(1));
        let edges = chip.take_pin_edges();
        let first_high = edges.iter().position(|e| e.level == Level::High).expect("toggles");
        // In the first rounds the loop comes from flash.
        let toggles = &edges[first_high + 2..];
        assert!(toggles.len() > 600);
        for (i, edge) in (0..).zip(toggles) {
            let since_first = edge.at - toggles[0].at;
            let exact = cycles(each * i).get();
            assert!(since_first.get().abs_diff(exact) <= 1, "edge {i} of {read:x?}");
            assert_eq!(edge.level, if i % 2 == 0 { Level::High } else { Level::Low });
        }
        assert_eq!(chip.unmodelled_accesses().count(), 0);
    }
}

/// Counts in r7 how often the alarm comes, every 1000 us.
fn alarm_program() -> Chip {
    let main = released()
        .store(CLOCKS + 0x30, 2)
        .store(WATCHDOG + 0x2c, 1 << 9 | 12)
        .store(TIMER + 0x38, 1)
        .store(TIMER + 0x10, 1000)
        .store(NVIC_ISER, 1)
        .load(7, 0)
        .sleep();
    // ADDS r7, #1; acknowledge; r2 = [ALARM0] + 1000; [ALARM0] = r2.
    let handler = Program::new()
        .op(0x3701)
        .store(TIMER + 0x34, 1)
        .load(0, TIMER + 0x10)
        .load(3, 1000)
        .op(0x6802)
        .op(0x18d2)
        .op(0x6002)
        .bx_lr();
    chip(main, &[(16, handler)])
}

#[test]
fn a_sleeping_chip_wakes_for_its_alarms_and_costs_nothing_between() {
    let mut chip = alarm_program();
    chip.run_until(Ticks::from_micros(500));
    assert!(chip.is_asleep());
    let (asleep, executed) = (chip.now(), chip.instructions());
    let due = chip.next_event();
    assert!(
        due > Ticks::from_micros(1000) && due < Ticks::from_micros(1200),
        "1 ms after the tick started: {due}"
    );
    chip.run_until(due - Ticks::new(1));
    assert_eq!(chip.instructions(), executed);
    assert_eq!(chip.next_event(), due);
    assert!(chip.now() > asleep);
    chip.run_until(due + Ticks::from_micros(100_500));
    assert_eq!(chip.interrupts_taken(0), 101);
    assert!(chip.is_asleep());
    assert_eq!(chip.next_event(), due + Ticks::from_millis(101));
}

#[test]
fn the_same_run_in_steps_of_any_size_is_the_same_run() {
    let mut whole = alarm_program();
    whole.run_until(Ticks::from_millis(20));
    for step in [1, 7, 1000, 12_345] {
        let mut stepped = alarm_program();
        let mut until = Ticks::ZERO;
        while until < Ticks::from_millis(20) {
            until = (until + Ticks::new(step)).min(Ticks::from_millis(20));
            stepped.run_until(until);
        }
        assert_eq!(stepped.now(), whole.now());
        assert_eq!(stepped.instructions(), whole.instructions());
        assert_eq!(stepped.cycles(), whole.cycles());
        assert_eq!(stepped.program_counter(), whole.program_counter());
    }
}

#[test]
fn a_received_byte_is_echoed_by_an_interrupt() {
    const UART0_IRQ: usize = 20;
    let main = released()
        .store(IO_BANK0 + 4, 2)
        .store(IO_BANK0 + 12, 2)
        .store(CLOCKS + 0x30, 2)
        .store(CLOCKS + 0x48, 1 << 11)
        .store(UART0 + 0x24, 1)
        .store(UART0 + 0x2c, 0x60)
        .store(UART0 + 0x30, 0x301)
        .store(UART0 + 0x38, 1 << 4)
        .store(NVIC_ISER, 1 << UART0_IRQ)
        .sleep();
    // r1 = [UARTDR]; [UARTDR] = r1.
    let echo = Program::new().load(0, UART0).op(0x6801).op(0x6001).bx_lr();
    let mut chip = chip(main, &[(16 + UART0_IRQ, echo)]);
    chip.run_until(Ticks::from_millis(1));
    let mut echo = |stop_bit| {
        chip.uart_receive(0, stop_bit, 0x5a, LineErrors::NONE);
        assert_eq!(chip.next_event(), stop_bit);
        chip.run_until(stop_bit + Ticks::from_millis(1));
        let sent: Vec<_> = chip.take_transmitted(0).collect();
        assert_eq!((sent.len(), sent[0].byte), (1, 0x5a));
        (((sent[0].start - stop_bit).get() * 12).div_ceil(125), sent[0].end - sent[0].start)
    };
    // clk_sys is clk_ref, now the crystal: entry 15, the address 7, LDR 4; then comes the store. At
    // first the vector and the handler's first ten instructions come from flash, 50 cycles for each
    // of six words.
    let (cold, _) = echo(Ticks::from_millis(2));
    assert!((26 + 300..=28 + 300).contains(&cold), "{cold} cycles");
    let (warm, duration) = echo(Ticks::from_millis(4));
    assert!((26..=28).contains(&warm), "{warm} cycles");
    // 12 MHz / 16 is 750 kbaud.
    assert_eq!(duration.get(), 10 * 16 * 125 / 12 + 1);
    assert_eq!(chip.uart_overruns(0), 0);
    assert_eq!(chip.unmodelled_accesses().count(), 0);
}

#[test]
fn a_hanging_program_is_reset_by_the_watchdog_and_its_pins_let_go() {
    let main = output(released(), 3)
        .store(OUT_SET, 1 << 3)
        .store(CLOCKS + 0x30, 2)
        .store(PSM + 8, 0x1_fffc)
        .store(WATCHDOG + 0x2c, 1 << 9 | 12)
        .store(WATCHDOG + 4, 2 * 5000)
        .store(WATCHDOG, 1 << 30)
        .hang();
    let mut chip = chip(main, &[]);
    chip.watch_pins(1 << 3);
    chip.run_until(Ticks::from_micros(7_000));
    let resets: Vec<_> = chip.resets().iter().map(|r| r.reason).collect();
    assert_eq!(resets, [ResetReason::PowerOn, ResetReason::WatchdogTimer]);
    let reset_at = chip.resets()[1].at;
    // The program's 100 instructions come from flash first, at 6.5 MHz.
    assert!(reset_at > Ticks::from_micros(5_200) && reset_at < Ticks::from_micros(5_700), "{reset_at}");
    let levels: Vec<_> = chip.take_pin_edges().iter().map(|e| (e.level, e.at == reset_at)).collect();
    assert_eq!(
        levels,
        [(Level::High, false), (Level::Low, true), (Level::High, false)],
        "driven, pulled down by the reset, driven again by the restarted program"
    );
}

#[test]
fn a_forced_watchdog_reset_has_its_own_reason() {
    let main = Program::new().store(PSM + 8, 0x1_fffc).store(WATCHDOG, 1 << 31).hang();
    let mut chip = chip(main, &[]);
    chip.run_until(Ticks::from_micros(500));
    assert_eq!(chip.resets().last().map(|r| r.reason), Some(ResetReason::WatchdogForce));
}

#[test]
fn without_psm_wdsel_the_watchdog_resets_nothing() {
    let mut chip = chip(Program::new().store(WATCHDOG, 1 << 31).hang(), &[]);
    chip.run_until(Ticks::from_millis(1));
    assert_eq!(chip.resets().len(), 1);
}

#[test]
fn a_system_reset_request_restarts_the_core_and_leaves_the_pins() {
    let main = output(released(), 3).store(OUT_SET, 1 << 3).store(AIRCR, 0x05fa_0004).hang();
    let mut chip = chip(main, &[]);
    chip.watch_pins(1 << 3);
    chip.run_until(Ticks::from_millis(2));
    assert!(chip.resets().len() > 2);
    assert_eq!(chip.resets()[1].reason, ResetReason::SystemResetRequest);
    assert_eq!(chip.take_pin_edges().len(), 1, "high once and for all");
}

#[test]
fn a_panic_ends_in_the_fault_handler_and_a_second_one_in_lockup() {
    let undefined = Program::new().op(0xde00);
    let mut looping = chip(undefined.clone(), &[(3, Program::new().hang())]);
    looping.run_until(Ticks::from_millis(1));
    assert_eq!(looping.hard_faults(), 1);
    let fault = looping.last_hard_fault().expect("one fault");
    assert_eq!((fault.fault, fault.pc), (Fault::UndefinedInstruction, 0x1000_0200));
    assert!(!looping.is_locked_up());

    let mut locked = chip(undefined.clone(), &[(3, undefined)]);
    locked.run_until(Ticks::from_millis(1));
    assert!(locked.is_locked_up());
    assert_eq!((locked.hard_faults(), locked.next_event()), (2, Ticks::NEVER));
    assert_eq!(locked.now(), Ticks::from_millis(1), "time goes on");
}

#[test]
fn a_power_cycle_forgets_registers_and_ram_and_keeps_the_outside() {
    let main = output(released(), 3).store(OUT_SET, 1 << 3).store(0x2000_0000, 0x0102_0304).hang();
    let mut chip = chip(main, &[]);
    chip.set_pin_input(5, Level::High);
    chip.set_adc(1, 1234);
    chip.run_until(Ticks::from_millis(1));
    assert_eq!(chip.pin_output(3), Level::High);
    assert_eq!(chip.read_memory(0x2000_0000), Some(4));
    let executed = (chip.instructions(), chip.cycles());
    assert!(executed.1 > executed.0);
    chip.power_cycle();
    assert_eq!((chip.instructions(), chip.cycles()), executed, "both count since creation");
    assert_eq!(chip.now(), Ticks::from_millis(1).max(chip.now()));
    assert_eq!(chip.pin_output(3), Level::Floating);
    assert_eq!(chip.pin_level(5), Level::High);
    assert_eq!(chip.read_memory(0x2000_0000), Some(0xa5));
    assert_eq!(chip.program_counter(), 0x1000_0200);
    chip.run_until(Ticks::from_millis(2));
    assert_eq!(chip.pin_output(3), Level::High, "runs again");
    let resets: Vec<_> = chip.resets().iter().map(|r| r.reason).collect();
    assert_eq!(resets, [ResetReason::PowerOn; 2]);
}

#[test]
fn chips_can_be_copied_and_moved_to_threads() {
    fn assert_send<T: Send + Clone>() {}
    assert_send::<Chip>();
    let mut original = alarm_program();
    original.run_until(Ticks::from_millis(5));
    let mut copy = original.clone();
    original.run_until(Ticks::from_millis(10));
    copy.run_until(Ticks::from_millis(10));
    assert_eq!((copy.now(), copy.instructions()), (original.now(), original.instructions()));
}

#[test]
fn conversions_are_counted_and_sampled_at_their_start() {
    let main = released()
        .store(CLOCKS + 0x30, 2)
        // clk_adc from the crystal: 96 cycles of 12 MHz are 8 us.
        .store(CLOCKS + 0x60, 1 << 11 | 3 << 5)
        .store(ADC, 1 | 1 << 3)
        .hang();
    let mut chip = chip(main, &[]);
    chip.run_until(Ticks::from_millis(1));
    let before = chip.adc_conversions(0);
    chip.run_until(Ticks::from_millis(2));
    let after = chip.adc_conversions(0);
    assert_eq!(after.count - before.count, 125);
    assert_eq!(after.last_sampled - before.last_sampled, Ticks::from_millis(1));
    assert_eq!(chip.adc_conversions(1).count, 0);
}

#[test]
fn the_stack_figure_is_the_deepest_since_it_was_cleared() {
    // PUSH {r0-r7}; POP {r0-r7}; then a smaller one for ever: loop: PUSH {r0}; POP {r0}; B loop.
    let program = Program::new().op(0xb4ff).op(0xbcff).op(0xb401).op(0xbc01).op(0xe7fc);
    let mut chip = chip(program, &[]);
    chip.run_until(Ticks::from_micros(100));
    assert_eq!(chip.lowest_stack_pointer(), STACK - 32);
    chip.clear_lowest_stack_pointer();
    chip.run_until(Ticks::from_micros(200));
    assert_eq!(chip.lowest_stack_pointer(), STACK - 4);
}

/// Edges of a pin that a loop toggles stop and go on; a sleeping core wakes late, the alarm itself
/// is on time.
#[test]
fn a_stalled_processor_does_nothing_and_peripherals_go_on() {
    let program = output(released(), 25).load(0, OUT_XOR).load(1, 1 << 25);
    let mut toggling = chip(program.op(0x6001).op(0xe7fd), &[]);
    toggling.run_until(Ticks::from_micros(500));
    toggling.watch_pins(1 << 25);
    toggling.stall_until(Ticks::from_micros(600));
    assert_eq!(toggling.next_event(), Ticks::from_micros(600));
    toggling.run_until(Ticks::from_micros(599));
    assert_eq!((toggling.now(), toggling.take_pin_edges().len()), (Ticks::from_micros(599), 0));
    toggling.run_until(Ticks::from_micros(700));
    let first = toggling.take_pin_edges()[0].at;
    assert!(first >= Ticks::from_micros(600) && first < Ticks::from_micros(602), "{first:?}");

    let mut sleeping = alarm_program();
    sleeping.run_until(Ticks::from_micros(500));
    let before = sleeping.interrupts_taken(0);
    sleeping.stall_until(Ticks::from_micros(5_500));
    sleeping.run_until(Ticks::from_micros(5_499));
    assert_eq!(sleeping.interrupts_taken(0), before);
    sleeping.run_until(Ticks::from_micros(5_600));
    assert_eq!(sleeping.interrupts_taken(0), before + 1);
}

/// The processor runs until something is due, however far that is: where the caller stops it,
/// nothing changes.
#[test]
fn how_far_it_runs_at_a_time_changes_nothing() {
    let (mut at_once, mut in_steps) = (alarm_program(), alarm_program());
    let end = Ticks::from_millis(5);
    at_once.run_until(end);
    while in_steps.now() < end {
        in_steps.run_until(in_steps.now() + Ticks::new(1));
    }
    let seen = |chip: &Chip| {
        let registers: Vec<u32> = (0..16).map(|number| chip.register(number)).collect();
        let counted = [chip.instructions(), chip.cycles(), chip.now().get(), chip.interrupts_taken(0)];
        (registers, counted, chip.flash_accesses())
    };
    assert_eq!(seen(&at_once), seen(&in_steps));
    assert!(at_once.interrupts_taken(0) > 2);
}
