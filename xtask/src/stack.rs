//! Worst stack and call graph of an image, from its instructions alone.
//!
//! A function's frame is the sum of all that its instructions take, so shrink-wrapped prologues count in full: an upper
//! bound. A call through a register may reach every function whose address lies in the image's data or is made by code.

use anyhow::{Context, Result, ensure};
use object::{Object, ObjectSection, ObjectSymbol, SectionKind, SymbolKind};
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::ops::Range;
use std::path::Path;
use thumb::{Flow, Stack, decode};

/// Address of a function's first instruction.
type Place = u32;

#[derive(Clone, Debug, Default)]
struct Function {
    name: String,
    size: u32,
    frame: u32,
    unknown_frame: bool,
    calls: BTreeSet<Place>,
    calls_register: bool,
    masks: bool,
}

/// An image's functions and who calls whom.
pub struct CallGraph {
    functions: BTreeMap<Place, Function>,
    /// Functions that a call through a register may reach.
    reachable_by_address: BTreeSet<Place>,
}

/// Worst stack from one root.
#[derive(Clone, Debug)]
pub struct Worst {
    /// Bytes; an upper bound.
    pub bytes: u32,
    /// The chain of calls that needs them, root first: function and bytes of its own.
    pub chain: Vec<(String, u32)>,
    /// Whether a call through a register was in reach and bounded by the worst function whose address is taken.
    pub through_register: bool,
    /// Functions in reach that call themselves, directly or not: their depth is not bounded by this analysis.
    pub recursive: Vec<String>,
}

impl CallGraph {
    /// Reads an image.
    ///
    /// # Errors
    /// It cannot be read or has no symbols.
    pub fn of(image: &Path) -> Result<Self> {
        let bytes = std::fs::read(image).with_context(|| image.display().to_string())?;
        let file = object::File::parse(&*bytes).with_context(|| image.display().to_string())?;
        let mut functions = functions(&file);
        ensure!(!functions.is_empty(), "{}: no functions", image.display());
        let places: BTreeSet<Place> = functions.keys().copied().collect();
        let constants = Constants::of(&file);
        let mut reachable_by_address = BTreeSet::new();
        for section in file.sections() {
            let data = section.data().unwrap_or_default();
            if section.kind() == SectionKind::Text {
                for (place, function) in &mut functions {
                    let from = place.wrapping_sub(section.address() as u32) as usize;
                    if let Some(code) = data.get(from..from + function.size as usize) {
                        follow(*place, code, &constants, &places, function);
                        let made = made(*place, code, &constants, &places);
                        // Its address is used for this one jump.
                        match is_thunk(code) {
                            true => function.calls.extend(made),
                            false => reachable_by_address.extend(made),
                        }
                    }
                }
            }
            if matches!(
                section.kind(),
                SectionKind::Text | SectionKind::ReadOnlyData | SectionKind::Data
            ) && section.name() != Ok(".vector_table")
            {
                reachable_by_address.extend(addresses(data, &places));
            }
        }
        Ok(Self {
            functions,
            reachable_by_address,
        })
    }

    /// The symbol of a function by its own name: plain, or the last part of its path.
    pub fn named(&self, name: &str) -> Option<String> {
        let by_path =
            |function: &&Function| readable(&function.name).ends_with(&format!("::{name}"));
        let plain = self
            .functions
            .values()
            .find(|function| function.name == name);
        plain
            .or_else(|| self.functions.values().find(by_path))
            .map(|function| function.name.clone())
    }

    fn root(&self, name: &str) -> Result<Place> {
        let found = self
            .functions
            .iter()
            .find(|(_, function)| function.name == name);
        found
            .map(|(place, _)| *place)
            .with_context(|| format!("no function {name}"))
    }

    /// Worst stack of `root` and all that it calls.
    ///
    /// # Errors
    /// There is no such function.
    pub fn worst(&self, root: &str) -> Result<Worst> {
        let mut walk = Walk {
            graph: self,
            known: BTreeMap::new(),
            path: vec![],
            through_register: false,
            recursive: BTreeSet::new(),
        };
        let (bytes, chain) = walk.from(self.root(root)?);
        let name = |place: &Place| {
            self.functions
                .get(place)
                .map_or_else(String::new, |f| readable(&f.name))
        };
        Ok(Worst {
            bytes,
            chain: chain
                .iter()
                .map(|place| {
                    (
                        name(place),
                        self.functions.get(place).map_or(0, |f| f.frame),
                    )
                })
                .collect(),
            through_register: walk.through_register,
            recursive: walk.recursive.iter().map(name).collect(),
        })
    }

    /// Names of the functions outside these addresses that `root` may reach by functions within them alone.
    ///
    /// # Errors
    /// There is no such function as `root`.
    pub fn reach_outside(&self, root: &str, addresses: &Range<u64>) -> Result<Vec<String>> {
        let (mut seen, mut open) = (BTreeSet::new(), vec![self.root(root)?]);
        let mut outside = Vec::new();
        while let Some(place) = open.pop() {
            let Some(function) = self.functions.get(&place).filter(|_| seen.insert(place)) else {
                continue;
            };
            match addresses.contains(&u64::from(place)) {
                true => open.extend(&function.calls),
                false => outside.push(readable(&function.name)),
            }
        }
        Ok(outside)
    }

    /// Names of all functions that `root` may reach, and whether one of them calls through a register.
    ///
    /// # Errors
    /// There is no such function.
    pub fn reach(&self, root: &str) -> Result<(Vec<String>, bool)> {
        let (mut seen, mut open) = (BTreeSet::new(), vec![self.root(root)?]);
        let mut register = false;
        while let Some(place) = open.pop() {
            let Some(function) = self.functions.get(&place).filter(|_| seen.insert(place)) else {
                continue;
            };
            register |= function.calls_register;
            open.extend(&function.calls);
        }
        let names = seen
            .iter()
            .filter_map(|place| self.functions.get(place))
            .map(|f| f.name.clone());
        Ok((names.collect(), register))
    }

    /// The chain of calls from `root` to the nearest function that masks interrupts or enters a critical section, root first; none if no
    /// such function is in reach.
    ///
    /// # Errors
    /// There is no such function as `root`.
    pub fn masks(&self, root: &str) -> Result<Option<Vec<String>>> {
        let root = self.root(root)?;
        let (mut callers, mut open) = (BTreeMap::from([(root, root)]), VecDeque::from([root]));
        while let Some(place) = open.pop_front() {
            let Some(function) = self.functions.get(&place) else {
                continue;
            };
            if function.masks || function.name.contains(CRITICAL_SECTION) {
                return Ok(Some(self.chain(place, &callers)));
            }
            for callee in &function.calls {
                if !callers.contains_key(callee) {
                    callers.insert(*callee, place);
                    open.push_back(*callee);
                }
            }
        }
        Ok(None)
    }

    /// Names from the root, its own caller, to `place`.
    fn chain(&self, place: Place, callers: &BTreeMap<Place, Place>) -> Vec<String> {
        let mut places = vec![place];
        while let Some(caller) = callers.get(&places[places.len() - 1])
            && *caller != places[places.len() - 1]
        {
            places.push(*caller);
        }
        let names = places
            .iter()
            .rev()
            .filter_map(|place| self.functions.get(place));
        names.map(|function| readable(&function.name)).collect()
    }
}

/// Symbol of the function that every critical section begins with (crate critical-section).
const CRITICAL_SECTION: &str = "critical_section_1_0_acquire";

/// Whether an instruction holds interrupts back: CPSID, or MSR to PRIMASK, BASEPRI, BASEPRI_MAX or FAULTMASK (ARMv7-M manual, B5.2.1 and
/// B5.2.3).
fn holds_back(code: &[u8]) -> bool {
    let half = |at: usize| match code.get(at..at + 2) {
        Some(&[low, high]) => u16::from_le_bytes([low, high]),
        _ => 0,
    };
    let (first, second) = (half(0), half(2));
    let disables = first & 0xFFF8 == 0xB670;
    let writes = first & 0xFFF0 == 0xF380 && second & 0xFF00 == 0x8800;
    disables || writes && (0x10..=0x13).contains(&(second & 0xFF))
}

struct Walk<'g> {
    graph: &'g CallGraph,
    known: BTreeMap<Place, (u32, Vec<Place>)>,
    path: Vec<Place>,
    through_register: bool,
    recursive: BTreeSet<Place>,
}

impl Walk<'_> {
    fn from(&mut self, place: Place) -> (u32, Vec<Place>) {
        if let Some(known) = self.known.get(&place) {
            return known.clone();
        }
        if self.path.contains(&place) {
            self.recursive.insert(place);
            return (0, vec![]);
        }
        let Some(function) = self.graph.functions.get(&place) else {
            return (0, vec![]);
        };
        self.path.push(place);
        let mut worst = (0, vec![]);
        let by_address = function
            .calls_register
            .then_some(&self.graph.reachable_by_address);
        self.through_register |= function.calls_register;
        let graph = self.graph;
        for callee in graph.functions[&place]
            .calls
            .iter()
            .chain(by_address.into_iter().flatten())
        {
            let candidate = self.from(*callee);
            if candidate.0 > worst.0 {
                worst = candidate;
            }
        }
        self.path.pop();
        if function.unknown_frame {
            self.recursive.insert(place);
        }
        worst.0 += function.frame;
        worst.1.insert(0, place);
        self.known.insert(place, worst.clone());
        worst
    }
}

/// Functions by symbol; one without a size reaches to the next.
fn functions(file: &object::File<'_>) -> BTreeMap<Place, Function> {
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
struct Constants(BTreeMap<Place, bool>);

impl Constants {
    fn of(file: &object::File<'_>) -> Self {
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
fn follow(
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
fn is_thunk(code: &[u8]) -> bool {
    code.len() == 10 && code.ends_with(&[0x60, 0x47])
}

/// Words that are a function's address with the Thumb bit set.
fn addresses(data: &[u8], places: &BTreeSet<Place>) -> BTreeSet<Place> {
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
fn made(
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Machine code as an assembler makes it of these words.
    const MASKING: [(&[u8], &str); 5] = [
        (&[0x72, 0xB6], "cpsid i"),
        (&[0x71, 0xB6], "cpsid f"),
        (&[0x80, 0xF3, 0x10, 0x88], "msr primask, r0"),
        (&[0x81, 0xF3, 0x11, 0x88], "msr basepri, r1"),
        (&[0x84, 0xF3, 0x12, 0x88], "msr basepri_max, r4"),
    ];
    const OTHERS: [(&[u8], &str); 5] = [
        (&[0x62, 0xB6], "cpsie i"),
        (&[0x80, 0xF3, 0x08, 0x88], "msr msp, r0"),
        (&[0xEF, 0xF3, 0x11, 0x80], "mrs r0, basepri"),
        (&[0x00, 0xBF], "nop"),
        (&[0x72, 0x46], "mov r2, lr"),
    ];

    #[test]
    fn what_holds_interrupts_back_is_told_from_what_does_not() {
        for (code, text) in MASKING {
            assert!(holds_back(code), "{text}");
        }
        for (code, text) in OTHERS {
            assert!(!holds_back(code), "{text}");
        }
    }

    /// An interrupt that calls a function that calls one which masks, beside one that does not.
    #[test]
    fn a_mask_is_found_however_deep_and_its_way_is_told() {
        let function = |name: &str, calls: &[Place], code: &[u8]| Function {
            name: name.to_owned(),
            calls: calls.iter().copied().collect(),
            masks: holds_back(code),
            ..Function::default()
        };
        let graph = |functions: Vec<(Place, Function)>| CallGraph {
            functions: functions.into_iter().collect(),
            reachable_by_address: BTreeSet::new(),
        };
        let with = |code| {
            graph(vec![
                (0, function("interrupt", &[8, 16], &[])),
                (8, function("fine", &[8], &[])),
                (16, function("middle", &[24], &[])),
                (24, function("deep", &[0], code)),
            ])
        };
        for (code, _) in MASKING {
            let found = with(code).masks("interrupt").unwrap().unwrap();
            assert_eq!(found, ["interrupt", "middle", "deep"]);
        }
        for (code, _) in OTHERS {
            assert_eq!(with(code).masks("interrupt").unwrap(), None);
        }
        let named = graph(vec![
            (0, function("interrupt", &[8], &[])),
            (8, function("_critical_section_1_0_acquire", &[], &[])),
        ]);
        assert!(named.masks("interrupt").unwrap().is_some());
        assert!(with(&[]).masks("nobody").is_err());
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

    #[test]
    fn what_lies_elsewhere_is_named() {
        let function = |name: &str, calls: &[Place]| Function {
            name: name.to_owned(),
            calls: calls.iter().copied().collect(),
            ..Function::default()
        };
        let graph = CallGraph {
            functions: BTreeMap::from([
                (0, function("interrupt", &[8])),
                (8, function("near", &[64])),
                (64, function("far", &[72])),
                (72, function("farther", &[])),
            ]),
            reachable_by_address: BTreeSet::new(),
        };
        assert_eq!(graph.reach_outside("interrupt", &(0..64)).unwrap(), ["far"]);
        let found = graph.reach_outside("interrupt", &(0..65)).unwrap();
        assert_eq!(found, ["farther"]);
    }
}
