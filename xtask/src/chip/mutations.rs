//! What `cargo xtask chip --mutate` takes back: each fault that a review found in the image before its first silicon and that is
//! about the chip, as the smallest change of the sources that brings it in again, and what must show it.
//!
//! `find` must stand exactly once in its file. A change of the firmware that moves it moves it here too.

/// One exchange of text in one file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Edit {
    /// From the project's root.
    pub file: &'static str,
    /// Stands there exactly once.
    pub find: &'static str,
    /// Stands there instead.
    pub put: &'static str,
}

/// A fault that is brought in again.
#[derive(Debug)]
pub struct Mutation {
    /// What it is called on the command line.
    pub name: &'static str,
    /// What it does.
    pub what: &'static str,
    /// The change.
    pub edits: &'static [Edit],
    /// Name of the check that must fail.
    pub check: &'static str,
    /// What the check must say: a rule's name with a colon, or words of its own.
    pub shows: &'static str,
}

impl Mutation {
    /// The rule that it breaks, if it is one that shows it.
    pub fn rule(&self) -> Option<&'static str> {
        self.shows.strip_suffix(':')
    }
}

macro_rules! mutations {
    ($($name:literal, $what:literal, $check:literal => $shows:literal, [$($file:literal: $find:literal => $put:literal;)+];)*) => {
        &[$(Mutation {
            name: $name,
            what: $what,
            check: $check,
            shows: $shows,
            edits: &[$(Edit { file: $file, find: $find, put: $put },)+],
        },)*]
    };
}

/// All of them; the number is the review's. A further one is an entry here.
pub const MUTATIONS: &[Mutation] = mutations! {
    "1-data-cache", "the data cache stays on while bank 2 is written", "flags" => "flash-data-cache:", [
        "src/drivers/g4_flash.rs":
        "let off = access & !access::DATA_CACHE;" =>
        "let off = access;";
    ];

    "1-stale-cache", "the data cache is not emptied before it is on again", "flags" => "flash-stale-cache:", [
        "src/drivers/g4_flash.rs":
        "self.controller.set_access(off | access::DATA_CACHE_RESET);" =>
        "";
    ];

    "2-error-flags", "error flags of the past are not taken back before an operation", "flags" => "flash-sticky-error:", [
        "src/drivers/g4_flash.rs":
        "self.controller.clear_status(status::ERRORS);\n        let result" =>
        "let result";
    ];

    "3-missed-instants", "instants missed have no number", "halted" => "instants missed", [
        "src/app/sampler.rs":
        "newest.wrapping_sub(served).checked_sub(1)" =>
        "if newest == served { None } else { Some(0) }";
    ];

    "3-silent-converter", "instants missed while BUSY is silent have no number", "silent" => "instants missed", [
        "src/app/sampler.rs":
        "newest.wrapping_sub(served).checked_sub(1)" =>
        "if newest == served { None } else { Some(0) }";
    ];

    "4-wait-states", "the sampling interrupts run in flash, with its wait states", "time" => "cycles or fewer", [
        "memory.x":
        "    *(.text.EXTI9_5 .text.DMA1_CHANNEL2);\n    *(.text._ZN14courier_signal4step8isr_step* .text._ZN14courier_signal4step1*);\n    *(.text.unlikely._ZN14courier_signal4step6bridge*);\n" =>
        "";
    ];

    "5-old-temperature", "one conversion at a time, 100 ms apart", "restart" => "adc-stale:", [
        "src/board/g474/supervision.rs":
        "w.set_l(1);" =>
        "w.set_l(0);";
    ];

    "6-supply-detector", "the supply detector warns below the brown-out reset", "boot" => "supply-warning:", [
        "src/board/g474/supervision.rs":
        "const SUPPLY_LEVEL: u8 = 6;" =>
        "const SUPPLY_LEVEL: u8 = 5;";
    ];

    "7-short-convst", "CONVST is two stores on a pin of low speed", "boot" => "convst-width:", [
        "src/board/g474/pins.rs":
        "    CONVST.fast();\n" =>
        "";
        "src/drivers/converter/mod.rs":
        "delay.delay_us(CONVST_PULSE_US);" =>
        "let _ = (&delay, CONVST_PULSE_US);";
    ];

    "8-double-error", "wrong check bits of the code are taken for a torn slot", "code" => "the code is corrupt", [
        "src/drivers/g4_flash.rs":
        "None => false," =>
        "None => place & check_bits::UNCORRECTED != 0,";
    ];

    "9-single-bank", "the option bytes are not looked at", "single-bank" => "wanted a refusal", [
        "src/drivers/g4_flash.rs":
        "options & (options::DUAL_BANK | options::BOOT_BANK_2) == options::DUAL_BANK" =>
        "options & (options::DUAL_BANK | options::BOOT_BANK_2) != 1";
    ];

    "11-no-stop", "the courier is not told to stop at a start", "restart" => "goes on after the restart", [
        "src/app/background.rs":
        "self.guide.halt();\n    }\n\n    /// One turn" =>
        "}\n\n    /// One turn";
    ];

    "11-no-heartbeat", "the motion controller is not told to go on", "restart" => "the courier is not on its way", [
        "src/app/guide.rs":
        "Errand::Settle { .. } => Command::GoOn," =>
        "Errand::Settle { .. } => Command::WhereAreYou,";
    ];

    "12-no-place", "a hang of the background leaves no place", "hang" => "the background hangs", [
        "src/board/hang.rs":
        "    if quiet >= LOOKS {" =>
        "    if quiet >= u32::MAX {";
    ];

    "12-no-place-of-interrupt", "a hang of a sampling interrupt leaves no place", "hang" => "the start of a reading hangs", [
        "src/board/g474/mod.rs":
        "    last_look::start();\n" =>
        "";
    ];

    "12-no-safe-mode", "faults in a row are not counted", "hang" => "wanted safe mode", [
        "src/app/restarts.rs":
        "faults >= SAFE_AFTER" =>
        "faults == u8::MAX";
    ];

    "12-watchdog-last", "the watchdog starts after the clock has been waited for", "boot" => "watchdog-first:", [
        "src/board/first_stage/mod.rs":
        "    watchdog::start(WATCHDOG_MS);\n" =>
        "    let _ = WATCHDOG_MS;\n";
        "src/board/g474/mod.rs":
        "watchdog::start(WATCHDOG_MS as u16);\n    clocks::start();" =>
        "clocks::start();\n    watchdog::start(WATCHDOG_MS as u16);";
    ];

    "13-stale-byte", "after a failure no channel is set anew", "stale" => "shifts the frames", [
        "src/board/g474/reading.rs":
        "            self.stage = Stage::Shifted;\n" =>
        "";
    ];

    "15-prescaler", "the clock's source and the bus prescaler change in one write", "boot" => "prescaler-first:", [
        "src/board/g474/clocks.rs":
        "    RCC.cfgr().modify(|w| w.set_hpre(Hpre::DIV2));\n" =>
        "";
        "src/board/g474/clocks.rs":
        "RCC.cfgr().modify(|w| w.set_sw(Sw::PLL1_R));" =>
        "RCC.cfgr().modify(|w| { w.set_hpre(Hpre::DIV2); w.set_sw(Sw::PLL1_R); });";
    ];

    "15-clock-step", "the clock goes from 16 to 170 MHz in one step", "boot" => "clock-step:", [
        "src/board/g474/clocks.rs":
        "w.set_hpre(Hpre::DIV2)" =>
        "w.set_hpre(Hpre::DIV1)";
    ];

    "16-floating-convst", "CONVST floats until its channel is on", "boot" => "floating-line:", [
        "src/board/g474/pins.rs":
        "    CONVST.pull(Pupdr::PULL_DOWN);\n" =>
        "";
    ];

    "busy-count", "BUSY goes to a timer that does not count its pulses", "health" => "wanted none unanswered", [
        "src/board/g474/pins.rs":
        "BUSY.alternate(TIM8);" =>
        "BUSY.alternate(TIM3 + 0 * TIM8);";
    ];

    "update-stale-cache", "the caches are not emptied before the banks change places", "update" => "flash-stale-cache:", [
        "src/board/first_stage/mod.rs":
        "    FLASH.acr().write_value(empty);\n" =>
        "    let _ = empty;\n";
    ];

    "update-same-bank", "the page of bank 2 is erased, whichever bank runs", "update" => "flash-same-bank:", [
        "src/drivers/g4_flash.rs":
        "BankNumber::One => 0," =>
        "BankNumber::One => control::BANK_2,";
    ];

    "update-half-image", "the first stage starts an image that is not whole", "update-trial" => "an image that has decayed is started", [
        "src/board/first_stage/mod.rs":
        "choose(&mut banks, is_whole)" =>
        "choose(&mut banks, |_, _| true)";
    ];

    "update-no-trial", "a trial is not counted: an image that hangs is tried for ever", "update-trial" => "one that hangs is tried for ever", [
        "src/update/choice.rs":
        "            && mark(&mut flash[1 - candidate.bank], candidate)\n" =>
        "            && (true || mark(&mut flash[1 - candidate.bank], candidate))\n";
    ];

    "r1mode", "the regulator's boost bit at the place that stm32-metapac 21 has for it", "boot" => "voltage-range:", [
        "src/board/g474/clocks.rs":
        "const R1MODE: u32 = 1 << 8;" =>
        "const R1MODE: u32 = 1 << 0;";
    ];
};
