use super::*;
use pneudrive_host::notices::NoticeKind;
use pneudrive_host::poller::{BoardRow, BoardSensors, BoardState, DriveReading, Outcome, Reading, VENTED};

#[test]
fn rows_in_the_measured_data_format() {
    let command = [102, 221, 340, 922].map(|value| Counts::new(value).unwrap());
    let counts = [102, 103, 340, 0].map(|value| Counts::new(value).unwrap());
    let reading = Some(Reading { counts, kpa: [0.0; 4], asked_ns: 0 });
    let motion = Motion {
        acceleration_m_s2: [0.01, -9.81, 0.0],
        angular_rate_rad_s: [1.0, -0.0025, 0.0],
        asked_ns: 9,
    };
    let sensors = BoardSensors {
        supply: Some(SupplyPressure { kpa: 549.87, measured_ns: 8 }),
        motion: Some(motion),
        electronics: Some(ElectronicsReading { chip_c: Some(41.8), rail_v: None, asked_ns: 9 }),
        motion_is_new: true,
        ..BoardSensors::default()
    };
    let board = |outcome| BoardRow {
        board: 0,
        command,
        wanted: command,
        outcome,
        reading,
        drives: (outcome == Outcome::Fresh)
            .then(|| DriveReading { drives: Drives::new([400, -400, 0, 1]), asked_ns: 9 }),
        sensors: BoardSensors {
            supply_is_new: outcome == Outcome::Fresh,
            electronics_is_new: outcome == Outcome::Fresh,
            ..sensors
        },
        state: BoardState::Present,
    };
    let mut batch = Batch::default();
    for (cycle, outcome) in [(0, Outcome::Fresh), (1, Outcome::Lost), (2, Outcome::NotAsked)] {
        if cycle == 1 {
            let text = "board 0 is missing (\"no answer\")".to_owned();
            let notice = Notice { kind: NoticeKind::BoardMissing, board: Some(0), text };
            batch.happened(RecordedEvent { at_ns: 5, since_start_ns: 1_000_200_000, notice });
        }
        let other = BoardRow { board: 1, command: VENTED, ..board(Outcome::Lost) };
        let boards = [board(outcome), other];
        let since_start_ns = cycle * 1_000_200_000;
        batch.push(&Row { cycle, at_ns: 5, since_start_ns, boards: &boards });
    }
    let formatter = Formatter::new(&[0, 1], &Calibration::default(), PageColumns::default());
    let mut text = formatter.header();
    formatter.append(&batch, &mut text);
    let expected = "\
t_s,b0_cmd0_kpa,b0_cmd1_kpa,b0_cmd2_kpa,b0_cmd3_kpa,b0_p0_kpa,b0_p1_kpa,b0_p2_kpa,b0_p3_kpa,\
b1_cmd0_kpa,b1_cmd1_kpa,b1_cmd2_kpa,b1_cmd3_kpa,b1_p0_kpa,b1_p1_kpa,b1_p2_kpa,b1_p3_kpa
0.000000000,0.000,99.819,199.975,689.812,-0.337,0.505,199.975,-86.184,0.000,0.000,0.000,0.000,,,,
# event: {\"t_s\":1.0002,\"kind\":\"board_missing\",\"board\":0,\"text\":\"board 0 is missing (\\\"no answer\\\")\"}
1.000200000,0.000,99.819,199.975,689.812,,,,,0.000,0.000,0.000,0.000,,,,
2.000400000,0.000,99.819,199.975,689.812,,,,,0.000,0.000,0.000,0.000,,,,
";
    assert_eq!(String::from_utf8(text).unwrap(), expected);
    let drives = PageColumns { drives: true, sensors: false };
    let with_drives = Formatter::new(&[0, 1], &Calibration::default(), drives);
    let header = String::from_utf8(with_drives.header()).unwrap();
    assert!(header.contains(",b0_p3_kpa,b0_u0,b0_u1,b0_u2,b0_u3,b1_cmd0_kpa,"), "{header}");
    assert!(header.ends_with(",b1_p3_kpa,b1_u0,b1_u1,b1_u2,b1_u3\n"), "{header}");
    let mut text = Vec::new();
    with_drives.append(&batch, &mut text);
    let text = String::from_utf8(text).unwrap();
    let ends: Vec<_> = text.lines().map(|line| line.split_once("-86.184,").map(|(_, end)| end)).collect();
    let fresh = "1.0000,-1.0000,0.0000,0.0025,0.000,0.000,0.000,0.000,,,,,,,,";
    assert_eq!(ends, [Some(fresh), None, None, None]);
    assert!(text.ends_with(",689.812,,,,,,,,,0.000,0.000,0.000,0.000,,,,,,,,\n"), "{text}");
    let pages = PageColumns { drives: false, sensors: true };
    let with_sensors = Formatter::new(&[0], &Calibration::default(), pages);
    let header = String::from_utf8(with_sensors.header()).unwrap();
    let names = ",b0_p3_kpa,b0_supply_kpa,b0_ax_m_s2,b0_ay_m_s2,b0_az_m_s2,b0_gx_rad_s,b0_gy_rad_s,b0_gz_rad_s,b0_chip_c,b0_rail_v\n";
    assert!(header.ends_with(names), "{header}");
    let mut batch = Batch::default();
    for (cycle, outcome) in [(0, Outcome::Fresh), (1, Outcome::Lost)] {
        batch.push(&Row { cycle, at_ns: 5, since_start_ns: 0, boards: &[board(outcome)] });
    }
    let mut text = Vec::new();
    with_sensors.append(&batch, &mut text);
    let text = String::from_utf8(text).unwrap();
    let motion = "0.01,-9.81,0.00,1.0000,-0.0025,0.0000";
    let ends: Vec<_> = text.lines().map(|line| line.split_once(",689.812,").unwrap().1).collect();
    assert_eq!(ends[0], format!("-0.337,0.505,199.975,-86.184,549.87,{motion},41.8,"));
    // The old supply pressure and temperature are none of this cycle.
    assert_eq!(ends[1], format!(",,,,,{motion},,"));
}
