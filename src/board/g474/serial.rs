//! USART1 to the motion controller: two queues, filled and emptied by its interrupt, below the sampling one.

use super::clocks::CLOCK_HZ;
use crate::drivers::motion::FRAME_BYTES;
use crate::queue;
use embedded_io::{ErrorKind, ErrorType, Read, ReadReady, Write, WriteReady};
use heapless::spsc::{Consumer, Producer, Queue};
use stm32_metapac::{RCC, USART1};

/// Bits a second.
pub const BAUD: u32 = 1_000_000;
/// Places for bytes to send: a frame's. Derived from the port, which hands the next one over once the last has left it, and goes on with what
/// found no room.
const TO_SEND: usize = 64;
/// Places for received bytes: three frames'. Derived from the requests, of which one is open at a time: its answer, one to a request that was
/// given up, and one that was half received when the background began to write to flash.
const RECEIVED: usize = 128;
// A queue holds one byte less than it has places.
const _: () = assert!(TO_SEND > FRAME_BYTES && RECEIVED > 3 * FRAME_BYTES);

/// Bytes to the motion controller.
pub type SendQueue = Queue<u8, TO_SEND>;
/// Bytes from it.
pub type ReceiveQueue = Queue<u8, RECEIVED>;

/// The interrupt's end.
pub struct Interrupt {
    received: Producer<'static, u8>,
    to_send: Consumer<'static, u8>,
}

/// The background's end.
pub struct Serial {
    received: Consumer<'static, u8>,
    to_send: Producer<'static, u8>,
}

/// Switches the peripheral on and gives out both ends.
pub fn start(
    received: &'static mut ReceiveQueue,
    to_send: &'static mut SendQueue,
) -> (Interrupt, Serial) {
    RCC.apb2enr().modify(|w| w.set_usart1en(true));
    USART1
        .brr()
        .write(|w| w.set_brr(u16::try_from(CLOCK_HZ.div_ceil(BAUD)).unwrap_or(u16::MAX)));
    USART1.cr3().modify(|w| w.set_ovrdis(true));
    USART1.cr1().modify(|w| {
        w.set_fifoen(true);
        w.set_te(true);
        w.set_re(true);
        w.set_rxneie(true);
        w.set_ue(true);
    });
    let (receive, received) = received.split();
    let (send, to_send) = to_send.split();
    (
        Interrupt {
            received: receive,
            to_send,
        },
        Serial {
            received,
            to_send: send,
        },
    )
}

impl Interrupt {
    /// Moves bytes between the queues and the peripheral; never waits. A byte without room is dropped: its frame's CRC tells.
    pub fn serve(&mut self) {
        while USART1.isr().read().rxne() {
            let _ = queue::enqueue(&mut self.received, USART1.rdr().read().dr() as u8);
        }
        while USART1.isr().read().txe() {
            match queue::dequeue(&mut self.to_send) {
                Some(byte) => USART1.tdr().write(|w| w.set_dr(u16::from(byte))),
                None => {
                    USART1.cr1().modify(|w| w.set_txeie(false));
                    return;
                }
            }
        }
    }
}

impl ErrorType for Serial {
    type Error = ErrorKind;
}

impl ReadReady for Serial {
    fn read_ready(&mut self) -> Result<bool, ErrorKind> {
        Ok(self.received.ready())
    }
}

impl Read for Serial {
    /// Never waits: with nothing received it is a time-out.
    fn read(&mut self, buffer: &mut [u8]) -> Result<usize, ErrorKind> {
        let mut count = 0;
        for place in buffer.iter_mut() {
            let Some(byte) = self.received.dequeue() else {
                break;
            };
            *place = byte;
            count += 1;
        }
        if count == 0 && !buffer.is_empty() {
            Err(ErrorKind::TimedOut)
        } else {
            Ok(count)
        }
    }
}

impl WriteReady for Serial {
    fn write_ready(&mut self) -> Result<bool, ErrorKind> {
        Ok(self.to_send.ready())
    }
}

impl Write for Serial {
    /// Never waits: takes as many bytes as there is room for; with no room it is a time-out.
    fn write(&mut self, bytes: &[u8]) -> Result<usize, ErrorKind> {
        let mut count = 0;
        for byte in bytes {
            if self.to_send.enqueue(*byte).is_err() {
                break;
            }
            count += 1;
        }
        // The interrupt may switch this off at the same instant; the next write switches it on again.
        critical_section::with(|_| USART1.cr1().modify(|w| w.set_txeie(true)));
        if count == 0 && !bytes.is_empty() {
            Err(ErrorKind::TimedOut)
        } else {
            Ok(count)
        }
    }

    fn flush(&mut self) -> Result<(), ErrorKind> {
        Ok(())
    }
}
