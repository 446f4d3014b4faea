//! Entries of a board's log, in words.

use crate::terminal::micrometres;
use courier_sensor::calibration::record::Method;
use courier_sensor::calibration::rest_watch::RestChange;
use courier_sensor::calibration::slots::Place;
use courier_sensor::calibration::watch::{Change, Standing};
use courier_sensor::event_log::entry::{Ending, Event, Fault, Head, MapEvent};
use courier_sensor::frame::Status;
use courier_sensor::link::message::{InForce, Refusal, ResetCause};
use time::OffsetDateTime;
use time::format_description::well_known::Rfc3339;

/// When: the board's start, seconds since then, and the time of day if it was told.
pub fn when(head: &Head) -> String {
    let unix_s = head
        .time
        .unix_s
        .and_then(|unix_s| i64::try_from(unix_s).ok());
    let date = unix_s.and_then(|unix_s| OffsetDateTime::from_unix_timestamp(unix_s).ok());
    let date = date.and_then(|date| date.format(&Rfc3339).ok());
    let since = format!("start {:>3} {:>8} s", head.start, head.time.uptime_s);
    format!("{since}  {:<20}", date.unwrap_or_else(|| "-".to_owned()))
}

/// `error` for faults, `warn` for what somebody must look at.
pub fn level(event: &Event) -> &'static str {
    match event {
        Event::Started { fault: Some(_), .. } | Event::Status(_) => "error",
        Event::Started {
            cause: ResetCause::BrownOut,
            ..
        }
        | Event::Started { boot: Some(_), .. }
        | Event::Watch {
            change: Some(_), ..
        }
        | Event::CalibrationEnded {
            ending: Ending::Refused(_) | Ending::NotKept,
            ..
        } => "warn",
        Event::Map(map) if !matches!(map, MapEvent::InForce { .. }) => "warn",
        _ => "info",
    }
}

/// What.
pub fn what(event: &Event) -> String {
    match event {
        Event::Started {
            cause,
            faults_in_a_row,
            firmware,
            in_force,
            boot,
            fault,
        } => {
            let row = match faults_in_a_row {
                0 | 1 => String::new(),
                row => format!(", fault {row} in a row"),
            };
            format!(
                "start: {}{row}{}; firmware {firmware}; {}",
                self::cause(*cause),
                fault.as_ref().map_or(String::new(), of_fault),
                at_start(*in_force, boot.as_ref())
            )
        }
        Event::Status(bits) => Status::from_bits_truncate(*bits).to_string(),
        Event::CalibrationBegun(Method::Platen) => "calibration begun".to_owned(),
        Event::CalibrationBegun(Method::Joint) => "joint calibration begun".to_owned(),
        Event::CalibrationEnded { ending, held_out_m } => ended(ending, held_out_m),
        Event::InForce { now, rolled_back } => match rolled_back {
            true => format!("rolled back: {}", in_force(*now)),
            false => in_force(*now),
        },
        Event::Map(map) => of_map(map),
        Event::Watch { standing, change } => watched(*standing, change.as_ref()),
        Event::BeaconWatch { standing, change } => watched_rests(
            "beacon's part of the calibration",
            *standing,
            change.as_ref(),
        ),
        Event::ParityWatch { standing, change } => {
            watched_rests("calibration, by g_p at rests,", *standing, change.as_ref())
        }
        Event::ImageTaken(version) => {
            format!("firmware {version} taken in; the next start tries it")
        }
        Event::ImageAccepted(version) => format!("firmware {version} accepted"),
        Event::Proposed(candidate) => format!("recalibration proposed: {candidate}"),
        Event::Recalibrated(now) => format!("recalibrated while working: {}", in_force(*now)),
    }
}

fn cause(cause: ResetCause) -> &'static str {
    match cause {
        ResetCause::PowerOn => "the supply came",
        ResetCause::Pin => "reset pin or debug probe",
        ResetCause::Requested => "by order",
        ResetCause::BrownOut => "the supply had failed",
        ResetCause::Watchdog => "watchdog",
        ResetCause::Panic => "panic",
        ResetCause::HardFault => "hard fault",
    }
}

fn of_fault(fault: &Fault) -> String {
    let text = match fault.message.as_str() {
        "" => String::new(),
        text => format!(", {text}"),
    };
    format!(
        " after {} s, at {:#x}{text}",
        fault.uptime_s, fault.program_counter
    )
}

fn at_start(now: InForce, boot: Option<&Refusal>) -> String {
    match boot {
        Some(why) => format!("no calibration in force: {why}"),
        None => in_force(now),
    }
}

fn in_force(now: InForce) -> String {
    match now {
        InForce::None => "no calibration in force".to_owned(),
        InForce::Unsaved => "a calibration in force that is not stored".to_owned(),
        InForce::Stored(place) => format!("calibration {} in force", numbered(place)),
    }
}

fn numbered(place: Place) -> String {
    format!("number {} in slot {}", place.sequence, place.slot)
}

fn ended(ending: &Ending, held_out_m: &[f32; 2]) -> String {
    let [before, after] = held_out_m.map(|metres| micrometres(metres.into()));
    let residual = format!("held-out residual {before} -> {after} µm");
    match ending {
        Ending::Accepted(Some(place)) => format!(
            "calibration accepted, {residual}; stored as {}",
            numbered(*place)
        ),
        Ending::Accepted(None) => format!("calibration accepted, {residual}; not stored"),
        Ending::NotKept => format!("calibration accepted, {residual}, but it could not be kept"),
        Ending::Refused(refusal) => format!("calibration refused: {refusal}"),
    }
}

fn of_map(map: &MapEvent) -> String {
    let slot = map.slot();
    match map {
        MapEvent::InForce { .. } => format!("tooth map of slot {slot} in force"),
        MapEvent::NotWhole { ahead: [x, y], .. } => format!(
            "tooth map of slot {slot} not in force: the board counts {:.2}, {:.2} teeth ahead of it, no whole numbers",
            f64::from(x.teeth) + f64::from(x.fraction_turns),
            f64::from(y.teeth) + f64::from(y.fraction_turns)
        ),
        MapEvent::OtherPlaten {
            parity_m: [found, wanted],
            ..
        } => format!(
            "tooth map of slot {slot} taken out of force: g_p {} µm rms, wanted {} or less: another platen, or a beacon moved by whole teeth",
            micrometres((*found).into()),
            micrometres((*wanted).into())
        ),
        MapEvent::OtherCalibration { .. } => {
            format!("tooth map of slot {slot} belongs to another calibration")
        }
        MapEvent::Refused { refusal, .. } => {
            format!("tooth map of slot {slot} cannot be used: {refusal}")
        }
    }
}

fn watched_rests(what: &str, standing: Standing, change: Option<&RestChange>) -> String {
    let of = change.map_or(String::new(), |change| format!(": {change}"));
    match standing {
        Standing::Stale => format!("{what} stale{of}"),
        Standing::Drifting => format!("{what} drifting{of}"),
        _ => format!("{what} as calibrated again"),
    }
}

fn watched(standing: Standing, change: Option<&Change>) -> String {
    let of = change.map_or(String::new(), |change| format!(": {change}"));
    match standing {
        Standing::Stale => format!("calibration stale{of}"),
        Standing::Drifting => format!("calibration drifting{of}"),
        _ => "calibration as calibrated again".to_owned(),
    }
}
