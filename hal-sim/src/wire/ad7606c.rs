//! An AD7606C-16 as its bus master sees it: registers, the two modes, the delayed reply, both CRCs, BUSY.
//!
//! Written from the data sheet's side and apart from the driver: shift registers of its own instead of the driver's tables.
//! Known simplification: with more than one DOUT line set (the state after reset) DOUTA gives the first line's channels and then zeros.

/// Channels of one chip.
pub const CHANNELS: usize = 8;

const STATUS: u8 = 0x01;
const CONFIG: u8 = 0x02;
const RANGE_FIRST: u8 = 0x03;
const OVERSAMPLING: u8 = 0x08;
const OFFSET_FIRST: u8 = 0x11;
const DIAGNOSTIC_ENABLE: u8 = 0x21;
const DIAGNOSTIC_ERROR: u8 = 0x22;
const ID: u8 = 0x2F;
const REGISTERS: usize = 0x30;
const INTERFACE_CRC: u8 = 1 << 2;
const INTERFACE_CHECK: u8 = 1 << 7;
const RESET_DETECTED: u8 = 1 << 7;
/// Words given in place of conversions while the interface check is on; the first is confirmed by users' reports.
const CHECK_PATTERN: [u16; CHANNELS] = [
    0xACCA, 0x5CC5, 0xA33A, 0x5335, 0xCAAC, 0xC55C, 0x3AA3, 0x3553,
];
/// Voltage that the plant's counts are of: 32768 counts at 5 V.
const REFERENCE_FULL_SCALE_V: f64 = 5.0;
const LONGEST_FRAME: usize = 64;

/// One chip.
#[derive(Clone, Debug)]
pub struct Ad7606c {
    registers: [u8; REGISTERS],
    /// Level of the OS pins at reset: all high selects software mode.
    software_mode: bool,
    register_mode: bool,
    pending_read: Option<u8>,
    results: [i16; CHANNELS],
    converting: Option<([i16; CHANNELS], u64)>,
    device_id: u8,
    out: [u8; LONGEST_FRAME],
    out_len: usize,
    clocked: usize,
    command: [u8; 3],
    /// Edges of CONVST that came while a conversion was under way: the chip ignores them.
    pub early_edges: u32,
    /// Resets so far, the one at power-up included.
    pub resets: u32,
}

impl Default for Ad7606c {
    fn default() -> Self {
        Self::new(0x31)
    }
}

impl Ad7606c {
    /// A chip with this identity (0x31 in the data sheet), wired for software mode, before its first reset.
    pub fn new(device_id: u8) -> Self {
        let mut chip = Self {
            registers: [0; REGISTERS],
            software_mode: true,
            register_mode: false,
            pending_read: None,
            results: [0; CHANNELS],
            converting: None,
            device_id,
            out: [0; LONGEST_FRAME],
            out_len: 0,
            clocked: 0,
            command: [0; 3],
            early_edges: 0,
            resets: 0,
        };
        chip.reset();
        chip
    }

    /// A chip whose OS pins are not all high: it has no registers.
    pub fn wire_hardware_mode(&mut self) {
        self.software_mode = false;
    }

    /// RESET pin, or the supply coming back.
    pub fn reset(&mut self) {
        self.resets += 1;
        self.registers = [0; REGISTERS];
        self.registers[usize::from(STATUS)] = RESET_DETECTED;
        self.registers[usize::from(CONFIG)] = 0x08;
        self.registers[usize::from(RANGE_FIRST)..][..4].fill(0x33);
        self.registers[usize::from(OFFSET_FIRST)..][..CHANNELS].fill(0x80);
        self.registers[usize::from(DIAGNOSTIC_ENABLE)] = 0x01;
        self.registers[usize::from(ID)] = self.device_id;
        self.register_mode = false;
        self.pending_read = None;
        self.converting = None;
        self.results = [0; CHANNELS];
    }

    /// Rising edge of CONVST: all channels are sampled now. `inputs`: counts at ±5 V full scale.
    pub fn convst(&mut self, now_ns: u64, inputs: &[i16; CHANNELS]) {
        self.settle(now_ns);
        if self.converting.is_some() {
            self.early_edges += 1;
            return;
        }
        let counts = std::array::from_fn(|channel| self.quantise(channel, inputs[channel]));
        let ratio = 1u64 << self.registers[usize::from(OVERSAMPLING)].min(8);
        self.converting = Some((counts, now_ns + 850 + (ratio - 1) * 1200));
    }

    /// Level of the BUSY pin.
    pub fn busy(&mut self, now_ns: u64) -> bool {
        self.settle(now_ns);
        self.converting.is_some()
    }

    /// Chip select falls.
    pub fn select(&mut self, now_ns: u64) {
        self.settle(now_ns);
        self.clocked = 0;
        self.command = [0; 3];
        self.out_len = 0;
        match self.pending_read.take() {
            Some(address) => self.load_register(address),
            None if self.register_mode => {}
            None => self.load_results(),
        }
    }

    /// Eight clocks: one byte in on SDI, one out on DOUTA.
    pub fn exchange(&mut self, sdi: u8) -> u8 {
        let out = if self.clocked < self.out_len {
            self.out[self.clocked]
        } else {
            0
        };
        if let Some(slot) = self.command.get_mut(self.clocked) {
            *slot = sdi;
        }
        self.clocked += 1;
        out
    }

    /// Chip select rises: the command takes effect.
    pub fn deselect(&mut self) {
        let crc = self.interface_crc();
        if !self.software_mode || self.clocked < 2 + usize::from(crc) {
            return;
        }
        let [head, value, check] = self.command;
        let (write_enable, read, address) = (head & 0x80 == 0, head & 0x40 != 0, head & 0x3F);
        if !write_enable || !(read || self.register_mode) {
            return;
        }
        if crc && crc8([head, value]) != check {
            self.registers[usize::from(DIAGNOSTIC_ERROR)] |= INTERFACE_CRC;
            return;
        }
        if read {
            self.register_mode = true;
            self.pending_read = Some(address);
        } else if address == 0 {
            self.register_mode = false;
        } else {
            self.write(address, value);
        }
    }

    fn write(&mut self, address: u8, value: u8) {
        if !matches!(address, STATUS | DIAGNOSTIC_ERROR | ID) && usize::from(address) < REGISTERS {
            self.registers[usize::from(address)] = value;
        }
    }

    fn settle(&mut self, now_ns: u64) {
        if let Some((counts, ready_ns)) = self.converting
            && now_ns >= ready_ns
        {
            self.results = counts;
            self.converting = None;
        }
    }

    fn quantise(&self, channel: usize, input: i16) -> i16 {
        if self.registers[usize::from(DIAGNOSTIC_ENABLE)] & INTERFACE_CHECK != 0 {
            return CHECK_PATTERN[channel] as i16;
        }
        let pair = self.registers[usize::from(RANGE_FIRST) + channel / 2];
        let full_scale_v = match pair >> (4 * (channel % 2)) & 0xF {
            0 => 2.5,
            1 => 5.0,
            2 => 6.25,
            3 => 10.0,
            _ => 12.5,
        };
        let offset = f64::from(self.registers[usize::from(OFFSET_FIRST) + channel]) - 128.0;
        let counts = f64::from(input) * (REFERENCE_FULL_SCALE_V / full_scale_v) + offset;
        counts
            .round()
            .clamp(f64::from(i16::MIN), f64::from(i16::MAX)) as i16
    }

    fn interface_crc(&self) -> bool {
        self.registers[usize::from(DIAGNOSTIC_ENABLE)] & INTERFACE_CRC != 0
    }

    fn load_register(&mut self, address: u8) {
        let value = self
            .registers
            .get(usize::from(address))
            .copied()
            .unwrap_or(0);
        self.out[..2].copy_from_slice(&[0, value]);
        self.out[2] = crc8([0, value]);
        self.out_len = 2 + usize::from(self.interface_crc());
        if address == STATUS {
            self.registers[usize::from(STATUS)] &= !RESET_DETECTED;
        }
    }

    fn load_results(&mut self) {
        let lines = 1usize << (self.registers[usize::from(CONFIG)] >> 3 & 0x3);
        let words = CHANNELS / lines;
        for (slot, word) in self.out.chunks_exact_mut(2).zip(&self.results[..words]) {
            slot.copy_from_slice(&word.to_be_bytes());
        }
        self.out_len = 2 * words;
        if self.interface_crc() {
            let crc = crc16(&self.out[..self.out_len]);
            self.out[self.out_len..][..2].copy_from_slice(&crc.to_be_bytes());
            self.out_len += 2;
        }
    }
}

/// Linear feedback shift register of `width` bits from zero, most significant bit first.
const fn shift(polynomial: u32, width: u32, mut register: u32, byte: u8) -> u32 {
    let mut bit = 8;
    while bit > 0 {
        bit -= 1;
        let feedback = (register >> (width - 1) ^ (byte >> bit) as u32) & 1;
        register =
            (register << 1 ^ if feedback == 1 { polynomial } else { 0 }) & ((1 << width) - 1);
    }
    register
}

/// What the conversion register does with each upper byte: the simulator's time goes there otherwise.
const CRC16_STEPS: [u16; 256] = {
    let mut steps = [0; 256];
    let mut byte = 0;
    while byte < 256 {
        steps[byte] = shift(0x755B, 16, 0, byte as u8) as u16;
        byte += 1;
    }
    steps
};

fn crc8(bytes: [u8; 2]) -> u8 {
    bytes
        .iter()
        .fold(0, |register, &byte| shift(0x07, 8, register, byte)) as u8
}

fn crc16(bytes: &[u8]) -> u16 {
    bytes.iter().fold(0, |register, byte| {
        register << 8 ^ CRC16_STEPS[usize::from((register >> 8) as u8 ^ byte)]
    })
}
