//! Bank 2 of the STM32G4's flash: the order in which its controller is worked, against a controller that keeps the manual's rules.

use courier_sensor::calibration::record::Calibration;
use courier_sensor::calibration::slots::{SlotError, Slots};
use courier_sensor::drivers::g4_flash::{
    Bank, BankNumber, Controller, Error, KEYS, access, check_bits, control, is_torn, options,
    status,
};
use courier_sensor::geometry::Geometry;
use embedded_storage::nor_flash::{NorFlash, NorFlashErrorKind, ReadNorFlash};
use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;

const PAGE: usize = 2048;

/// Looks at the status register that an operation takes here.
const BUSY_LOOKS: u32 = 3;

/// The controller and the bank's first pages. What the manual forbids sets an error flag, as it does on the chip, or is a fault.
struct Chip {
    memory: Vec<u8>,
    torn: BTreeSet<u32>,
    /// What the data cache holds: double words as they were read.
    cache: BTreeMap<u32, [u8; 8]>,
    access: u32,
    control: u32,
    keys: Vec<u32>,
    status: u32,
    busy_looks: u32,
    options: u32,
    supply_is_low: bool,
    /// The bank that it is; code runs from the other one.
    number: BankNumber,
    /// Flags that the next operations end with, one each.
    failures: Vec<u32>,
}

#[derive(Clone)]
struct Fake(Rc<RefCell<Chip>>);

impl Fake {
    fn new() -> Self {
        Self(Rc::new(RefCell::new(Chip {
            memory: vec![0xFF; 2 * PAGE],
            torn: BTreeSet::new(),
            cache: BTreeMap::new(),
            access: OTHER_ACCESS | access::DATA_CACHE,
            control: control::LOCK,
            keys: vec![],
            status: 0,
            busy_looks: 0,
            options: DELIVERED,
            supply_is_low: false,
            number: BankNumber::Two,
            failures: vec![],
        })))
    }

    fn with<R>(&self, f: impl FnOnce(&mut Chip) -> R) -> R {
        f(&mut self.0.borrow_mut())
    }
}

impl Chip {
    /// An operation begins; false if it is refused by a flag.
    fn begins(&mut self) -> bool {
        assert_eq!(
            self.busy_looks, 0,
            "an operation began before the last ended"
        );
        assert_eq!(self.control & control::LOCK, 0, "the controller is locked");
        let cache = self.access & access::DATA_CACHE;
        assert_eq!(cache, 0, "erratum 2.2.2: the data cache is on");
        if self.status & status::ERRORS != 0 {
            self.status |= SEQUENCE_ERROR;
        } else if let Some(flag) = self.failures.pop() {
            self.status |= flag;
        } else {
            self.busy_looks = BUSY_LOOKS;
            return true;
        }
        false
    }

    /// A byte as the processor reads it, through the cache if that is on.
    fn byte(&mut self, offset: u32) -> u8 {
        let (double_word, place) = (offset & !7, offset as usize % 8);
        let fresh: [u8; 8] = self.memory[double_word as usize..][..8].try_into().unwrap();
        if self.access & access::DATA_CACHE == 0 {
            return fresh[place];
        }
        self.cache.entry(double_word).or_insert(fresh)[place]
    }

    fn erase(&mut self) {
        let bank_2 = self.control & control::BANK_2 != 0;
        let own = self.number == BankNumber::Two;
        assert_eq!(bank_2, own, "that is the code's bank");
        assert_eq!(self.control & control::PROGRAM, 0);
        let page = (self.control >> control::PAGE_SHIFT & 0x7F) as usize;
        if self.begins() {
            self.memory[page * PAGE..][..PAGE].fill(0xFF);
            let range = (page * PAGE) as u32..((page + 1) * PAGE) as u32;
            self.torn.retain(|offset| !range.contains(offset));
        }
    }
}

/// Option bytes as the chip is delivered: two banks (factory value of OPTR).
const DELIVERED: u32 = 0xFFEF_F8AA;
/// Wait states, prefetch, instruction cache.
const OTHER_ACCESS: u32 = 4 | 1 << 8 | 1 << 9;
/// PGSERR and PROGERR.
const SEQUENCE_ERROR: u32 = 1 << 7;
const PROGRAM_ERROR: u32 = 1 << 3;

impl Controller for Fake {
    fn number(&mut self) -> BankNumber {
        self.with(|chip| chip.number)
    }

    fn status(&mut self) -> u32 {
        self.with(|chip| {
            if chip.busy_looks > 0 {
                chip.busy_looks -= 1;
                return chip.status | status::BUSY;
            }
            chip.status
        })
    }

    fn clear_status(&mut self, flags: u32) {
        self.with(|chip| chip.status &= !flags);
    }

    fn control(&mut self) -> u32 {
        self.with(|chip| chip.control)
    }

    fn set_control(&mut self, bits: u32) {
        self.with(|chip| {
            assert_eq!(chip.control & control::LOCK, 0, "the controller is locked");
            chip.control = bits;
            if bits & control::START != 0 {
                chip.erase();
                chip.control &= !control::START;
            }
        });
    }

    fn access(&mut self) -> u32 {
        self.with(|chip| chip.access)
    }

    fn set_access(&mut self, bits: u32) {
        self.with(|chip| {
            assert_eq!(
                bits & OTHER_ACCESS,
                OTHER_ACCESS,
                "wait states and the like"
            );
            if bits & access::DATA_CACHE_RESET != 0 {
                assert_eq!(chip.access & access::DATA_CACHE, 0, "reset while on");
                chip.cache.clear();
            }
            chip.access = bits & !access::DATA_CACHE_RESET;
        });
    }

    fn options(&mut self) -> u32 {
        self.with(|chip| chip.options)
    }

    fn key(&mut self, key: u32) {
        self.with(|chip| {
            chip.keys.push(key);
            if chip.keys.ends_with(&KEYS) {
                chip.control &= !control::LOCK;
            }
        });
    }

    fn supply_is_low(&mut self) -> bool {
        self.with(|chip| chip.supply_is_low)
    }

    fn program(&mut self, offset: u32, words: [u32; 2]) {
        self.with(|chip| {
            if chip.control & control::PROGRAM == 0 {
                chip.status |= SEQUENCE_ERROR;
                return;
            }
            let place = &chip.memory[offset as usize..][..8];
            let erased = place == [0xFF; 8] || words == [0; 2];
            if !erased {
                chip.status |= PROGRAM_ERROR;
            } else if chip.begins() {
                let bytes = words.map(u32::to_le_bytes);
                chip.memory[offset as usize..][..8].copy_from_slice(bytes.as_flattened());
            }
        });
    }

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> bool {
        self.with(|chip| {
            for (place, offset) in bytes.iter_mut().zip(offset..) {
                *place = chip.byte(offset);
            }
            let double_words = offset & !7..offset + bytes.len() as u32;
            chip.torn.range(double_words).next().is_some()
        })
    }
}

fn calibration(uptime_s: u32) -> Calibration {
    let mut calibration = Calibration::identity(Geometry::PAPER);
    calibration.made.uptime_s = uptime_s;
    calibration
}

/// Slots with one calibration in each.
fn slots() -> (Fake, Slots<Bank<Fake>>) {
    let fake = Fake::new();
    let mut slots = Slots::new(Bank::new(fake.clone()), 0);
    slots.commit(&calibration(1), false).unwrap();
    slots.commit(&calibration(2), false).unwrap();
    (fake, slots)
}

#[test]
fn slots_are_stored_and_read_and_the_controller_is_locked_again() {
    let (fake, mut slots) = slots();
    assert_eq!(slots.load().unwrap().1, calibration(2));
    slots.roll_back().unwrap();
    assert_eq!(slots.load().unwrap().1, calibration(1));
    assert_eq!(fake.with(|chip| chip.control), control::LOCK);
}

#[test]
fn a_torn_double_word_is_an_error_where_it_is_read() {
    let (fake, mut slots) = slots();
    fake.with(|chip| chip.torn.insert(PAGE as u32 + 40));
    assert_eq!(slots.load().unwrap().1, calibration(1));
    let mut bank = slots.release();
    let mut bytes = [0; 16];
    assert_eq!(bank.read(PAGE as u32 + 32, &mut bytes), Err(Error::Torn));
    assert_eq!(bank.read(PAGE as u32 + 48, &mut bytes), Ok(()));
}

#[test]
fn a_low_supply_and_a_place_that_is_none_write_nothing() {
    let fake = Fake::new();
    let mut bank = Bank::new(fake.clone());
    let outside = Error::Arguments(NorFlashErrorKind::OutOfBounds);
    assert_eq!(bank.write(256 << 10, &[0; 8]), Err(outside));
    let aside = Error::Arguments(NorFlashErrorKind::NotAligned);
    assert_eq!(bank.write(4, &[0; 8]), Err(aside));
    fake.with(|chip| chip.supply_is_low = true);
    assert_eq!(bank.write(0, &[0; 8]), Err(Error::SupplyLow));
    assert_eq!(bank.erase(0, 2048), Err(Error::SupplyLow));
    assert!(fake.with(|chip| chip.keys.is_empty()));
}

#[test]
fn an_operation_that_fails_is_said() {
    let (fake, mut slots) = slots();
    fake.with(|chip| chip.failures = vec![PROGRAM_ERROR]);
    let error = slots.commit(&calibration(3), false).unwrap_err();
    assert!(matches!(error, SlotError::Erase { slot: 0, .. }), "{error}");
    assert_eq!(slots.load().unwrap().1, calibration(2));
}

#[test]
fn flags_of_the_past_refuse_nothing_and_none_are_left() {
    for flag in (0..16)
        .map(|bit| 1 << bit)
        .filter(|flag| flag & status::ERRORS != 0)
    {
        let (fake, mut slots) = slots();
        // From before the start, as after one that the debugger programmed.
        fake.with(|chip| chip.status = flag);
        slots.commit(&calibration(3), false).unwrap();
        // Of an operation that failed: the next commit does not.
        fake.with(|chip| chip.failures = vec![flag]);
        slots.commit(&calibration(4), false).unwrap_err();
        assert_eq!(fake.with(|chip| chip.status), 0, "{flag:#x}");
        slots.commit(&calibration(4), false).unwrap();
        assert_eq!(slots.load().unwrap().1, calibration(4), "{flag:#x}");
    }
}

#[test]
fn the_data_cache_is_off_while_the_bank_is_written_and_holds_nothing_old_afterwards() {
    let (fake, slots) = slots();
    let mut bank = slots.release();
    let mut bytes = [0; 8];
    bank.read(8, &mut bytes).unwrap();
    assert!(fake.with(|chip| chip.cache.contains_key(&8)));
    // What was written is read, not what the cache held; wrong or right, the cache is on again.
    bank.erase(0, 2048).unwrap();
    bank.read(8, &mut bytes).unwrap();
    assert_eq!(bytes, [0xFF; 8]);
    bank.write(8, &[7; 8]).unwrap();
    bank.read(8, &mut bytes).unwrap();
    assert_eq!(bytes, [7; 8]);
    bank.write(8, &[9; 8]).unwrap_err();
    let on = OTHER_ACCESS | access::DATA_CACHE;
    assert_eq!(fake.with(|chip| chip.access), on);
}

#[test]
fn wrong_check_bits_are_a_torn_double_words_only_in_the_bank_that_is_read() {
    let places = [(BankNumber::One, 0), (BankNumber::Two, check_bits::BANK_2)];
    for (number, place) in places {
        let torn = check_bits::UNCORRECTED | place | 0x40;
        assert!(is_torn(torn, Some(number)), "{number:?}");
        assert!(!is_torn(torn, None), "nobody reads {number:?}");
        assert!(!is_torn(torn, Some(number.other())), "code: {number:?}");
        let system = torn | check_bits::SYSTEM_MEMORY;
        assert!(!is_torn(system, Some(number)), "{number:?}");
        assert!(!is_torn(place, Some(number)), "corrected, or none");
    }
}

#[test]
fn after_the_banks_have_changed_places_the_pages_of_bank_1_are_erased() {
    let (fake, slots) = slots();
    fake.with(|chip| chip.number = BankNumber::One);
    let mut bank = slots.release();
    bank.erase(0, 2048).unwrap();
    let mut bytes = [0; 8];
    bank.read(8, &mut bytes).unwrap();
    assert_eq!(bytes, [0xFF; 8]);
}

#[test]
fn the_bank_that_code_runs_from_is_read_and_never_written() {
    let (fake, slots) = slots();
    drop(slots);
    fake.with(|chip| chip.keys.clear());
    let mut bank = Bank::running(fake.clone());
    let mut bytes = [0; 8];
    bank.read(0, &mut bytes).unwrap();
    assert_ne!(bytes, [0xFF; 8]);
    assert_eq!(bank.erase(0, 2048), Err(Error::Running));
    assert_eq!(bank.write(2040, &[0; 8]), Err(Error::Running));
    assert!(fake.with(|chip| chip.keys.is_empty()), "not even unlocked");
}

#[test]
fn a_flash_that_is_laid_out_otherwise_is_read_and_never_written() {
    for wrong in [
        DELIVERED & !options::DUAL_BANK,
        DELIVERED | options::BOOT_BANK_2,
        0,
    ] {
        let (fake, mut slots) = slots();
        fake.with(|chip| {
            chip.options = wrong;
            chip.keys.clear();
        });
        slots.commit(&calibration(3), false).unwrap_err();
        assert_eq!(slots.load().unwrap().1, calibration(2));
        let mut bank = slots.release();
        assert_eq!(bank.erase(0, 2048), Err(Error::Layout));
        assert_eq!(bank.write(0, &[0; 8]), Err(Error::Layout));
        assert!(fake.with(|chip| chip.keys.is_empty()), "not even unlocked");
    }
}
