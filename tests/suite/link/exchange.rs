//! Requests and replies on their way, and who may ask.

use super::messages::{actions, hello, replies};
use super::{greeted, serve, whole};
use courier_sensor::link::client::Client;
use courier_sensor::link::framing;
use courier_sensor::link::message::*;
use courier_sensor::link::server::{Event, Server};

#[test]
fn every_action_and_every_reply_survives_the_way() {
    let (mut server, mut client) = greeted();
    let mut buffer = [0; FRAME_BYTES];
    for action in actions() {
        let (number, bytes) = client.ask(action.clone(), &mut buffer).unwrap();
        match &serve(&mut server, bytes)[..] {
            [
                Event::Act {
                    number: taken,
                    action: head,
                },
            ] => {
                assert_eq!((*taken, whole(&server, head)), (number, Ok(action)));
            }
            other => panic!("{action:?}: {other:?}"),
        }
    }
    for reply in replies() {
        let response = Response { number: 5, reply };
        let bytes = framing::encode(&response, &mut buffer).unwrap();
        let got: Vec<Response> = bytes.iter().filter_map(|&byte| client.feed(byte)).collect();
        assert_eq!(got, [response]);
    }
}

#[test]
fn nothing_is_done_before_a_hello_of_the_same_version() {
    let (mut server, mut client) = (Server::new(hello()), Client::new());
    let mut buffer = [0; FRAME_BYTES];
    let not_greeted = |number| {
        let reply = Reply::Refused(Refusal::NotGreeted { protocol: PROTOCOL });
        [Event::Answer(Response { number, reply })]
    };
    let (number, bytes) = client.ask(Action::Restart, &mut buffer).unwrap();
    assert_eq!(serve(&mut server, bytes), not_greeted(number));
    for protocol in [PROTOCOL - 1, PROTOCOL + 1] {
        let request: Request = Request {
            number: 9,
            command: Command::Hello { protocol },
        };
        let bytes = framing::encode(&request, &mut buffer).unwrap();
        assert_eq!(
            serve(&mut server, bytes),
            [Event::Answer(Response {
                number: 9,
                reply: Reply::Hello(hello())
            })]
        );
        let (number, bytes) = client.ask(Action::Status, &mut buffer).unwrap();
        assert_eq!(serve(&mut server, bytes), not_greeted(number));
    }
}

#[test]
fn a_version_mismatch_says_which_side_to_update() {
    assert_eq!(check_versions(3, 3), Ok(()));
    let newer_board = check_versions(4, 3).unwrap_err().to_string();
    assert_eq!(
        newer_board,
        "the board speaks link protocol 4, this command 3: update this command"
    );
    let newer_host = check_versions(3, 4).unwrap_err().to_string();
    assert_eq!(
        newer_host,
        "the board speaks link protocol 3, this command 4: update the board's firmware"
    );
}
