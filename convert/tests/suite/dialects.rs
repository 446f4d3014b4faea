//! The same table in every dialect gives the same recording, and no bytes make it panic.

use crate::log::{COLUMNS, Written, converted, encoder, order, plain, text};
use convert::{Asked, Order};
use proptest::prelude::*;
use std::fmt::Write as _;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn a_table_is_the_same_in_every_dialect(
        separator in prop::sample::select(vec![",", ";", "\t", "  "]),
        decimal_comma: bool,
        crlf: bool,
        mark: bool,
        quoted: bool,
        trailing: bool,
        header in prop::sample::select(vec!["", "# ", "made on Monday\n\n", "# one comment\n"]),
    ) {
        let rows = &encoder()[..400];
        // Blanks neither quote nor end a row.
        let blanks = separator == "  ";
        let written = Written {
            separator,
            // Where commas separate, a decimal comma stands in quotation marks.
            quoted: !blanks && (quoted || (decimal_comma && separator == ",")),
            decimal_comma,
            line_end: if crlf { "\r\n" } else { "\n" },
            mark,
            header,
            trailing: trailing && !blanks,
        };
        let wanted = converted(&text(rows, &plain()), &order(&COLUMNS)).unwrap();
        let found = converted(&text(rows, &written), &order(&COLUMNS)).unwrap();
        prop_assert_eq!(found.recording, wanted.recording);
    }

    #[test]
    fn no_bytes_make_it_panic(bytes in prop::collection::vec(any::<u8>(), 0..300), spec in ".{0,20}") {
        let _ = converted(&bytes, &order(&[]));
        let table = [b"t_s,p1_m,ref_x_m\n0,1,2\n".as_slice(), &bytes].concat();
        let _ = converted(&table, &order(&[]));
        if let Ok(asked) = Asked::parse(&format!("ref_y_m={spec}")) {
            let _ = converted(&table, &Order { columns: vec![asked], ..order(&[]) });
        }
    }

    #[test]
    fn numbers_of_any_kind_end_in_a_recording_or_in_one_line(
        rows in prop::collection::vec(prop::array::uniform4(prop_oneof![
            (-3_i32..3).prop_map(f64::from), any::<f64>(), -1.0e-3..1.0e-3_f64, Just(f64::NAN)
        ]), 1..40),
        rate: bool,
    ) {
        let mut log = String::from("time;sin;cos;stage\n");
        for [t, s, c, x] in rows {
            writeln!(log, "{t};{s};{c};{x}").unwrap();
        }
        let asked = Order { rate_hz: rate.then_some(100.0), ..order(if rate { &COLUMNS[1..] } else { &COLUMNS }) };
        if let Err(line) = converted(log.as_bytes(), &asked) {
            prop_assert!(line.starts_with("log.csv:") && !line.contains('\n'), "{line}");
        }
    }
}
