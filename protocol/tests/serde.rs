//! Feature `serde`: packets as others store and send them.

use pneudrive_protocol::{Address, Counts, Packet};

#[test]
fn a_packet_is_the_boards_number_and_four_counts() {
    let packet =
        Packet { address: Address::of_board(2), values: [0, 102, 1023, 512].map(Counts::saturating) };
    let text = serde_json::to_string(&packet).unwrap();
    assert_eq!(text, r#"{"address":2,"values":[0,102,1023,512]}"#);
    assert_eq!(serde_json::from_str::<Packet>(&text).unwrap(), packet);
}

#[test]
fn what_cannot_be_on_the_bus_is_refused() {
    let error = serde_json::from_str::<Counts>("1024").unwrap_err().to_string();
    assert!(error.contains("1024 is not a 10-bit ADC reading"), "{error}");
    assert!(serde_json::from_str::<Address>("256").is_err());
}
