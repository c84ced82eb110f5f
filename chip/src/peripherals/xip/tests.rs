use super::*;

const FLASH: u32 = 0x1000_0000;
/// Distance of addresses that share a set.
const STRIDE: u32 = 8 * SETS as u32;

#[test]
fn a_miss_fetches_half_a_line() {
    let mut xip = Xip::default();
    assert!(!xip.access(FLASH));
    assert!(xip.access(FLASH));
    assert!(!xip.access(FLASH + 4), "the other half");
    assert!(xip.access(FLASH + 4) && xip.access(FLASH), "both are kept");
    assert!(!xip.access(FLASH + 8), "the next line");
    assert_eq!(xip.counters(), (6, 3));
}

#[test]
fn two_lines_of_a_set_stay_and_a_third_replaces_the_one_used_less_recently() {
    let mut xip = Xip::default();
    assert!(!xip.access(FLASH) && !xip.access(FLASH + STRIDE));
    assert!(xip.access(FLASH) && xip.access(FLASH + STRIDE) && xip.access(FLASH));
    assert!(!xip.access(FLASH + 2 * STRIDE));
    assert!(xip.access(FLASH), "used last");
    assert!(!xip.access(FLASH + STRIDE));
}

#[test]
fn it_holds_16_kib() {
    let mut xip = Xip::default();
    let words = || (0..16 * 1024).step_by(4).map(|offset| FLASH + offset);
    assert!(words().all(|address| !xip.access(address)));
    assert!(words().all(|address| xip.access(address)));
    assert!(!xip.access(FLASH + 16 * 1024));
}

#[test]
fn aliases_differ_in_lookup_and_allocation() {
    let mut xip = Xip::default();
    assert!(!xip.access(FLASH | NO_ALLOCATE) && !xip.access(FLASH), "not kept");
    assert!(xip.access(FLASH | NO_ALLOCATE));
    assert!(!xip.access(FLASH | NO_LOOKUP), "never looked up");
    assert!(!xip.access((FLASH + 8) | NO_LOOKUP) && xip.access(FLASH + 8), "but kept");
}

#[test]
fn a_write_gives_up_one_word() {
    let mut xip = Xip::default();
    assert!(!xip.access(FLASH) && !xip.access(FLASH + 4));
    assert!(xip.invalidate(FLASH));
    assert!(!xip.access(FLASH) && xip.access(FLASH + 4));
    assert!(!xip.invalidate(FLASH | NO_ALLOCATE), "an error by default");
    assert_eq!(xip.write(CTRL, RegisterWrite::plain(ENABLE), Ticks::ZERO), Written::Done);
    assert!(xip.invalidate(FLASH | NO_ALLOCATE), "ignored");
    assert!(xip.access(FLASH));
}

#[test]
fn switched_off_it_counts_accesses_and_has_nothing() {
    let mut xip = Xip::default();
    assert!(!xip.access(FLASH));
    assert_eq!(xip.write(CTRL, RegisterWrite::plain(ENABLE | POWER_DOWN), Ticks::ZERO), Written::Done);
    assert_eq!(xip.read(CTRL, Ticks::ZERO), Some(POWER_DOWN), "powered down it cannot be enabled");
    assert!(!xip.access(FLASH));
    assert_eq!((xip.read(CTR_ACC, Ticks::ZERO), xip.read(CTR_HIT, Ticks::ZERO)), (Some(2), Some(0)));
}

#[test]
fn a_flush_empties_it_and_any_write_clears_a_counter() {
    let mut xip = Xip::default();
    assert!(!xip.access(FLASH) && xip.access(FLASH));
    assert_eq!(xip.write(FLUSH, RegisterWrite::plain(1), Ticks::new(1024)), Written::Done);
    assert_eq!(xip.read(STAT, Ticks::new(1023)), Some(STREAM_FIFO_EMPTY));
    assert_eq!(xip.read(STAT, Ticks::new(1024)), Some(STREAM_FIFO_EMPTY | FLUSH_READY));
    assert!(!xip.access(FLASH));
    assert_eq!(xip.counters(), (3, 1));
    assert_eq!(xip.write(CTR_ACC, RegisterWrite::plain(7), Ticks::ZERO), Written::Done);
    assert_eq!(xip.write(CTR_HIT, RegisterWrite::plain(0), Ticks::ZERO), Written::Done);
    assert_eq!(xip.counters(), (0, 0));
    assert_eq!(xip.write(0x14, RegisterWrite::plain(0), Ticks::ZERO), Written::NotModelled, "STREAM_ADDR");
}

fn access_by_looking_at_both(xip: &mut Xip, address: u32) -> bool {
    xip.accesses += 1;
    xip.access_elsewhere(address)
}

/// Sequential code, jumps, data between them, every alias, and what empties the cache.
#[test]
fn the_look_at_one_way_first_changes_no_hit() {
    let mut random = 1_u64;
    let mut next = |bound: u64| {
        random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (random >> 33) % bound
    };
    let (mut short, mut whole) = (Xip::default(), Xip::default());
    let mut address = FLASH;
    for step in 0..200_000 {
        address = match next(16) {
            0 => FLASH + 4 * next(12) as u32 + STRIDE * next(4) as u32,
            1..=8 => address + 4,
            _ => address,
        };
        let alias = [0, 0, 0, 0, NO_ALLOCATE, NO_LOOKUP, NO_ALLOCATE | NO_LOOKUP][next(7) as usize];
        let access = address | alias;
        match next(200) {
            0 => assert_eq!(short.invalidate(access), whole.invalidate(access)),
            1 => [&mut short, &mut whole].into_iter().for_each(|xip| xip.flush(Ticks::ZERO)),
            2..=3 => {
                let write = RegisterWrite::plain([0, ENABLE, ENABLE, POWER_DOWN][next(4) as usize]);
                let both = [&mut short, &mut whole].map(|xip| xip.write(CTRL, write, Ticks::ZERO));
                assert_eq!(both, [Written::Done; 2]);
            }
            _ => assert_eq!(
                short.access(access),
                access_by_looking_at_both(&mut whole, access),
                "step {step}, {access:#x}"
            ),
        }
    }
    assert_eq!(short.counters(), whole.counters());
    let (accesses, hits) = short.counters();
    assert!(hits > accesses / 10 && hits < accesses * 9 / 10, "{hits} of {accesses}");
}
