//! Whatever the writer accepts, the reader gives back, bit for bit; and no text makes the reader panic.

use proptest::prelude::*;
use recording::{
    Coordination, Electronics, Existing, Geometry, Logged, Meta, Names, Recording, Row, Samples,
};

fn meta() -> Meta {
    Meta {
        device: "board \"7\"\nsecond line".into(),
        source: "ünïcode, commas".into(),
        names: Names {
            courier_id: "7 \"seven\"".into(),
            platen_id: "granite = 2".into(),
            beacon_id: String::new(),
            firmware: "1.2.3".into(),
        },
        geometry: Geometry {
            pitch_m: 1.016e-3,
            span_m: Some(9.7e-3),
            lateral_m: Some(-3.0e-3),
        },
        coordination: Some(Coordination {
            height_m: 0.05,
            lever_x_m: 0.09,
            lever_y_m: -0.005,
            tan_full_scale: 0.1,
        }),
        electronics: Electronics {
            adc_bits: Some(16),
            amplitude_counts: Some(20_000.0),
            quadrature_noise_counts: Some(3.3),
            psd_sum_counts: Some(30_000.0),
            psd_noise_counts: Some(0.0),
            position_noise_m: Some(1.0e-7),
        },
    }
}

type Fields = (
    [Option<[i16; 2]>; 4],
    [Option<i32>; 4],
    [Option<f64>; 4],
    Option<[i16; 4]>,
    Option<f64>,
    [Option<f64>; 3],
);

fn fields() -> impl Strategy<Value = (f64, String, Fields)> {
    use prop::array::{uniform3, uniform4};
    let teeth = prop::option::of(-i32::MAX..=i32::MAX);
    let length = || prop::option::of(prop_oneof![-1000.0..1000.0f64, -1e-6..1e-6f64, Just(-0.0)]);
    let pair = prop::option::of(any::<[i16; 2]>());
    let other = (
        uniform4(pair),
        uniform4(teeth),
        uniform4(length()),
        prop::option::of(any::<[i16; 4]>()),
        prop::option::of(-273.0..500.0f64),
        uniform3(length()),
    );
    (
        1e-6..100.0f64,
        "[a-zA-Z0-9_,;\" éß#]{0,12}".prop_map(|name| name.trim().to_owned()),
        other,
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn what_is_written_is_read(rows in prop::collection::vec(fields(), 1..20)) {
        let mut samples = Samples::default();
        let mut t_s = -1000.0;
        for (step_s, run, (quadrature, teeth, position_m, electrodes, temperature_c, lengths)) in &rows {
            t_s += step_s;
            samples.push(&Row {
                t_s,
                run,
                quadrature_counts: quadrature.map(|pair| pair.map(|pair| pair.map(f64::from))),
                teeth: *teeth,
                position_m: *position_m,
                electrode_counts: electrodes.map(|counts| counts.map(f64::from)),
                temperature_c: *temperature_c,
                commanded: *lengths,
                reference: [lengths[2], lengths[0], lengths[1]],
            });
        }
        let measured = (0..4).any(|segment| samples.has_segment(segment));
        let recording = Recording { meta: meta(), samples, warnings: Vec::new() };
        let parent = tempfile::tempdir().unwrap();
        let folder = parent.path().join("new");
        let written = recording.write(&folder, Existing::Refuse);
        if measured {
            written.unwrap();
            let read = Recording::read(&folder).unwrap();
            prop_assert_eq!(read, recording);
        }
    }

    #[test]
    fn no_text_makes_the_reader_panic(toml in ".{0,80}", bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        let parent = tempfile::tempdir().unwrap();
        std::fs::write(parent.path().join("recording.toml"), &toml).unwrap();
        prop_assert!(Recording::read(parent.path()).is_err());
        let good = "schema = 1\n[geometry]\npitch_m = 1e-3\n[electronics]\nposition_noise_m = 1e-8\n";
        std::fs::write(parent.path().join("recording.toml"), good).unwrap();
        std::fs::write(parent.path().join("samples.csv"), [b"t_s,p1_m\n", bytes.as_slice()].concat()).unwrap();
        if let Err(error) = Recording::read(parent.path()) {
            prop_assert!(!error.to_string().contains(['\n', '\r']));
        }
    }
}

/// A quantity that is logged beside the layout's columns comes back as it was, and what is no number in it is refused.
#[test]
fn quantities_beside_the_layout_come_back() {
    let mut samples = Samples::default();
    for k in 0..3 {
        samples.push(&Row {
            t_s: f64::from(k),
            position_m: [Some(1.0e-3 * f64::from(k)), None, None, None],
            ..Row::default()
        });
    }
    samples.log(Logged {
        name: "aux_drive_a".into(),
        values: vec![0.5, f64::NAN, -3.0],
    });
    samples.log(Logged {
        name: "aux_nothing".into(),
        values: Vec::new(),
    });
    let recording = Recording {
        meta: meta(),
        samples,
        warnings: Vec::new(),
    };
    let parent = tempfile::tempdir().unwrap();
    let folder = parent.path().join("new");
    recording.write(&folder, Existing::Refuse).unwrap();
    let read = Recording::read(&folder).unwrap();
    assert_eq!(read.samples.logged().len(), 1);
    assert_eq!(read, recording);
    let file = folder.join("samples.csv");
    let text = std::fs::read_to_string(&file).unwrap();
    std::fs::write(&file, text.replace("-3", "strong")).unwrap();
    let error = Recording::read(&folder).unwrap_err().to_string();
    assert!(
        error.contains("row 4, column aux_drive_a, found \"strong\""),
        "{error}"
    );
}
