//! A bag of another program's, or what a monitor saw, as a log, of which `convert` makes a recording.

use crate::definition::Definition;
use crate::open::{open, walk};
use crate::topic::{Form, Topic};
use convert::{Beside, Log, together, told_how};
use recording::Error;
use std::collections::HashMap;
use std::path::Path;

/// How a sensor's output comes into a bag.
const HOW_TO_RECORD: &str = "ros2 bag record --storage mcap TOPIC, where TOPIC has numbers, as sensor_msgs/JointState has position and std_msgs/Float64MultiArray has data";

/// The topics of a file, each a kind of messages: those of ROS 2 (`ros2msg` and CDR) and of JSON. A topic's times are the stamps of its
/// headers, or when a message was logged.
///
/// # Errors
/// It is no MCAP file, or holds no messages that are known.
pub fn log(path: &Path, beside: &Beside) -> Result<Log, Error> {
    let mut topics: Vec<Topic> = Vec::new();
    let mut places: HashMap<u16, usize> = HashMap::new();
    let mut first_ns = None;
    let whole = walk(
        path,
        open(path)?,
        |_, _| Ok(()),
        |message| {
            let first_ns = *first_ns.get_or_insert(message.time_ns);
            let place = *places.entry(message.channel.id).or_insert_with(|| {
                let channel = &message.channel;
                topics.push(Topic::new(channel.topic.clone(), form_of(channel)));
                topics.len() - 1
            });
            topics[place].push(message.time_ns, first_ns, message.data);
            Ok(())
        },
    )?;
    let mut notes: Vec<String> = topics.iter().filter_map(Topic::left_aside).collect();
    if topics.iter().all(|topic| topic.left_aside().is_some()) {
        let found = if notes.is_empty() {
            "no messages".to_owned()
        } else {
            notes.join("; ")
        };
        return Err(Error::new(
            path,
            found,
            format!(
                "messages of ROS 2 (ros2msg, CDR) or JSON with numbers{}",
                told_how(HOW_TO_RECORD)
            ),
        ));
    }
    let stamped = topics
        .iter()
        .filter(|topic| topic.rows() > 0)
        .all(Topic::stamps_are_near_or_none);
    notes.extend(topics.iter().flat_map(|topic| topic.told(stamped)));
    let streams = topics
        .into_iter()
        .map(|topic| topic.stream(stamped))
        .collect();
    let mut log = together(path, "an MCAP file", streams, beside)?;
    log.how_to_record = Some(HOW_TO_RECORD);
    log.notes.extend(notes);
    if !whole {
        log.notes.push("the end of the file is missing: it was cut, or is still written; what is there was read".into());
    }
    Ok(log)
}

/// How the messages of a channel are packed.
fn form_of(channel: &mcap::Channel) -> Form {
    let schema = channel.schema.as_deref();
    match (channel.message_encoding.as_str(), schema) {
        ("json", _) => Form::Json,
        ("cdr", Some(schema)) if schema.encoding == "ros2msg" => {
            match Definition::parse(&schema.name, &String::from_utf8_lossy(&schema.data)) {
                Ok(definition) => Form::Ros(definition),
                Err(found) => Form::Unknown(found),
            }
        }
        (encoding, schema) => Form::Unknown(format!(
            "messages of {encoding} with definitions of {}",
            schema.map_or("none", |schema| &schema.encoding)
        )),
    }
}
