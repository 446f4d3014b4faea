//! An image's functions, as its instructions have them: what each takes of the stack, what it calls, whether it holds interrupts back.

use object::{Object, ObjectSymbol, SymbolKind};
use std::collections::{BTreeMap, BTreeSet};
use thumb::{Flow, Stack, decode};

/// Address of a function's first instruction.
pub type Place = u32;

/// What its instructions say of a function.
#[derive(Clone, Debug, Default)]
pub struct Function {
    /// Its symbol.
    pub name: String,
    /// Bytes.
    pub size: u32,
    /// What it takes of the stack, bytes; an upper bound.
    pub frame: u32,
    /// Whether it takes an amount that its instructions do not say.
    pub unknown_frame: bool,
    /// What it calls or jumps to.
    pub calls: BTreeSet<Place>,
    /// Whether it calls through a register.
    pub calls_register: bool,
    /// Whether it holds interrupts back.
    pub masks: bool,
}

/// Whether an instruction holds interrupts back: CPSID, or MSR to PRIMASK, BASEPRI, BASEPRI_MAX or FAULTMASK (ARMv7-M manual, B5.2.1 and
/// B5.2.3).
pub fn holds_back(code: &[u8]) -> bool {
    let half = |at: usize| match code.get(at..at + 2) {
        Some(&[low, high]) => u16::from_le_bytes([low, high]),
        _ => 0,
    };
    let (first, second) = (half(0), half(2));
    let disables = first & 0xFFF8 == 0xB670;
    let writes = first & 0xFFF0 == 0xF380 && second & 0xFF00 == 0x8800;
    disables || writes && (0x10..=0x13).contains(&(second & 0xFF))
}

/// Functions by symbol; one without a size reaches to the next.
pub fn functions(file: &object::File<'_>) -> BTreeMap<Place, Function> {
    let mut functions: BTreeMap<Place, Function> = BTreeMap::new();
    for symbol in file
        .symbols()
        .filter(|symbol| symbol.kind() == SymbolKind::Text && symbol.is_definition())
    {
        let (place, name) = (
            symbol.address() as u32 & !1,
            symbol.name().unwrap_or_default(),
        );
        let function = functions.entry(place).or_default();
        function.size = function.size.max(symbol.size() as u32);
        if function.name.is_empty() || name.len() < function.name.len() {
            function.name = name.to_owned();
        }
    }
    let places: Vec<Place> = functions.keys().copied().collect();
    for (place, next) in places.iter().zip(places.iter().skip(1)) {
        if let Some(function) = functions
            .get_mut(place)
            .filter(|function| function.size == 0)
        {
            function.size = (next - place).min(4096);
        }
    }
    functions
}

/// Where constants stand between instructions: from a mapping symbol `$d` to the next `$t` (ELF for the Arm Architecture,
/// section 5.5.5).
pub struct Constants(BTreeMap<Place, bool>);

impl Constants {
    /// Of an image.
    pub fn of(file: &object::File<'_>) -> Self {
        let mapping = |symbol: object::Symbol<'_, '_>| match symbol.name().unwrap_or_default() {
            name if name.starts_with("$d") => Some((symbol.address() as u32, true)),
            name if name.starts_with("$t") => Some((symbol.address() as u32, false)),
            _ => None,
        };
        Self(file.symbols().filter_map(mapping).collect())
    }

    fn at(&self, place: Place) -> bool {
        let before = self.0.range(..=place).next_back();
        before.is_some_and(|(_, constant)| *constant)
    }
}

/// Walks a function's instructions.
pub fn follow(
    place: Place,
    code: &[u8],
    constants: &Constants,
    places: &BTreeSet<Place>,
    function: &mut Function,
) {
    let mut at = 0;
    while at + 2 <= code.len() {
        if constants.at(place + at as u32) {
            at += 2;
            continue;
        }
        let instruction = decode(&code[at..]);
        function.masks |= holds_back(&code[at..]);
        match instruction.stack {
            Stack::Keeps => {}
            Stack::Takes(bytes) => function.frame += bytes,
            Stack::TakesUnknown => function.unknown_frame = true,
        }
        match instruction.flow {
            Flow::Call(offset) | Flow::Jump(offset) | Flow::Branch(offset) => {
                let target = (place + at as u32).wrapping_add_signed(offset);
                let inside = target >= place && target < place + function.size;
                if places.contains(&target)
                    && (!inside || matches!(instruction.flow, Flow::Call(_)))
                {
                    function.calls.insert(target);
                }
            }
            Flow::CallRegister => function.calls_register = true,
            Flow::Next | Flow::Away => {}
        }
        at += instruction.size as usize;
    }
}

/// Whether this is the linker's way to a function that a branch does not reach: MOVW and MOVT of r12, BX r12.
pub fn is_thunk(code: &[u8]) -> bool {
    code.len() == 10 && code.ends_with(&[0x60, 0x47])
}

/// Words that are a function's address with the Thumb bit set.
pub fn addresses(data: &[u8], places: &BTreeSet<Place>) -> BTreeSet<Place> {
    let words = data
        .as_chunks::<4>()
        .0
        .iter()
        .map(|word| u32::from_le_bytes(*word));
    words
        .filter(|word| word & 1 == 1 && places.contains(&(word - 1)))
        .map(|word| word - 1)
        .collect()
}

/// Addresses of functions that code makes of two halves, MOVW and MOVT (ARMv7-M manual, A7.7.76 and A7.7.79).
pub fn made(
    place: Place,
    code: &[u8],
    constants: &Constants,
    places: &BTreeSet<Place>,
) -> BTreeSet<Place> {
    let mut low = [None; 16];
    let mut found = BTreeSet::new();
    let mut at = 0;
    while let Some(&[a, b]) = code.get(at..at + 2) {
        if constants.at(place + at as u32) {
            at += 2;
            continue;
        }
        let first = u16::from_le_bytes([a, b]);
        if let Some(&[c, d]) = code.get(at + 2..at + 4) {
            let second = u16::from_le_bytes([c, d]);
            let half = u32::from(first & 0xF) << 12
                | u32::from(first >> 10 & 1) << 11
                | u32::from(second >> 12 & 7) << 8
                | u32::from(second & 0xFF);
            let register = &mut low[usize::from(second >> 8 & 0xF)];
            match (first & 0xFBF0, second >> 15) {
                (0xF240, 0) => *register = Some(half),
                (0xF2C0, 0) => {
                    let word = register.map(|low| half << 16 | low);
                    let function = word.filter(|w| w & 1 == 1 && places.contains(&(w - 1)));
                    found.extend(function.map(|w| w - 1));
                }
                _ => {}
            }
        }
        at += decode(&code[at..]).size as usize;
    }
    found
}

/// A symbol as in the source.
pub fn readable(name: &str) -> String {
    format!("{:#}", rustc_demangle::demangle(name))
}

/// Machine code as an assembler makes it of these words: what holds interrupts back, and what does not.
#[cfg(test)]
pub mod words {
    pub const MASKING: [(&[u8], &str); 5] = [
        (&[0x72, 0xB6], "cpsid i"),
        (&[0x71, 0xB6], "cpsid f"),
        (&[0x80, 0xF3, 0x10, 0x88], "msr primask, r0"),
        (&[0x81, 0xF3, 0x11, 0x88], "msr basepri, r1"),
        (&[0x84, 0xF3, 0x12, 0x88], "msr basepri_max, r4"),
    ];
    pub const OTHERS: [(&[u8], &str); 5] = [
        (&[0x62, 0xB6], "cpsie i"),
        (&[0x80, 0xF3, 0x08, 0x88], "msr msp, r0"),
        (&[0xEF, 0xF3, 0x11, 0x80], "mrs r0, basepri"),
        (&[0x00, 0xBF], "nop"),
        (&[0x72, 0x46], "mov r2, lr"),
    ];
}

#[cfg(test)]
mod tests {
    use super::words::{MASKING, OTHERS};
    use super::*;

    #[test]
    fn what_holds_interrupts_back_is_told_from_what_does_not() {
        for (code, text) in MASKING {
            assert!(holds_back(code), "{text}");
        }
        for (code, text) in OTHERS {
            assert!(!holds_back(code), "{text}");
        }
    }

    /// The linker's way from the CCM RAM to 0x0801_2340, as it makes it.
    const THUNK: [u8; 10] = [0x42, 0xF2, 0x41, 0x3C, 0xC0, 0xF6, 0x01, 0x0C, 0x60, 0x47];

    #[test]
    fn a_way_that_the_linker_makes_is_followed() {
        let to = 0x0801_2340;
        let places = BTreeSet::from([0, to]);
        assert!(is_thunk(&THUNK) && !is_thunk(&THUNK[..8]));
        let constants = Constants(BTreeMap::new());
        assert_eq!(made(0, &THUNK, &constants, &places), BTreeSet::from([to]));
    }
}
