//! What a monitor sees, for programs that connect while it runs: Foxglove's protocol over a WebSocket
//! (`docs/spec.md` of foxglove/ws-protocol), which Foxglove, Lichtblick and PlotJuggler speak.
//!
//! Each connection has a thread of its own. What one does not take up in time is left out for it, so that none holds up the monitor.

use crate::cdr::Packer;
use crate::seen::{CHANNELS, ENCODINGS, State, time_ns};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::io::{self, ErrorKind};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, SyncSender, TryRecvError, TrySendError, sync_channel};
use std::thread;
use std::time::Duration;
use tungstenite::handshake::server::{ErrorResponse, Request, Response};
use tungstenite::http::{HeaderValue, StatusCode};
use tungstenite::{Error, Message, WebSocket};

/// The protocol under its names of today and of before: what this server sends is the same in both.
const PROTOCOLS: [&str; 2] = ["foxglove.sdk.v1", "foxglove.websocket.v1"];
/// The header that names it.
const HEADER: &str = "Sec-WebSocket-Protocol";
/// First byte of a message of values.
const MESSAGE_DATA: u8 = 1;
/// Messages that wait for a connection. A bound on the work: some 20 KiB, and more than a second of a hundred states each.
const WAITING: usize = 256;
/// Longest time for a handshake, or for a write that the other side does not take up. A prior: a program on the same desk answers within
/// milliseconds.
const PATIENCE: Duration = Duration::from_secs(2);
/// Time between two looks at what a connection says. A bound on the work: fifty looks a second, and a picture waits no longer than that.
const LOOK: Duration = Duration::from_millis(20);

/// One message, packed once for all connections.
struct Packed {
    /// Its place in [`CHANNELS`].
    channel: usize,
    time_ns: u64,
    bytes: Vec<u8>,
}

/// Takes connections, and sends each what it has asked for.
pub struct Server {
    listener: TcpListener,
    connections: Vec<SyncSender<Arc<Packed>>>,
    packer: Packer,
}

impl Server {
    /// Listens; a port of 0 is any that is free.
    ///
    /// # Errors
    /// The address is not this machine's, or its port is taken.
    pub fn bind(address: SocketAddr) -> io::Result<Self> {
        let listener = TcpListener::bind(address)?;
        listener.set_nonblocking(true)?;
        Ok(Self {
            listener,
            connections: Vec::new(),
            packer: Packer::default(),
        })
    }

    /// Where it listens.
    ///
    /// # Errors
    /// The system does not say.
    pub fn address(&self) -> io::Result<SocketAddr> {
        self.listener.local_addr()
    }

    /// How many are connected.
    #[must_use]
    pub fn connections(&self) -> usize {
        self.connections.len()
    }

    /// Takes up who has connected, and sends a state. `zero_ns` is when the board's time was zero, ns since 1970. Waits for nobody.
    pub fn push(&mut self, state: &State, zero_ns: u64) {
        // Whatever the system has against one connection, the next one may be well.
        while let Ok((stream, _)) = self.listener.accept() {
            let (sender, receiver) = sync_channel(WAITING);
            self.connections.push(sender);
            thread::spawn(move || connection(stream, &receiver));
        }
        if self.connections.is_empty() {
            return;
        }
        let time_ns = time_ns(state, zero_ns);
        for (place, channel) in CHANNELS.iter().enumerate() {
            self.packer.clear();
            (channel.pack)(state, time_ns, &mut self.packer);
            let packed = Arc::new(Packed {
                channel: place,
                time_ns,
                bytes: self.packer.bytes().to_vec(),
            });
            let is_there = |sender: &SyncSender<Arc<Packed>>| {
                let sent = sender.try_send(Arc::clone(&packed));
                !matches!(sent, Err(TrySendError::Disconnected(_)))
            };
            self.connections.retain(is_there);
        }
    }
}

/// One connection from its handshake to its end, which is also that of the server.
fn connection(stream: TcpStream, receiver: &Receiver<Arc<Packed>>) {
    // Whoever goes away, however that is done, has gone.
    let _ = handshake(stream).and_then(|socket| follow(socket, receiver));
}

fn handshake(stream: TcpStream) -> Result<WebSocket<TcpStream>, Error> {
    stream.set_nonblocking(false)?;
    stream.set_nodelay(true)?;
    stream.set_read_timeout(Some(PATIENCE))?;
    stream.set_write_timeout(Some(PATIENCE))?;
    let accepted = tungstenite::accept_hdr(stream, agree);
    let mut socket = accepted.map_err(|_| Error::ConnectionClosed)?;
    socket.get_ref().set_read_timeout(Some(LOOK))?;
    for text in [server_info(), advertise()] {
        socket.write(Message::text(text.to_string()))?;
    }
    socket.flush()?;
    Ok(socket)
}

/// Agrees on one of the names, or refuses and says which are wanted.
#[expect(clippy::result_large_err, reason = "tungstenite's own signature")]
fn agree(request: &Request, mut response: Response) -> Result<Response, ErrorResponse> {
    let asked = request.headers().get_all(HEADER).iter();
    let asked = asked.filter_map(|value| value.to_str().ok());
    let mut asked = asked.flat_map(|value| value.split(',')).map(str::trim);
    let Some(name) = asked.find_map(|name| PROTOCOLS.iter().find(|known| **known == name)) else {
        let wanted = format!("wanted {HEADER} {}", PROTOCOLS.join(" or "));
        let mut refused = ErrorResponse::new(Some(wanted));
        *refused.status_mut() = StatusCode::BAD_REQUEST;
        return Err(refused);
    };
    let headers = response.headers_mut();
    headers.insert(HEADER, HeaderValue::from_static(name));
    Ok(response)
}

fn server_info() -> Value {
    let name = concat!("courier ", env!("CARGO_PKG_VERSION"));
    json!({ "op": "serverInfo", "name": name, "capabilities": [] })
}

fn advertise() -> Value {
    let [of_schema, of_values] = ENCODINGS;
    let channels = CHANNELS.iter().enumerate().map(|(id, channel)| {
        json!({
            "id": id,
            "topic": channel.topic,
            "encoding": of_values,
            "schemaName": channel.name,
            "schema": channel.definition,
            "schemaEncoding": of_schema,
        })
    });
    json!({ "op": "advertise", "channels": channels.collect::<Vec<_>>() })
}

/// Sends what is asked for until either side ends.
fn follow(mut socket: WebSocket<TcpStream>, receiver: &Receiver<Arc<Packed>>) -> Result<(), Error> {
    let mut subscriptions = BTreeMap::new();
    loop {
        match socket.read() {
            Ok(Message::Text(text)) => subscribe(&mut subscriptions, &text),
            Ok(_) => {}
            Err(Error::Io(error)) if is_silence(&error) => {}
            Err(error) => return Err(error),
        }
        loop {
            match receiver.try_recv() {
                Ok(packed) => {
                    if let Some(id) = subscriptions.get(&packed.channel) {
                        socket.write(Message::binary(values(*id, &packed)))?;
                    }
                }
                Err(TryRecvError::Empty) => break,
                Err(TryRecvError::Disconnected) => {
                    socket.close(None)?;
                    return socket.flush();
                }
            }
        }
        socket.flush()?;
    }
}

fn is_silence(error: &io::Error) -> bool {
    matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut)
}

/// Takes over what a message says of subscriptions: their numbers by the channels' places. What it is about otherwise is nothing to this server.
fn subscribe(subscriptions: &mut BTreeMap<usize, u32>, text: &str) {
    let Ok(message) = serde_json::from_str::<Value>(text) else {
        return;
    };
    let number = |value: &Value| u32::try_from(value.as_u64()?).ok();
    let list = |key: &str| message[key].as_array().into_iter().flatten();
    match message["op"].as_str() {
        Some("subscribe") => {
            let asked = list("subscriptions").filter_map(|asked| {
                let channel = number(&asked["channelId"])? as usize;
                Some((channel, number(&asked["id"])?))
            });
            subscriptions.extend(asked.filter(|(channel, _)| *channel < CHANNELS.len()));
        }
        Some("unsubscribe") => {
            let ended: Vec<u32> = list("subscriptionIds").filter_map(number).collect();
            subscriptions.retain(|_, id| !ended.contains(id));
        }
        _ => {}
    }
}

/// A message of values as it is sent: what it is, whose subscription, when, and the values.
fn values(subscription: u32, packed: &Packed) -> Vec<u8> {
    let mut out = Vec::with_capacity(13 + packed.bytes.len());
    out.push(MESSAGE_DATA);
    out.extend(subscription.to_le_bytes());
    out.extend(packed.time_ns.to_le_bytes());
    out.extend(&packed.bytes);
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn subscriptions_come_and_go_and_nothing_else_matters() {
        let mut all = BTreeMap::new();
        let mut say = |text: &str| {
            subscribe(&mut all, text);
            all.iter()
                .map(|(channel, id)| (*channel, *id))
                .collect::<Vec<_>>()
        };
        let both =
            r#"{"op":"subscribe","subscriptions":[{"id":7,"channelId":1},{"id":3,"channelId":0}]}"#;
        assert_eq!(say(both), [(0, 3), (1, 7)]);
        for other in [
            "",
            "[1]",
            r#"{"op":"subscribe"}"#,
            r#"{"op":"subscribe","subscriptions":[{"id":1,"channelId":2},{"id":-1,"channelId":0},{"channelId":0}]}"#,
            r#"{"op":"unsubscribe","subscriptionIds":[4,"7",null]}"#,
            r#"{"op":"clientInfo","name":"x"}"#,
        ] {
            assert_eq!(say(other), [(0, 3), (1, 7)], "{other}");
        }
        assert_eq!(
            say(r#"{"op":"unsubscribe","subscriptionIds":[3]}"#),
            [(1, 7)]
        );
    }
}
