//! Units of columns by the names that programs give them, where the names tell the program, and how that program records a position.

use crate::table::{Log, LogColumn};

/// Control cycles of an ODrive a second; its `HighRateCapturer` counts times in them where it is told to.
const ODRIVE_HZ: f64 = 8_000.0;

/// Of an ODrive's tree of properties the last part of a name, its unit, and what it can be in a recording.
const ODRIVE: [(&str, &str, &str); 7] = [
    ("pos_estimate", "turn", "p1_m"),
    ("pos_circular", "turn", "p1_m"),
    ("pos_rel", "turn", "p1_m"),
    ("pos_abs", "turn", "p1_m"),
    ("pos_setpoint", "turn", "cmd_x_m"),
    ("input_pos", "turn", "cmd_x_m"),
    ("temperature", "C", "temp_c"),
];

/// The same of the titles that loggers give, `ODrive 0 Position`: their last word.
const ODRIVE_TITLES: [(&str, &str, &str); 2] = [
    ("Position", "turn", "p1_m"),
    ("Setpoint", "turn", "cmd_x_m"),
];

/// How an ODrive's position comes into a log.
const ODRIVE_RECORDS: &str = "capture the property axis0.pos_estimate of the ODrive (axis0.encoder.pos_estimate before its firmware 0.6): HighRateCapturer.from_properties(odrv, ['axis0.pos_estimate']), or a Recorder of it";

/// Names of moteus' registers in logs of its Python library, and of the values that tview logs.
const MOTEUS: [(&str, &str, &str); 8] = [
    ("POSITION", "turn", "p1_m"),
    ("ABS_POSITION", "turn", "p1_m"),
    ("TEMPERATURE", "C", "temp_c"),
    ("MOTOR_TEMPERATURE", "C", "temp_c"),
    ("position", "turn", "p1_m"),
    ("abs_position", "turn", "p1_m"),
    ("fet_temp_C", "C", "temp_c"),
    ("motor_temp_C", "C", "temp_c"),
];

/// How a position of moteus comes into a log.
const MOTEUS_RECORDS: &str = "the channel servo_stats of tview, which has position and abs_position, or the register POSITION, which moteus.Controller queries unless its QueryResolution leaves it out";

/// The log with units of columns where neither it nor its reader gave them, hints at what they are, and how its program records more.
#[must_use]
pub fn named(mut log: Log) -> Log {
    let has = |wanted: &str| {
        log.columns
            .iter()
            .any(|column| last_part(&column.name) == wanted)
    };
    let odrive = log.columns.iter().any(|column| {
        column
            .name
            .split('.')
            .any(|part| matches!(part, "axis0" | "axis1"))
    });
    let odrive = odrive
        || log
            .columns
            .iter()
            .any(|column| is_odrive_title(&column.name));
    let is_of_servo = |column: &LogColumn| {
        column
            .name
            .split('.')
            .any(|part| part.starts_with("servo_"))
    };
    let moteus = has("MODE") && (has("POSITION") || has("VELOCITY") && has("TORQUE"))
        || has("timestamp") && has("position") && (has("abs_position") || has("d_A"))
        || log.form == "lines of JSON"
            && (has("position") && (has("abs_position") || has("d_A"))
                || log.columns.iter().any(is_of_servo));
    if odrive {
        log.how_to_record = Some(ODRIVE_RECORDS);
        log.columns
            .iter_mut()
            .for_each(|column| name(column, &ODRIVE));
        log.columns.iter_mut().for_each(name_title);
        odrive_times(&mut log);
        log.notes.push("positions of an ODrive are in turns since its firmware 0.5.1, in counts before (--column TARGET=COLUMN:turn/CPR)".into());
    } else if moteus {
        log.how_to_record = Some(MOTEUS_RECORDS);
        log.columns
            .iter_mut()
            .for_each(|column| name(column, &MOTEUS));
        let time = log
            .columns
            .iter_mut()
            .find(|column| column.name == "timestamp" && column.unit.is_none());
        time.into_iter()
            .for_each(|column| column.unit = Some("s".into()));
    }
    log
}

fn name(column: &mut LogColumn, known: &[(&str, &str, &str)]) {
    let Some((_, unit, target)) = known
        .iter()
        .find(|(name, ..)| *name == last_part(&column.name))
    else {
        return;
    };
    if column.unit.is_none() {
        column.unit = Some((*unit).to_owned());
        column
            .hint
            .get_or_insert(format!("{target}={}:{unit}", column.name));
    }
}

/// True of a title that begins with the word and the number of a drive.
fn is_odrive_title(name: &str) -> bool {
    let mut words = name.split_whitespace();
    let first = words
        .next()
        .is_some_and(|word| word.eq_ignore_ascii_case("odrive"));
    first && words.next().is_some_and(|word| word.parse::<u8>().is_ok())
}

/// As [`name`] of a title. Its logger may have written a unit, which stays.
fn name_title(column: &mut LogColumn) {
    let last = column
        .name
        .split_whitespace()
        .next_back()
        .unwrap_or_default();
    let known = ODRIVE_TITLES
        .iter()
        .find(|(word, ..)| word.eq_ignore_ascii_case(last));
    let Some((_, unit, target)) = known.filter(|_| is_odrive_title(&column.name)) else {
        return;
    };
    let unit = column.unit.get_or_insert((*unit).to_owned());
    column
        .hint
        .get_or_insert(format!("{target}={}:{unit}", column.name));
}

fn last_part(name: &str) -> &str {
    name.rsplit('.').next().unwrap_or(name)
}

/// Times of `HighRateCapturer` and `Recorder` are nanoseconds or control cycles, and do not say which: cycles follow each other by one.
fn odrive_times(log: &mut Log) {
    let is_time = |column: &&mut LogColumn| {
        matches!(column.name.as_str(), "timestamps" | "timestamp") && column.unit.is_none()
    };
    let Some(column) = log.columns.iter_mut().find(is_time) else {
        return;
    };
    let mut steps: Vec<f64> = column
        .numbers
        .windows(2)
        .map(|pair| pair[1] - pair[0])
        .collect();
    steps.sort_by(f64::total_cmp);
    let step = steps.get(steps.len() / 2).copied().unwrap_or(f64::NAN);
    let (factor, told) = match step {
        1.0 => (1.0 / ODRIVE_HZ, "control cycles, 8000 a second"),
        _ => (1e-9, "nanoseconds"),
    };
    let first = column.numbers.first().copied().unwrap_or(0.0);
    column
        .numbers
        .iter_mut()
        .for_each(|number| *number = (*number - first) * factor);
    column.unit = Some("s".into());
    column.note = Some(format!("{} were taken as {told}", column.name));
}
