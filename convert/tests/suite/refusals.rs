//! What cannot be converted is refused with its place in the log.

use crate::log::{COLUMNS, converted, order};
use convert::Order;

#[test]
fn errors_name_row_and_column_of_the_log() {
    for (log, columns, wanted) in [
        (
            "time;sin;cos\n0;1;2\n1;x;2\n",
            &COLUMNS[..3],
            "log.csv: row 3, column sin, found \"x\", wanted a number",
        ),
        (
            "time;sin;cos\n0;1;2\n0;1;2\n",
            &COLUMNS[..3],
            "log.csv: row 3, column time, found 0, wanted a time after the row before, 0; --rate-hz",
        ),
        (
            "time;sin;cos\n0;1;2\n;1;2\n",
            &COLUMNS[..3],
            "log.csv: row 3, column time, found no time, wanted one in every row; --rate-hz",
        ),
        (
            "time;sin;cos\n0;1;2\n1;1\n2;1;2\n",
            &COLUMNS[..3],
            "log.csv: row 3, found 2 fields, wanted 3 as in the other rows",
        ),
        (
            "time;sin;cos\n0;1;2\n",
            &["t_s=time", "q1s=sin"],
            "found nothing for q1c, wanted --column q1c=COLUMN",
        ),
        (
            "time;sin;cos\n0;1;2\n",
            &["t_s=time"],
            "found nothing for any segment",
        ),
        (
            "time;sin;cos\n0;1;2\n",
            &["t_s=time", "q1s=sinus", "q1c=cos"],
            "found no column \"sinus\", wanted one of \"time\", \"sin\", \"cos\"",
        ),
        (
            "a;sin;cos\n0;1;2\n",
            &["q1s=sin", "q1c=cos"],
            "found no column of time, wanted --column t_s=",
        ),
        (
            "time;p1_m\n0;5000\n",
            &["t_s=time"],
            "row 2, column p1_m (for p1_m), found 5000, wanted -1000 to 1000 m",
        ),
    ] {
        let stated = convert::Stated {
            position_noise_m: Some(1.0e-8),
            noise_counts: Some(1.0),
            ..Default::default()
        };
        let error = converted(
            log.as_bytes(),
            &Order {
                stated,
                ..order(columns)
            },
        )
        .unwrap_err();
        assert!(error.contains(wanted), "{log:?}: {error}");
    }
    let none = Order {
        pitch_m: None,
        ..order(&COLUMNS[..3])
    };
    assert!(
        converted(b"time;sin;cos\n0;1;2\n1;1;2\n", &none)
            .unwrap_err()
            .contains("--pitch LENGTH")
    );
}
