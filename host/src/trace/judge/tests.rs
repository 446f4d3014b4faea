//! Lines as the board makes them, seen by an instrument, and with one fault each.

use super::super::Signal;
use super::super::limits::FRAME_BITS;
use super::*;

const US: f64 = 1.0e-6;
const CONVERSIONS: usize = 8;
/// 100 MS/s.
const STEP_S: f64 = 1.0e-8;

/// One conversion's edges of every line, seconds after CONVST.
#[derive(Clone, Debug)]
struct Board {
    convst: Vec<f64>,
    busy: Vec<f64>,
    select: [Vec<f64>; 2],
    clock: [Vec<f64>; 2],
}

/// A burst of clocks from an instant on, low in the second half of each period.
fn burst(from_s: f64, bits: usize, frequency_hz: f64) -> Vec<f64> {
    (1..=2 * bits)
        .map(|half| from_s + half as f64 * 0.5 / frequency_hz)
        .collect()
}

const GOOD_HZ: f64 = 21.25e6;

/// As the model of the chip has them.
fn good() -> Board {
    let clock = |from_s| burst(from_s, FRAME_BITS, GOOD_HZ);
    Board {
        convst: vec![0.0, 0.5 * US],
        busy: vec![0.0, 0.9 * US],
        select: [vec![1.5 * US, 8.8 * US], vec![1.52 * US, 8.82 * US]],
        clock: [clock(1.7 * US), clock(1.75 * US)],
    }
}

/// A recording of conversions, one every 50 µs and the first after 3 µs, as `of` makes each from the good one. Each edge is seen at the
/// instrument's next look.
fn recorded(step_s: f64, of: impl Fn(usize, &mut Board)) -> (Lines, Span) {
    let boards: Vec<Board> = (0..CONVERSIONS)
        .map(|number| {
            let mut board = good();
            of(number, &mut board);
            board
        })
        .collect();
    let signal = |first, edges: &dyn Fn(&Board) -> Vec<f64>| {
        let seen = boards.iter().enumerate().flat_map(|(number, board)| {
            let begin_s = 3.0 * US + PERIOD_S * number as f64;
            edges(board)
                .into_iter()
                .map(move |at_s| ((begin_s + at_s) / step_s).ceil() * step_s)
        });
        // What changes between two looks is not seen.
        let mut edges_s: Vec<f64> = vec![];
        for at_s in seen {
            match edges_s.last() {
                Some(last) if (last - at_s).abs() < 0.5 * step_s => drop(edges_s.pop()),
                _ => edges_s.push(at_s),
            }
        }
        Signal::new(first, edges_s)
    };
    let mut lines = Lines::default();
    lines.put(Line::Convst, signal(false, &|board| board.convst.clone()));
    lines.put(Line::Busy, signal(false, &|board| board.busy.clone()));
    for chip in 0..2 {
        lines.put(
            Line::Select(chip),
            signal(true, &|board| board.select[chip].clone()),
        );
        lines.put(
            Line::Clock(chip),
            signal(true, &|board| board.clock[chip].clone()),
        );
        lines.put(
            Line::Data(chip),
            signal(false, &|_| vec![3.0 * US, 4.0 * US]),
        );
    }
    lines.put(Line::Reset, Signal::default());
    lines.put(Line::Nrst, Signal::new(true, vec![]));
    let end_s = PERIOD_S * CONVERSIONS as f64;
    (
        lines,
        Span {
            begin_s: 0.0,
            end_s,
            step_s,
        },
    )
}

/// Names of the steps with this verdict.
fn steps((lines, span): &(Lines, Span), passed: Option<bool>) -> Vec<&'static str> {
    let steps = judge(lines, *span);
    let chosen = steps.into_iter().filter(|step| step.passed == passed);
    chosen.map(|step| step.step).collect()
}

#[test]
fn a_good_board_passes_what_a_trace_can_show_at_any_instruments_rate() {
    for step_s in [1.0e-12, 2.0e-9, STEP_S, 2.0e-8] {
        let seen = recorded(step_s, |_, _| {});
        assert_eq!(steps(&seen, Some(false)), [""; 0], "{step_s}");
        assert_eq!(steps(&seen, None), ["CONVST edges"], "{step_s}");
    }
}

/// The clock of a real board is not exact: all times are longer alike.
#[test]
fn a_board_with_a_slow_clock_passes_up_to_what_its_oscillator_may_be_off() {
    let scaled = |factor: f64| {
        let (lines, span) = recorded(STEP_S, |_, _| {});
        let mut scaled = Lines::default();
        for line in [Line::Convst, Line::Busy, Line::Select(0), Line::Clock(0)] {
            let signal = lines.get(line).unwrap();
            let edges_s = signal.edges_s().iter().map(|at_s| factor * at_s).collect();
            scaled.put(line, Signal::new(signal.first(), edges_s));
        }
        (
            scaled,
            Span {
                end_s: factor * span.end_s,
                ..span
            },
        )
    };
    assert_eq!(steps(&scaled(1.018), Some(false)), [""; 0]);
    assert_eq!(steps(&scaled(0.982), Some(false)), [""; 0]);
    assert_eq!(
        steps(&scaled(1.025), Some(false)),
        ["CONVST period", "SCLK0 frequency"]
    );
}

/// A fault: its name, what it does to one conversion of all, and the steps that fail.
type Fault = (&'static str, fn(usize, &mut Board), &'static [&'static str]);

/// Conversion 4 has it, where it is not in all.
const FAULTS: &[Fault] = &[
    (
        "CONVST is too short",
        |_, b| b.convst[1] = 0.1 * US,
        &["CONVST width"],
    ),
    (
        "one pulse of CONVST is too long",
        |n, b| b.convst[1] += if n == 4 { 0.2 * US } else { 0.0 },
        &["CONVST width"],
    ),
    (
        "a conversion is not started",
        |n, b| {
            if n == 4 {
                b.convst.clear();
                b.busy.clear();
                b.select = [vec![], vec![]];
                b.clock = [vec![], vec![]]
            }
        },
        &["CONVST pulses"],
    ),
    (
        "CONVST is made by software",
        |n, b| {
            if n == 4 {
                b.convst.iter_mut().for_each(|at_s| *at_s -= 0.2 * US)
            }
        },
        &["CONVST jitter", "BUSY after CONVST"],
    ),
    (
        "BUSY is silent once",
        |n, b| {
            if n == 4 {
                b.busy.clear()
            }
        },
        &["BUSY pulses"],
    ),
    (
        "BUSY is late",
        |n, b| {
            if n == 4 {
                b.busy[0] = 0.06 * US
            }
        },
        &["BUSY after CONVST"],
    ),
    (
        "oversampling is on",
        |_, b| {
            b.busy[1] += 1.2 * US;
            for chip in 0..2 {
                for edges in [&mut b.select[chip], &mut b.clock[chip]] {
                    edges.iter_mut().for_each(|at_s| *at_s += 1.2 * US)
                }
            }
        },
        &["BUSY width"],
    ),
    (
        "a chip select comes late",
        |n, b| {
            if n == 4 {
                b.select[1][0] = 2.6 * US;
                b.clock[1] = burst(2.6 * US, FRAME_BITS, 25.0e6)
            }
        },
        &[
            "CS1 after BUSY",
            "CS0 to CS1",
            "CS1 width",
            "SCLK1 frequency",
        ],
    ),
    (
        "a chip select stays low",
        |n, b| {
            if n > 3 {
                b.select[0] = if n == 4 { vec![1.5 * US] } else { vec![] }
            }
        },
        &["CS0 frames", "CS0 width"],
    ),
    (
        "a chip is not read",
        |n, b| {
            if n == 4 {
                b.select[1].clear()
            }
        },
        &["CS1 frames", "SCLK1 at rest"],
    ),
    (
        "a bus has half its clock",
        |_, b| {
            b.clock[0] = burst(1.7 * US, FRAME_BITS, GOOD_HZ / 2.0);
            b.select[0][1] = 16.0 * US
        },
        &["CS0 width", "SCLK0 frequency"],
    ),
    (
        "a bit is missing",
        |n, b| {
            if n == 4 {
                b.clock[1].truncate(2 * FRAME_BITS - 2)
            }
        },
        &["SCLK1 bits"],
    ),
    (
        "a clock after the frame",
        |n, b| {
            if n == 4 {
                b.clock[0].extend([20.0 * US, 20.1 * US])
            }
        },
        &["SCLK0 at rest"],
    ),
];

#[test]
fn each_fault_fails_its_own_steps_and_is_placed() {
    for (name, fault, wanted) in FAULTS {
        let seen = recorded(STEP_S, fault);
        assert_eq!(&steps(&seen, Some(false)), wanted, "{name}");
        let failed = judge(&seen.0, seen.1)
            .into_iter()
            .filter(|step| step.passed == Some(false));
        for step in failed {
            let at_s = step.at_s.expect("where it is");
            assert!((0.0..seen.1.end_s).contains(&at_s), "{name}: {step:?}");
        }
    }
}

#[test]
fn a_fault_of_one_conversion_is_told_with_its_instant_and_number() {
    let seen = recorded(STEP_S, |number, board| {
        if number == 4 {
            board.convst[1] = 0.1 * US;
        }
    });
    let steps = judge(&seen.0, seen.1);
    let width = steps
        .iter()
        .find(|step| step.step == "CONVST width")
        .unwrap();
    assert_eq!(width.found, "0.1 µs, 1 of 8");
    assert_eq!(width.wanted, "0.5 µs ± 2 % and 25 ns for its edges");
    assert!(
        (width.at_s.unwrap() - 203.0 * US).abs() < 1.0e-9,
        "{width:?}"
    );
}

/// What an instrument cannot tell is not judged, whatever the board does.
#[test]
fn a_slow_instrument_judges_what_it_can_tell() {
    let slow = recorded(4.0e-8, |_, board| board.busy[0] = 0.01 * US);
    assert_eq!(steps(&slow, Some(false)), [""; 0]);
    let unresolved = [
        "CONVST edges",
        "BUSY after CONVST",
        "SCLK0 frequency",
        "SCLK1 frequency",
        "SCLK0 bits",
        "SCLK1 bits",
        "SCLK0 at rest",
        "SCLK1 at rest",
    ];
    assert_eq!(steps(&slow, None), unresolved);
    // 1 MS/s: some pulses of CONVST are not even seen.
    let slower = recorded(1.0e-6, |_, _| {});
    assert_eq!(steps(&slower, Some(true)), [""; 0]);
    assert_eq!(steps(&slower, Some(false)), [""; 0]);
}

#[test]
fn lines_that_are_not_recorded_are_not_measured_and_said() {
    let (all, span) = recorded(STEP_S, |_, _| {});
    let mut lines = Lines::default();
    for line in [Line::Convst, Line::Busy] {
        lines.put(line, all.get(line).unwrap().clone());
    }
    let seen = (lines, span);
    assert_eq!(steps(&seen, Some(true)).len(), 7);
    let told = judge(&seen.0, span);
    let width = told.iter().find(|step| step.step == "CS0 width").unwrap();
    assert_eq!(width.passed, None);
    assert!(width.found.contains("--channel CS0=NAME"), "{width:?}");
}

#[test]
fn a_board_that_does_not_run_fails_and_levels_that_must_rest_do() {
    let (_, span) = recorded(STEP_S, |_, _| {});
    let mut lines = Lines::default();
    lines.put(Line::Convst, Signal::default());
    lines.put(Line::Select(0), Signal::new(false, vec![]));
    lines.put(Line::Reset, Signal::new(false, vec![5.0 * US, 10.0 * US]));
    lines.put(Line::Nrst, Signal::new(false, vec![]));
    let seen = (lines, span);
    assert_eq!(
        steps(&seen, Some(false)),
        ["CONVST pulses", "RESET", "NRST"]
    );
    // A few microseconds show no period.
    let short = (
        seen.0,
        Span {
            end_s: 20.0 * US,
            ..span
        },
    );
    assert_eq!(steps(&short, Some(false)), ["RESET", "NRST"]);
}
