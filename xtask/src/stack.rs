//! Worst stack and call graph of an image, from its instructions alone.
//!
//! A function's frame is the sum of all that its instructions take, so shrink-wrapped prologues count in full: an upper
//! bound. A call through a register may reach every function whose address lies in the image's data or is made by code.

use crate::functions::{Constants, Function, Place, addresses, follow, functions, is_thunk, made};
use anyhow::{Context, Result, ensure};
use object::{Object, ObjectSection, SectionKind};
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::ops::Range;
use std::path::Path;

pub use crate::functions::readable;

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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::functions::holds_back;
    use crate::functions::words::{MASKING, OTHERS};

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
