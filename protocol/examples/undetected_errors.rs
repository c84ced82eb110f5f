//! What the checked packets' CRC misses, exactly and by trial: the figures of docs/reliability.md.
//!
//! ```console
//! $ cargo run --release -p pneudrive-protocol --example undetected_errors
//! ```
//!
//! A linear code misses exactly those error patterns that are code words themselves. How many there
//! are of each weight follows from the weights of the 65,536 words of the dual code (MacWilliams'
//! identity), so the table below is exact for every number of flipped bits; the trials are
//! independent of it.

use pneudrive_protocol::{
    Address, CheckedError, CheckedPacket, Counts, Direction, PACKET_LEN, Packet, Sequence,
};

/// CRC-16/DNP's polynomial without its x^16.
const POLYNOMIAL: u16 = 0x3D65;
/// Up to which number of flipped bits the table goes.
const WEIGHTS: usize = 12;

fn main() {
    let of_packet = syndromes_of_packet();
    let missed = missed_by_weight(&of_packet);
    println!("flipped bits of {}: patterns, of which undetected", of_packet.len());
    for (weight, missed) in missed.iter().enumerate().take(WEIGHTS + 1).skip(1) {
        let all = choose(of_packet.len() as u32, weight as u32);
        println!("{weight:4} {all:16} {missed:12}  1 in {:.0}", all as f64 / *missed as f64);
    }
    println!("\nbit error rate: probability that a packet is damaged, and that the damage is missed");
    for rate in [1e-6, 1e-5, 1e-4, 1e-3, 1e-2] {
        let (damaged, undetected) = at_bit_error_rate(of_packet.len(), &missed, rate);
        println!("{rate:8.0e} {damaged:10.3e} {undetected:10.3e}");
    }
    println!(
        "\nbursts (first and last bit flipped, in the order in which a UART sends): how many of a length are missed"
    );
    for length in 1..=20 {
        let (bursts, missed) = bursts(&of_packet, length);
        println!("{length:4} {bursts:10} {missed:6}");
    }
    println!("\nreplaced by random bits, of the packet's form: {}", random_packets(1 << 26));
    println!("ten random bytes: {}", random_bytes(1 << 29));
    println!("\nthe polynomial alone: Hamming distance at a message of 135 and of 136 bits");
    for message in [135, 136] {
        let first = missed_by_weight(&syndromes_of_polynomial(message)).iter().skip(1).position(|&n| n > 0);
        println!("{message:4} {:?}", first.map(|index| index + 1));
    }
}

fn some_packet() -> CheckedPacket {
    let values = [300, 301, 302, 303].map(Counts::saturating);
    CheckedPacket { packet: Packet { address: Address::of_board(2), values }, sequence: Sequence::new(9) }
}

/// Difference between the CRC that comes and the one that should, for a flip of each of the 68 bits
/// that are not fixed by the form of a packet (address's high byte, bit 15 of data words), in the
/// order of a UART: least significant bit first.
fn syndromes_of_packet() -> Vec<u16> {
    let sent = some_packet().encode(Direction::Answer);
    let mut syndromes = Vec::new();
    for index in 1..PACKET_LEN {
        for bit in 0..8 {
            let mut bytes = sent;
            bytes[index] ^= 1 << bit;
            match CheckedPacket::decode(&bytes, Direction::Answer) {
                Err(CheckedError::Crc { expected, got }) => syndromes.push(expected ^ got),
                Err(CheckedError::Form(_)) => {}
                Ok(_) => syndromes.push(0),
            }
        }
    }
    syndromes
}

/// The same for a message of so many bits followed by its CRC.
fn syndromes_of_polynomial(message_bits: usize) -> Vec<u16> {
    let step = |word: u16| if word & 0x8000 == 0 { word << 1 } else { word << 1 ^ POLYNOMIAL };
    std::iter::successors(Some(1), |&word| Some(step(word))).take(message_bits + 16).collect()
}

/// How many error patterns of weight 0, 1, 2, .. have no syndrome: the code's weight distribution,
/// by MacWilliams' identity from that of its dual.
fn missed_by_weight(syndromes: &[u16]) -> Vec<u128> {
    let n = syndromes.len();
    let mut dual = vec![0_i128; n + 1];
    for mask in 0..=u16::MAX {
        dual[syndromes.iter().filter(|&&syndrome| (syndrome & mask).count_ones() % 2 == 1).count()] += 1;
    }
    (0..=WEIGHTS.min(n))
        .map(|weight| {
            let sum: i128 = dual
                .iter()
                .enumerate()
                .map(|(j, &words)| words * krawtchouk(n as u32, weight as u32, j as u32))
                .sum();
            (sum >> 16) as u128
        })
        .collect()
}

fn krawtchouk(n: u32, weight: u32, j: u32) -> i128 {
    (0..=weight)
        .map(|i| {
            let term = (choose(j, i) * choose(n - j, weight - i)) as i128;
            if i % 2 == 0 { term } else { -term }
        })
        .sum()
}

fn choose(n: u32, k: u32) -> u128 {
    if k > n {
        return 0;
    }
    (0..u128::from(k)).fold(1, |product, i| product * (u128::from(n) - i) / (i + 1))
}

/// Probability of any damage and of undetected damage where every bit is flipped with this
/// probability. Patterns of more than [`WEIGHTS`] bits are taken at one in 65,536.
fn at_bit_error_rate(n: usize, missed: &[u128], rate: f64) -> (f64, f64) {
    let of_weight = |weight: usize| rate.powi(weight as i32) * (1.0 - rate).powi((n - weight) as i32);
    let light: f64 = (1..=WEIGHTS).map(|weight| missed[weight] as f64 * of_weight(weight)).sum();
    let heavy: f64 =
        (WEIGHTS + 1..=n).map(|weight| choose(n as u32, weight as u32) as f64 * of_weight(weight)).sum();
    (1.0 - of_weight(0), light + heavy / 65_536.0)
}

/// All bursts of this length: how many there are, and how many are missed.
fn bursts(syndromes: &[u16], length: usize) -> (u64, u64) {
    let (mut all, mut missed) = (0, 0);
    for window in syndromes.windows(length) {
        for inner in 0..1_u64 << length.saturating_sub(2) {
            let pattern = if length == 1 { 1 } else { 1 | inner << 1 | 1 << (length - 1) };
            let syndrome =
                (0..length).filter(|bit| pattern >> bit & 1 == 1).fold(0, |s, bit| s ^ window[bit]);
            all += 1;
            missed += u64::from(syndrome == 0);
        }
    }
    (all, missed)
}

/// xorshift64*: good enough to hit 2^-16 evenly, and no dependency.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        self.0.wrapping_mul(0x2545_F491_4F6C_DD1D)
    }

    fn packet(&mut self) -> [u8; PACKET_LEN] {
        let (low, high) = (self.next().to_be_bytes(), self.next().to_be_bytes());
        std::array::from_fn(|index| if index < 8 { low[index] } else { high[index - 8] })
    }
}

fn accepted(tries: u64, mut bytes: impl FnMut() -> [u8; PACKET_LEN]) -> String {
    let accepted = (0..tries).filter(|_| CheckedPacket::decode(&bytes(), Direction::Answer).is_ok()).count();
    format!("{accepted} of {tries} accepted, 1 in {:.0}", tries as f64 / accepted as f64)
}

fn random_packets(tries: u64) -> String {
    let mut random = Random(1);
    accepted(tries, || {
        let mut bytes = random.packet();
        bytes[0] = 0xFF;
        bytes[2..].iter_mut().step_by(2).for_each(|byte| *byte &= 0x7F);
        bytes
    })
}

fn random_bytes(tries: u64) -> String {
    let mut random = Random(2);
    accepted(tries, || random.packet())
}
