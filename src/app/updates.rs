//! Updates on a board that has two banks and a first stage: orders in, the other bank's flash changed, state out.
//!
//! A board without offers none, and the code for it is not in its image.

use crate::update::header;
use crate::update::install::{Install, Rules, UpdateRefusal, next_number};
use crate::update::key;
use crate::update::order::{UpdateOrder, UpdateStatus};
use crate::update::standing::{self, Bank};
use crate::update::trial::{self, Standing, TRIAL_S};
use crate::update::version::Version;
use embedded_storage::nor_flash::NorFlash;

/// What the background needs of updates. `F` is the bank that no code runs from.
pub trait Updates<F> {
    /// Carries an order out. `uptime_s`: seconds since the board's start.
    ///
    /// # Errors
    /// [`UpdateRefusal`]; what runs still does.
    fn act(
        &mut self,
        flash: &mut F,
        order: &UpdateOrder,
        uptime_s: u32,
    ) -> Result<UpdateStatus, UpdateRefusal>;

    /// A slice of what takes long; false if there is nothing to do.
    fn work(&mut self, flash: &mut F) -> bool;

    /// Whether an image is being taken in or checked.
    fn is_under_way(&self) -> bool;

    /// Whether the image that runs is on trial: it stores nothing.
    fn is_on_trial(&self) -> bool;

    /// The version that runs.
    fn running(&self) -> Version;

    /// The version that was taken in and is tried at the next start.
    fn taken(&self) -> Option<Version>;

    /// Whether its time to be accepted is over. It is refused then, once, and the board is to restart.
    fn is_over(&mut self, flash: &mut F, uptime_s: u32) -> bool;
}

/// For a board with a first stage.
pub struct Updater {
    /// The highest number of an image that the bank knows of which code runs from.
    near_number: u32,
    rules: Rules,
    standing: Standing,
    install: Install,
    refused: bool,
}

impl Updater {
    /// `near`: the bank that code runs from. `rules`: of which `allow_older` is each order's. `standing`: by [`trial::start`].
    pub fn new(near: &Bank, rules: Rules, standing: Standing) -> Self {
        Self {
            near_number: near.highest_number(),
            rules,
            standing,
            install: Install::Idle,
            refused: false,
        }
    }

    fn begin<F: NorFlash>(
        &mut self,
        flash: &mut F,
        header: &[u8],
        allow_older: bool,
    ) -> Result<(), UpdateRefusal> {
        if self.is_trying() {
            return Err(UpdateRefusal::OnTrial);
        }
        let bytes: &[u8; header::BYTES] = header.try_into().map_err(|_| UpdateRefusal::Header)?;
        let rules = Rules {
            allow_older,
            ..self.rules
        };
        let number = next_number(self.near_number, &standing::read(flash));
        self.install = Install::begin(flash, bytes, &rules, number)?;
        Ok(())
    }

    fn accept<F: NorFlash>(&mut self, flash: &mut F) -> Result<(), UpdateRefusal> {
        let number = self.number_on_trial()?;
        self.standing.moved.map_err(|_| UpdateRefusal::NotMoved)?;
        trial::accept(flash, number)?;
        self.standing.trial = None;
        Ok(())
    }

    fn refuse<F: NorFlash>(&mut self, flash: &mut F) -> Result<(), UpdateRefusal> {
        let number = self.number_on_trial()?;
        self.refused = true;
        Ok(trial::refuse(flash, number)?)
    }

    fn number_on_trial(&self) -> Result<u32, UpdateRefusal> {
        let number = self.standing.trial.filter(|_| !self.refused);
        number.ok_or(UpdateRefusal::NotOnTrial)
    }

    fn is_trying(&self) -> bool {
        self.standing.trial.is_some()
    }

    fn status(&self, uptime_s: u32) -> UpdateStatus {
        let left_s = |_| TRIAL_S.saturating_sub(uptime_s);
        UpdateStatus {
            running: self.rules.version,
            trial_left_s: self.standing.trial.map(left_s),
            development_key: key::is_development(&self.rules.key),
            progress: self.install.progress(),
        }
    }
}

impl<F: NorFlash> Updates<F> for Updater {
    fn act(
        &mut self,
        flash: &mut F,
        order: &UpdateOrder,
        uptime_s: u32,
    ) -> Result<UpdateStatus, UpdateRefusal> {
        match order {
            UpdateOrder::Status => Ok(()),
            UpdateOrder::Begin {
                header,
                allow_older,
            } => self.begin(flash, header, *allow_older),
            UpdateOrder::Piece { offset, bytes } => self.install.data(flash, *offset, bytes),
            UpdateOrder::Finish => self.install.finish(),
            UpdateOrder::Accept => self.accept(flash),
            UpdateOrder::Refuse => self.refuse(flash),
        }
        .map(|()| self.status(uptime_s))
    }

    fn work(&mut self, flash: &mut F) -> bool {
        self.install.work(flash)
    }

    fn is_under_way(&self) -> bool {
        matches!(self.install, Install::Receiving(_) | Install::Checking(_))
    }

    fn is_on_trial(&self) -> bool {
        self.is_trying()
    }

    fn running(&self) -> Version {
        self.rules.version
    }

    fn taken(&self) -> Option<Version> {
        match self.install {
            Install::Installed(version) => Some(version),
            _ => None,
        }
    }

    fn is_over(&mut self, flash: &mut F, uptime_s: u32) -> bool {
        let is_over = self.is_trying() && uptime_s >= TRIAL_S;
        if is_over && !self.refused {
            // If the mark cannot be made, the trials run out.
            let _ = self.refuse(flash);
        }
        is_over
    }
}
