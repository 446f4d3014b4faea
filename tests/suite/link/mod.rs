//! The debug link from the host's bytes to the board's actions and back.

mod bytes;
mod exchange;
mod messages;
mod refused;

use courier_sensor::calibration::record::Calibration;
use courier_sensor::geometry::Geometry;
use courier_sensor::link::client::Client;
use courier_sensor::link::message::{Action, FRAME_BYTES, Refusal, Reply, Response};
use courier_sensor::link::server::{Event, Server};
use messages::hello;

fn serve(server: &mut Server, bytes: &[u8]) -> Vec<Event> {
    bytes.iter().filter_map(|&byte| server.feed(byte)).collect()
}

/// The action as it was sent, with the calibration that the server leaves in its buffer until the next byte.
fn whole(server: &Server, action: &Action<()>) -> Result<Action, Refusal> {
    if matches!(action, Action::Load { .. }) {
        let mut calibration = Calibration::identity(Geometry::PAPER);
        return server
            .loaded(&mut calibration)
            .map(|()| Action::take_over(calibration));
    }
    let mut bytes = [0; FRAME_BYTES];
    let bytes = postcard::to_slice(action, &mut bytes).unwrap();
    Ok(postcard::from_bytes(bytes).unwrap())
}

fn greeted() -> (Server, Client) {
    let (mut server, mut client) = (Server::new(hello()), Client::new());
    let mut buffer = [0; FRAME_BYTES];
    let (number, bytes) = client.hello(&mut buffer).unwrap();
    let events = serve(&mut server, bytes);
    assert_eq!(
        events,
        [Event::Answer(Response {
            number,
            reply: Reply::Hello(hello())
        })]
    );
    (server, client)
}

/// Bytes that are the message themselves.
struct Raw<'a>(&'a [u8]);

impl serde::Serialize for Raw<'_> {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        use serde::ser::SerializeTuple;
        let mut tuple = serializer.serialize_tuple(self.0.len())?;
        self.0
            .iter()
            .try_for_each(|byte| tuple.serialize_element(byte))?;
        tuple.end()
    }
}
