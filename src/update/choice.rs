//! Which bank is started: what the first stage does at every reset.

use super::header::Header;
use super::journal::{self, Kind};
use super::standing::{self, Bank};
use embedded_storage::nor_flash::NorFlash;
use heapless::Vec;

/// How often a new image is started before it was accepted. More than once, since the supply may go during a trial.
pub const TRIALS: u8 = 3;

/// A bank that may be started.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Candidate {
    /// 0 for bank 1, 1 for bank 2.
    pub bank: usize,
    /// Number of its image, if that is on trial: the mark is to be made before it is started.
    pub trial: Option<u32>,
}

impl Candidate {
    const fn settled(bank: usize) -> Self {
        Self { bank, trial: None }
    }
}

/// The banks in the order in which they are to be tried; the first whose body is whole is started.
///
/// An accepted image comes before the one that it replaced. Otherwise the image with the higher number comes first, on trial, until it
/// was refused or has used its trials up. Whatever the journals say, an image that is the only whole one is started.
pub fn candidates(banks: &[Bank; 2]) -> Vec<Candidate, 3> {
    let order = match later(banks) {
        Later::Accepted(bank) => [
            Some(Candidate::settled(bank)),
            Some(Candidate::settled(1 - bank)),
            None,
        ],
        Later::ToBeTried { bank, number } => [
            Some(Candidate {
                bank,
                trial: Some(number),
            }),
            Some(Candidate::settled(1 - bank)),
            Some(Candidate::settled(bank)),
        ],
    };
    let has_image = |candidate: &Candidate| banks[candidate.bank].header.is_some();
    let alone = banks.iter().filter(|bank| bank.header.is_some()).count() == 1;
    let of_use =
        |candidate: &Candidate| has_image(candidate) && !(alone && candidate.trial.is_some());
    order.into_iter().flatten().filter(of_use).collect()
}

enum Later {
    Accepted(usize),
    ToBeTried { bank: usize, number: u32 },
}

/// Which image comes first.
fn later(banks: &[Bank; 2]) -> Later {
    match [0, 1].map(|bank| has_accepted(&banks[bank], &banks[1 - bank])) {
        [true, false] => return Later::Accepted(1),
        [false, true] => return Later::Accepted(0),
        _ => {}
    }
    // An image without a number was put there by a debug probe.
    let bank = match (banks[0].number, banks[1].number) {
        (first, second) if second > first => 1,
        (first, second) if first > second => 0,
        _ => return Later::Accepted(0),
    };
    match banks[bank].number {
        Some(number) if may_be_tried(&banks[1 - bank], number) => Later::ToBeTried { bank, number },
        _ => Later::Accepted(1 - bank),
    }
}

/// Whether a bank's journal says that the image which now is in the other bank was accepted: not one that has been written over since, by a
/// debug probe's doing or because that bank was given up.
pub(super) fn has_accepted(bank: &Bank, other: &Bank) -> bool {
    let journal = bank.journal;
    journal.accepted > 0 && other.number.is_none_or(|number| number == journal.number)
}

/// Whether the image of that number, in the other bank, has trials left.
fn may_be_tried(other: &Bank, number: u32) -> bool {
    let journal = other.journal;
    journal.number != number || !journal.refused && journal.trials < TRIALS
}

/// Chooses the bank to start, and makes the mark of a trial. None: there is no whole image. `is_whole`: whether a bank holds the body that
/// its header tells of ([`standing::is_whole`], or the same by a unit of the chip's).
pub fn choose<F: NorFlash>(
    flash: &mut [F; 2],
    mut is_whole: impl FnMut(&mut F, &Header) -> bool,
) -> Option<Candidate> {
    let banks = flash.each_mut().map(standing::read);
    candidates(&banks).into_iter().find(|candidate| {
        let header = banks[candidate.bank].header.as_ref();
        header.is_some_and(|header| is_whole(&mut flash[candidate.bank], header))
            && mark(&mut flash[1 - candidate.bank], candidate)
    })
}

/// Marks a trial in the other bank's journal; one that cannot be marked must not begin.
fn mark<F: NorFlash>(other: &mut F, candidate: &Candidate) -> bool {
    let marked = |number| journal::append(other, number, Kind::Trial).is_ok();
    candidate.trial.is_none_or(marked)
}
