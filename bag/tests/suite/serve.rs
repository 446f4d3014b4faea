//! A program that connects to a monitor gets what it asks for, by the wire.

use crate::live::{ZERO_NS, state};
use bag::{Definition, Server, flatten};
use serde_json::{Value, json};
use std::net::{SocketAddr, TcpStream};
use std::thread;
use std::time::Duration;
use tungstenite::client::IntoClientRequest;
use tungstenite::{Error, Message, WebSocket};

/// A connection by one of the protocol's names.
fn connect(address: SocketAddr, name: &str) -> Result<WebSocket<TcpStream>, Error> {
    let mut request = format!("ws://{address}").into_client_request()?;
    let name = name.parse().unwrap();
    request.headers_mut().insert("Sec-WebSocket-Protocol", name);
    let stream = TcpStream::connect(address)?;
    match tungstenite::client(request, stream) {
        Ok((socket, _)) => Ok(socket),
        Err(tungstenite::HandshakeError::Failure(error)) => Err(error),
        Err(error) => panic!("{error}"),
    }
}

fn text(socket: &mut WebSocket<TcpStream>) -> Value {
    serde_json::from_str(socket.read().unwrap().to_text().unwrap()).unwrap()
}

fn order(socket: &mut WebSocket<TcpStream>, order: &Value) {
    socket.send(Message::text(order.to_string())).unwrap();
}

/// What `client` finds while states are pushed.
fn while_pushing<T: Send>(client: impl FnOnce(SocketAddr) -> T + Send) -> T {
    let mut server = Server::bind("127.0.0.1:0".parse().unwrap()).unwrap();
    let address = server.address().unwrap();
    thread::scope(|scope| {
        let found = scope.spawn(|| client(address));
        let mut row = 0;
        while !found.is_finished() {
            server.push(&state(row % 1_000), ZERO_NS);
            row += 1;
            thread::sleep(Duration::from_millis(1));
        }
        found.join().unwrap()
    })
}

/// The next values of a subscription: when, and what.
fn values(socket: &mut WebSocket<TcpStream>) -> (u32, u64, Vec<u8>) {
    let Message::Binary(bytes) = socket.read().unwrap() else {
        panic!("no values");
    };
    assert_eq!(bytes[0], 1);
    let id = u32::from_le_bytes(bytes[1..5].try_into().unwrap());
    let time_ns = u64::from_le_bytes(bytes[5..13].try_into().unwrap());
    (id, time_ns, bytes[13..].to_vec())
}

#[test]
fn what_is_subscribed_comes_as_it_is_advertised() {
    while_pushing(|address| {
        let mut socket = connect(address, "foxglove.websocket.v1").unwrap();
        assert_eq!(text(&mut socket)["op"], "serverInfo");
        let advertised = text(&mut socket);
        let channels = advertised["channels"].as_array().unwrap();
        let topics: Vec<&str> = channels
            .iter()
            .map(|c| c["topic"].as_str().unwrap())
            .collect();
        assert_eq!(topics, ["/state", "/pose"]);
        for (channel, name) in channels.iter().zip(["x_m", "pose.position.x"]) {
            let subscription = json!({ "id": 40, "channelId": channel["id"] });
            order(
                &mut socket,
                &json!({ "op": "subscribe", "subscriptions": [subscription] }),
            );
            let said = |key: &str| channel[key].as_str().unwrap();
            assert_eq!(
                [said("schemaEncoding"), said("encoding")],
                ["ros2msg", "cdr"]
            );
            let definition = Definition::parse(said("schemaName"), said("schema")).unwrap();
            for _ in 0..5 {
                let (id, time_ns, bytes) = values(&mut socket);
                assert_eq!(id, 40);
                let numbers = flatten(&definition, &bytes).unwrap().numbers;
                let (_, x_m) = numbers.iter().find(|(found, _)| found == name).unwrap();
                let row = ((time_ns - ZERO_NS) as f64 * 50e-9).round();
                assert_eq!(*x_m, state(row as u32).x_m);
            }
            order(
                &mut socket,
                &json!({ "op": "unsubscribe", "subscriptionIds": [40] }),
            );
            // What was on its way already, and then nothing.
            socket
                .get_ref()
                .set_read_timeout(Some(Duration::from_millis(200)))
                .unwrap();
            let late = (0..100).take_while(|_| socket.read().is_ok()).count();
            assert!(late < 100, "still coming");
            socket.get_ref().set_read_timeout(None).unwrap();
        }
    });
}

/// A program that speaks something else is told what is wanted; a later one is served.
#[test]
fn another_protocol_is_refused_by_name() {
    while_pushing(|address| {
        let Err(Error::Http(refused)) = connect(address, "chat") else {
            panic!("agreed");
        };
        let body = refused.body().clone().unwrap();
        assert_eq!(
            String::from_utf8(body).unwrap(),
            "wanted Sec-WebSocket-Protocol foxglove.sdk.v1 or foxglove.websocket.v1"
        );
        assert!(connect(address, "chat, foxglove.sdk.v1").is_ok());
    });
}

/// Neither one that has asked and reads nothing nor one that says nothing holds up the monitor or the others.
#[test]
fn who_does_not_read_holds_up_nobody() {
    let pushed = while_pushing(|address| {
        let mut deaf = connect(address, "foxglove.sdk.v1").unwrap();
        let both = json!([{ "id": 0, "channelId": 0 }, { "id": 1, "channelId": 1 }]);
        order(
            &mut deaf,
            &json!({ "op": "subscribe", "subscriptions": both }),
        );
        let silent = TcpStream::connect(address).unwrap();
        let mut last = connect(address, "foxglove.sdk.v1").unwrap();
        order(
            &mut last,
            &json!({ "op": "subscribe", "subscriptions": both }),
        );
        let mut seen = 0;
        while seen < 500 {
            seen += usize::from(matches!(last.read().unwrap(), Message::Binary(_)));
        }
        drop((deaf, silent));
        seen
    });
    assert_eq!(pushed, 500);
}

/// The end of a monitor is the end of its connections.
#[test]
fn the_servers_end_closes_connections() {
    let mut server = Server::bind("127.0.0.1:0".parse().unwrap()).unwrap();
    let address = server.address().unwrap();
    let client = thread::spawn(move || {
        let mut socket = connect(address, "foxglove.sdk.v1").unwrap();
        while !matches!(socket.read(), Ok(Message::Close(_))) {}
    });
    // It must have come before the server goes.
    while server.connections() == 0 {
        server.push(&state(0), ZERO_NS);
    }
    drop(server);
    client.join().unwrap();
}
