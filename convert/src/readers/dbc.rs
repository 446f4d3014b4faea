//! Which bits of which frame are which signal: the lines `BO_`, `SG_` and `SIG_VALTYPE_` of a DBC file, and of `VAL_` and `BA_` what
//! says which bits stand for no value.
//!
//! The crate for such files reads all of their forty kinds of lines and brings a parser generator and a C compiler's work with it; five
//! kinds of lines are needed here.

use super::frames::EXTENDED;
use super::reserved::{Kind, Reserved, is_none_by_name};
use recording::{Error, excerpt};
use std::path::Path;

/// A kind of frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Message {
    /// Its name.
    pub name: String,
    /// Its identifier, bit 31 set where it is one of 29 bits.
    pub id: u32,
    /// Its signals.
    pub signals: Vec<Signal>,
    /// True where the file says that it is of SAE J1939, whose codes for no value it then has.
    says_j1939: bool,
}

/// What a frame says of a signal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Said {
    /// Nothing: it is not in this frame.
    Absent,
    /// That there is no value.
    None,
    /// A value, in its unit.
    Value(f64),
}

/// How a signal is multiplexed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Page {
    /// It is in every frame.
    Always,
    /// It says which page a frame is.
    Selector,
    /// It is in frames of this page.
    Only(u64),
}

/// A signal.
#[derive(Clone, Debug, PartialEq)]
pub struct Signal {
    /// Its name.
    pub name: String,
    /// Its unit, as the file says it.
    pub unit: String,
    page: Page,
    start: usize,
    bits: usize,
    big: bool,
    kind: Kind,
    factor: f64,
    offset: f64,
    reserved: Reserved,
}

/// All kinds of frames that a file describes.
///
/// # Errors
/// A line that cannot be read, by its number.
pub fn parse(file: &Path, text: &str) -> Result<Vec<Message>, Error> {
    let mut messages: Vec<Message> = Vec::new();
    for (place, line) in text.lines().enumerate() {
        let mut words = line.split_whitespace();
        let wanted = match words.next() {
            // A keyword alone is one of the list below `NS_`, which names those that the file may use.
            Some(_) if words.next().is_none() => Ok(()),
            Some("BO_") => message(line).map(|message| messages.push(message)).ok_or("BO_ ID NAME: BYTES SENDER"),
            Some("SG_") => signal(line)
                .and_then(|signal| messages.last_mut().map(|message| message.signals.push(signal)))
                .ok_or("SG_ NAME : START|BITS@ORDER SIGN (FACTOR,OFFSET) [LOWEST|HIGHEST] \"UNIT\" RECEIVER, below a BO_"),
            // Names and attributes that cannot be read say nothing of any value.
            Some("VAL_") => {
                names(line, &mut messages);
                Ok(())
            }
            Some("BA_") => {
                attribute(line, &mut messages);
                Ok(())
            }
            Some("SIG_VALTYPE_") => kind(line, &mut messages).ok_or("SIG_VALTYPE_ ID NAME : TYPE; of a signal above, with 32 or 64 bits"),
            _ => Ok(()),
        };
        if let Err(wanted) = wanted {
            return Err(
                Error::new(file, excerpt(line.trim().as_bytes()), wanted).row(place as u64 + 1)
            );
        }
    }
    messages.retain(|message| !message.signals.is_empty());
    match messages.is_empty() {
        true => Err(Error::new(
            file,
            "no signals",
            "a DBC file: lines BO_ and SG_",
        )),
        false => Ok(messages),
    }
}

/// The parameter group of an identifier of 29 bits: of formats below 240 the eight bits above the sender are a receiver's address and no part of it (SAE J1939-21).
fn group(id: u32) -> u32 {
    let group = id >> 8 & 0x3_ffff;
    match group >> 8 & 0xff {
        ..240 => group & 0x3_ff00,
        _ => group,
    }
}

fn message(line: &str) -> Option<Message> {
    let mut words = line.split_whitespace().skip(1);
    let id = words.next()?.parse().ok()?;
    let name = words.next()?.trim_end_matches(':').to_owned();
    Some(Message {
        name,
        id,
        signals: Vec::new(),
        says_j1939: false,
    })
}

fn signal(line: &str) -> Option<Signal> {
    let (head, rest) = line.split_once(':')?;
    let mut words = head.split_whitespace().skip(1);
    let name = words.next()?.to_owned();
    let page = match words.next() {
        None => Page::Always,
        Some("M") => Page::Selector,
        Some(page) => Page::Only(page.strip_prefix('m')?.trim_end_matches('M').parse().ok()?),
    };
    let (place, rest) = rest.trim_start().split_once(['(', ' '])?;
    let (start, place) = place.split_once('|')?;
    let (bits, how) = place.split_once('@')?;
    let (bits, start): (usize, usize) = (bits.parse().ok()?, start.parse().ok()?);
    let rest = rest.trim_start().trim_start_matches('(');
    let (numbers, rest) = rest.split_once(')')?;
    let (factor, offset) = numbers.split_once(',')?;
    let range = rest
        .split_once('[')
        .and_then(|(_, rest)| rest.split_once(']'));
    let range = range.and_then(|(range, _)| range.split_once('|'));
    let unit = rest.split('"').nth(1).unwrap_or_default().to_owned();
    let (order, sign) = how.split_at_checked(1)?;
    let kind = if sign.trim() == "-" {
        Kind::Signed
    } else {
        Kind::Unsigned
    };
    let number = |text: &str| {
        text.trim()
            .parse::<f64>()
            .ok()
            .filter(|number| number.is_finite())
    };
    // A frame of CAN FD has 64 bytes.
    let fits = (1..=64).contains(&bits) && start < 512;
    fits.then_some(Signal {
        name,
        unit,
        page,
        start,
        bits,
        big: order == "0",
        kind,
        factor: number(factor)?,
        offset: number(offset)?,
        reserved: Reserved {
            named: Vec::new(),
            range: range
                .and_then(|(low, high)| Some([number(low)?, number(high)?]))
                .filter(|[low, high]| low < high),
        },
    })
}

/// `VAL_ ID SIGNAL CODE "NAME" CODE "NAME" ;`: codes whose name means that there is no value.
fn names(line: &str, messages: &mut [Message]) -> Option<()> {
    let mut parts = line.split('"');
    let mut head = parts.next()?.split_whitespace().skip(1);
    let (id, signal, mut code) = (head.next()?, head.next()?, head.next()?);
    let id: u32 = id.parse().ok()?;
    let message = messages.iter_mut().find(|message| message.id == id)?;
    let signal = message.signals.iter_mut().find(|of| of.name == signal)?;
    while let (Some(name), Some(next)) = (parts.next(), parts.next()) {
        if is_none_by_name(name) {
            let code: i64 = code.parse().ok()?;
            signal.reserved.named.push(code as u64 & signal.all());
        }
        code = next.trim();
    }
    Some(())
}

/// `BA_ "ProtocolType" "J1939";` of the whole file, `BA_ "VFrameFormat" BO_ ID 3;` of one message: they are of SAE J1939.
fn attribute(line: &str, messages: &mut [Message]) -> Option<()> {
    let words: Vec<&str> = line
        .trim()
        .trim_end_matches(';')
        .split_whitespace()
        .collect();
    match words[..] {
        ["BA_", "\"ProtocolType\"", protocol] if protocol.contains("J1939") => {
            messages
                .iter_mut()
                .for_each(|message| message.says_j1939 = true);
        }
        ["BA_", "\"VFrameFormat\"", "BO_", id, "3"] => {
            let id: u32 = id.parse().ok()?;
            let message = messages.iter_mut().find(|message| message.id == id)?;
            message.says_j1939 = true;
        }
        _ => {}
    }
    Some(())
}

fn kind(line: &str, messages: &mut [Message]) -> Option<()> {
    let words: Vec<&str> = line
        .split([' ', ':', ';', '\t'])
        .filter(|word| !word.is_empty())
        .collect();
    let [_, id, name, kind] = words[..] else {
        return None;
    };
    let id: u32 = id.parse().ok()?;
    let signals = messages
        .iter_mut()
        .filter(|message| message.id == id)
        .flat_map(|message| &mut message.signals);
    let signal = signals.into_iter().find(|signal| signal.name == name)?;
    match (kind, signal.bits) {
        ("0", _) => Some(()),
        ("1", 32) | ("2", 64) => {
            signal.kind = Kind::Real;
            Some(())
        }
        _ => None,
    }
}

/// Address of a sender of SAE J1939 that has none. No signals come from it, so in a DBC file it stands for any sender (SAE J1939-81, null address).
const ANY_SENDER: u32 = 0xfe;

impl Message {
    /// True where it names no sender: it is of any.
    fn is_group(&self) -> bool {
        self.id & EXTENDED != 0 && self.id & 0xff == ANY_SENDER
    }

    /// True of frames with this identifier: this message's own, or where it names no sender any of its parameter group, whatever its sender
    /// and priority.
    pub fn is_of(&self, id: u32) -> bool {
        id == self.id || self.is_group() && id & EXTENDED != 0 && group(id) == group(self.id)
    }

    /// What a frame says of its signals.
    pub fn said(&self, data: &[u8]) -> Vec<Said> {
        let selector = self
            .signals
            .iter()
            .find(|signal| signal.page == Page::Selector);
        let page = selector.and_then(|signal| signal.word(data));
        let is_j1939 = self.says_j1939 || self.is_group();
        let said = |signal: &Signal| match signal.page {
            Page::Only(wanted) if page != Some(wanted) => Said::Absent,
            Page::Selector => signal.said(data, false),
            _ => signal.said(data, is_j1939),
        };
        self.signals.iter().map(said).collect()
    }

    /// True if the frame is long enough for every signal that is in all of them.
    pub fn fits(&self, data: &[u8]) -> bool {
        self.signals
            .iter()
            .filter(|signal| signal.page == Page::Always)
            .all(|signal| signal.word(data).is_some())
    }
}

impl Signal {
    fn said(&self, data: &[u8], is_j1939: bool) -> Said {
        let Some(word) = self.word(data) else {
            return Said::Absent;
        };
        let unused = 64 - self.bits as u32;
        let number = match (self.kind, self.bits) {
            (Kind::Unsigned, _) => word as f64,
            (Kind::Signed, _) => ((word << unused) as i64 >> unused) as f64,
            (Kind::Real, 32) => f64::from(f32::from_bits(word as u32)),
            (Kind::Real, _) => f64::from_bits(word),
        };
        let value = number * self.factor + self.offset;
        let is_none = self
            .reserved
            .is_none(word, self.bits, self.kind, value, is_j1939);
        match is_none || value.is_nan() {
            true => Said::None,
            false => Said::Value(value),
        }
    }

    /// All of its bits.
    fn all(&self) -> u64 {
        u64::MAX >> (64 - self.bits as u32)
    }

    /// Its bits, the most significant first; none where the frame ends before them.
    fn word(&self, data: &[u8]) -> Option<u64> {
        // Of the order of Intel `start` is the least significant bit, and bits count on; of Motorola's it is the most significant one, and
        // they count down within a byte, then on in the next.
        let mut at = self.start;
        let mut word = 0;
        for step in 0..self.bits {
            let place = if self.big {
                at
            } else {
                self.start + self.bits - 1 - step
            };
            let byte = data.get(place / 8)?;
            word = word << 1 | u64::from(byte >> (place % 8) & 1);
            at = if at % 8 == 0 { at + 15 } else { at - 1 };
        }
        Some(word)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(signal: &str, data: &[u8]) -> f64 {
        let text = format!("BO_ 1 M: 8 X\n SG_ {signal}\n");
        match parse(Path::new("a.dbc"), &text).unwrap()[0].said(data)[0] {
            Said::Value(value) => value,
            Said::None => f64::INFINITY,
            Said::Absent => f64::NAN,
        }
    }

    #[test]
    fn bits_of_both_orders() {
        let data = [0x12, 0x34, 0x56, 0x78, 0x9a, 0xbc, 0xde, 0xf0];
        for (signal, wanted) in [
            ("a : 0|8@1+ (1,0) [0|0] \"\" X", f64::from(0x12)),
            ("a : 0|16@1+ (1,0) [0|0] \"\" X", f64::from(0x3412)),
            ("a : 7|16@0+ (1,0) [0|0] \"\" X", f64::from(0x1234)),
            ("a : 4|8@1+ (1,0) [0|0] \"\" X", f64::from(0x41)),
            ("a : 3|8@0+ (1,0) [0|0] \"\" X", f64::from(0x23)),
            (
                "a : 32|8@1- (0.5,10)[0|0] \"\" X",
                f64::from(0x9a - 0x100) * 0.5 + 10.0,
            ),
            ("a m3 : 7|64@0+ (1,0) [0|0] \"\" X", f64::NAN),
        ] {
            let found = value(signal, &data);
            assert!(
                found == wanted || found.is_nan() && wanted.is_nan(),
                "{signal}: {found}"
            );
        }
        assert!(value("a : 0|16@1+ (1,0) [0|0] \"\" X", &data[..1]).is_nan());
    }

    /// By the protocol, by a name and by a range.
    #[test]
    fn codes_for_no_value_are_none() {
        let said = |id: u32, more: &str, data: [u8; 2]| {
            let text = format!("BO_ {id} M: 8 X\n SG_ a : 0|16@1+ (1,0) [0|0] \"\" X\n{more}");
            parse(Path::new("a.dbc"), &text).unwrap()[0].said(&data)[0]
        };
        let (none, full) = (Said::None, Said::Value(65_535.0));
        assert_eq!(said(0x123, "", [0xff; 2]), full);
        assert_eq!(said(0x18fe_f1fe | EXTENDED, "", [0xff; 2]), none);
        let file = "BA_ \"ProtocolType\" \"J1939\";\n";
        assert_eq!(said(0x123, file, [0xff; 2]), none);
        let message = "BA_ \"VFrameFormat\" BO_ 291 3;\n";
        assert_eq!(said(0x123, message, [0xff; 2]), none);
        assert_eq!(said(0x124, message, [0xff; 2]), full);
        let names = "VAL_ 291 a 7 \"Not available\" 6 \"Error\" 65535 \"SNA\" ;\n";
        assert_eq!(said(0x123, names, [0xff; 2]), none);
        assert_eq!(said(0x123, names, [7, 0]), none);
        assert_eq!(said(0x123, names, [6, 0]), Said::Value(6.0));
        assert_eq!(
            value("a : 0|8@1+ (0.5,10) [10|135] \"\" X", &[0xff]),
            f64::INFINITY
        );
        assert_eq!(
            value("a : 0|8@1+ (0.5,10) [10|137.5] \"\" X", &[0xff]),
            137.5
        );
    }

    #[test]
    fn a_message_without_a_sender_is_of_its_whole_group() {
        let message = |id: u32| {
            let text = format!("BO_ {id} M: 8 X\n SG_ a : 0|8@1+ (1,0) [0|0] \"\" X\n");
            parse(Path::new("a.dbc"), &text).unwrap().remove(0)
        };
        let of = |id: u32, frame: u32| message(id | EXTENDED).is_of(frame | EXTENDED);
        // Vessel heading from 7F, and with another priority; not another group.
        assert!(of(0x19f1_12fe, 0x19f1_127f) && of(0x19f1_12fe, 0x09f1_1280));
        assert!(!of(0x19f1_12fe, 0x09f1_1380));
        // A request to address 23 is one to any; of a message with a sender nothing else is.
        assert!(of(0x18ea_fffe, 0x18ea_2301) && !of(0x19f1_127f, 0x18f1_1280));
        // Eleven bits have no senders.
        assert!(!message(0xfe).is_of(0x1fe) && !message(0xfe | EXTENDED).is_of(0xfe));
    }

    /// Most files begin with one, those of an ODrive's firmware among them.
    #[test]
    fn a_list_of_keywords_is_left_aside() {
        let text = "VERSION \"\"\n\nNS_ :\n\tCM_\n\tSIG_VALTYPE_\n\tSG_MUL_VAL_\n\nBS_:\n\nBO_ 1 M: 8 X\n SG_ a : 0|8@1+ (1,0) [0|0] \"\" X\n";
        assert_eq!(parse(Path::new("a.dbc"), text).unwrap().len(), 1);
    }

    #[test]
    fn lines_that_cannot_be_meant_are_told_by_their_number() {
        for (text, told) in [
            ("VERSION \"\"\n", "found no signals"),
            ("BO_ x Y: 8 Z\n", "row 1, found \"BO_ x Y: 8 Z\""),
            (" SG_ a : 0|8@1+ (1,0) [0|0] \"\" X\n", "row 1, found"),
            (
                "BO_ 1 M: 8 X\n SG_ a : 0|65@1+ (1,0) [0|0] \"\" X\n",
                "row 2, found",
            ),
            (
                "BO_ 1 M: 8 X\n SG_ a : 0|8@1+ (1,0) [0|0] \"\" X\nSIG_VALTYPE_ 1 a : 1;\n",
                "row 3, found",
            ),
        ] {
            let error = parse(Path::new("a.dbc"), text).unwrap_err().to_string();
            assert!(error.contains(told) && !error.contains('\n'), "{error}");
        }
    }
}
