//! Commands to a board and samples from it, over any [`Wire`].

use crate::Wire;
use anyhow::{Context, Result, bail};
use courier_sensor::link::client::Client;
use courier_sensor::link::framing::Decoder;
use courier_sensor::link::message::{
    Action, BoardStatus, FRAME_BYTES, Hello, PROTOCOL, REPLY_CHANNEL, Reply, TELEMETRY_CHANNEL,
    check_versions,
};
use courier_sensor::link::telemetry::{self, Block, Channels, Sample, StreamOrder};
use std::time::Duration;

/// Time for one look at the channels, of the board's own.
const LOOK: Duration = Duration::from_micros(500);
/// A reply is given up after so long. A commit erases and writes flash, which takes some 25 ms.
const PATIENCE: Duration = Duration::from_secs(2);
/// Hellos until a board is given up.
const HELLOS: u32 = 3;
/// Bytes of a stream that are kept at most until somebody listens: more than comes while a reply is waited for, [`PATIENCE`] at 0.8 MB/s.
const KEPT_BYTES: usize = 2 << 20;

/// A board that has introduced itself.
pub struct Link {
    wire: Box<dyn Wire>,
    client: Client,
    hello: Hello,
    samples: Decoder<{ telemetry::FRAME_BYTES }>,
    /// What has come of the stream while a reply was waited for: the board's ring holds 13 ms of it, and a commit takes longer.
    kept: Vec<u8>,
    lost: u32,
}

impl Link {
    /// Says hello.
    ///
    /// # Errors
    /// The board does not answer, or speaks another version of the protocol: the message says which side to update.
    pub fn connect(mut wire: Box<dyn Wire>) -> Result<Self> {
        let mut client = Client::new();
        let hello = greet(&mut *wire, &mut client)?;
        Ok(Self {
            wire,
            client,
            hello,
            samples: Decoder::new(),
            kept: vec![],
            lost: 0,
        })
    }

    /// Lets the board restart from what it has stored, and says hello anew.
    ///
    /// # Errors
    /// As [`Link::connect`].
    pub fn restart(&mut self) -> Result<()> {
        let Reply::Done = self.ask(Action::Restart)? else {
            bail!("the board: found a strange reply to a restart")
        };
        self.reconnect()
    }

    /// Says hello to a board that has restarted by itself.
    ///
    /// # Errors
    /// As [`Link::connect`].
    pub fn reconnect(&mut self) -> Result<()> {
        self.hello = greet(&mut *self.wire, &mut self.client)?;
        self.samples = Decoder::new();
        self.kept.clear();
        Ok(())
    }

    /// The bytes below: for what is no command.
    pub fn wire(&mut self) -> &mut dyn Wire {
        &mut *self.wire
    }

    /// Who is there.
    pub fn hello(&self) -> &Hello {
        &self.hello
    }

    /// Asks and waits for the reply.
    ///
    /// # Errors
    /// The board refuses, by name, or does not answer.
    pub fn ask(&mut self, action: Action) -> Result<Reply> {
        self.ask_patiently(action, PATIENCE)
    }

    /// Asks and waits so long for the reply, of the board's own time: one that solves answers afterwards.
    ///
    /// # Errors
    /// As [`Link::ask`].
    pub fn ask_patiently(&mut self, action: Action, patience: Duration) -> Result<Reply> {
        let mut buffer = [0; FRAME_BYTES];
        let (number, bytes) = self.client.ask(action, &mut buffer)?;
        let (wire, client) = (&mut *self.wire, &mut self.client);
        let kept = &mut self.kept;
        let keep = |wire: &mut dyn Wire| keep_stream(wire, kept);
        let reply = exchange(wire, client, number, bytes, patience, keep)?;
        let told =
            || format!("the board: found no reply within {patience:?} of its time, wanted one");
        match reply.with_context(told)? {
            Reply::Refused(refusal) => bail!("the board refuses: {refusal}"),
            reply => Ok(reply),
        }
    }

    /// State of the board.
    ///
    /// # Errors
    /// As [`Link::ask`].
    pub fn status(&mut self) -> Result<BoardStatus> {
        match self.ask(Action::Status)? {
            Reply::Status(status) => Ok(status),
            _ => bail!("the board: found a strange reply to a question for its status"),
        }
    }

    /// Starts a stream of samples, or ends it if no channel is named.
    ///
    /// # Errors
    /// As [`Link::ask`].
    pub fn stream(&mut self, channels: Channels, decimation: u16) -> Result<()> {
        let order = StreamOrder {
            channels: channels.bits(),
            decimation,
            samples: 0,
        };
        self.lost = 0;
        match self.ask(Action::Stream(order))? {
            Reply::Done => Ok(()),
            _ => bail!("the board: found a strange reply to an order for samples"),
        }
    }

    /// Lets the board run.
    ///
    /// # Errors
    /// It cannot be reached.
    pub fn pass(&mut self, time: Duration) -> Result<()> {
        self.wire.pass(time)
    }

    /// Hands every sample that has come to `watch`.
    ///
    /// # Errors
    /// The board cannot be reached, or `watch` fails.
    pub fn listen(&mut self, mut watch: impl FnMut(&Sample) -> Result<()>) -> Result<()> {
        let mut bytes = std::mem::take(&mut self.kept);
        let mut room = [0; 4096];
        loop {
            let taken = self.wire.receive(TELEMETRY_CHANNEL, &mut room)?;
            bytes.extend_from_slice(&room[..taken]);
            if bytes.is_empty() {
                return Ok(());
            }
            for byte in &bytes {
                if let Some(Ok(block)) = self.samples.feed::<Block>(*byte) {
                    self.lost = block.lost;
                    block.samples().try_for_each(|sample| watch(&sample))?;
                }
            }
            bytes.clear();
        }
    }

    /// Throws away what has come, before a new stream.
    ///
    /// # Errors
    /// The board cannot be reached.
    pub fn drop_samples(&mut self) -> Result<()> {
        self.listen(|_| Ok(()))?;
        self.lost = 0;
        Ok(())
    }

    /// Samples of the running stream that the board could not send, as far as it has told.
    pub fn lost(&self) -> u32 {
        self.lost
    }
}

/// Hellos until the board answers one.
fn greet(wire: &mut dyn Wire, client: &mut Client) -> Result<Hello> {
    for _ in 0..HELLOS {
        let mut buffer = [0; FRAME_BYTES];
        let (number, bytes) = client.hello(&mut buffer)?;
        let reply = exchange(wire, client, number, bytes, PATIENCE, |_| Ok(()))?;
        if let Some(Reply::Hello(hello)) = reply {
            check_versions(hello.protocol, PROTOCOL)?;
            return Ok(hello);
        }
    }
    bail!("the board: found no answer to {HELLOS} hellos, wanted one: is the firmware running?")
}

/// Takes what has come of a stream; what there is no room for waits in the board's ring.
fn keep_stream(wire: &mut dyn Wire, kept: &mut Vec<u8>) -> Result<()> {
    let mut room = [0; 4096];
    while kept.len() < KEPT_BYTES {
        let taken = wire.receive(TELEMETRY_CHANNEL, &mut room)?;
        if taken == 0 {
            break;
        }
        kept.extend_from_slice(&room[..taken]);
    }
    Ok(())
}

/// Sends a request and waits for the reply of its number, with `look` after each look for it; none if it does not come.
fn exchange(
    wire: &mut dyn Wire,
    client: &mut Client,
    number: u16,
    bytes: &[u8],
    patience: Duration,
    mut look: impl FnMut(&mut dyn Wire) -> Result<()>,
) -> Result<Option<Reply>> {
    let mut sent = 0;
    let mut received = [0; 512];
    for _ in 0..patience.as_micros() / LOOK.as_micros() {
        if sent < bytes.len() {
            sent += wire.send(&bytes[sent..])?;
        }
        wire.pass(LOOK)?;
        look(wire)?;
        loop {
            let taken = wire.receive(REPLY_CHANNEL, &mut received)?;
            let replies = received[..taken]
                .iter()
                .filter_map(|byte| client.feed(*byte));
            let mut matching = replies.filter(|response| response.number == number);
            if let Some(response) = matching.next() {
                return Ok(Some(response.reply));
            }
            if taken == 0 {
                break;
            }
        }
    }
    Ok(None)
}
