//! What other programs' readers make of the files that [`super::nightly`] has written: Python's, the one that PlotJuggler is made with, and
//! those that Foxglove and Lichtblick are made with. They are installed into folders of their own; what cannot be had is skipped, and that is said.

use crate::arm;
use crate::parquet::courier;
use crate::python::environment;
use anyhow::{Context, Result, ensure};
use std::path::Path;
use std::process::Command;

/// What Python's readers make of the files of the lines before, and a bag that it writes.
const BY_PYTHON: &str = r#"
import csv, tomllib
from mcap.reader import make_reader, NonSeekingReader
from mcap_ros2.decoder import DecoderFactory
from mcap_ros2.writer import Writer
rows = list(csv.DictReader(open('survey/samples.csv')))
with open('s.mcap', 'rb') as file:
    reader = make_reader(file, decoder_factories=[DecoderFactory()])
    attachment, = reader.iter_attachments()
    assert attachment.data.decode() == open('survey/recording.toml').read(), 'recording.toml'
    messages = [message for *_, message in reader.iter_decoded_messages(topics=['/samples'])]
assert len(messages) == len(rows), (len(messages), len(rows))
for row, message in zip(rows, messages):
    for name, text in row.items():
        if name == 'run':
            assert message.run == text, (message.run, text)
        elif text == '':
            value = getattr(message, name, float('nan'))
            assert value != value, (name, value)
        else:
            assert getattr(message, name) == float(text), (name, text)
with open('s.mcap', 'rb') as file:
    summary = make_reader(file).get_summary()
    assert summary.statistics.message_count == len(rows) and summary.chunk_indexes[0].message_index_offsets
with open('board.mcap', 'rb') as file:
    metadata, = make_reader(file).iter_metadata()
    assert metadata.metadata['platen_id'] == 'west', metadata
with open('watched.mcap', 'rb') as file:
    seen = [(channel.topic, message) for _, channel, _, message in make_reader(file, decoder_factories=[DecoderFactory()]).iter_decoded_messages()]
states = [message for topic, message in seen if topic == '/state']
poses = [message for topic, message in seen if topic == '/pose']
assert len(states) == len(poses) > 100, (len(states), len(poses))
for state, pose in zip(states, poses):
    assert pose.header.frame_id == 'platen' and pose.pose.position.x == state.x_m, (pose, state)
with open('python.mcap', 'wb') as file:
    writer = Writer(file)
    schema = writer.register_msgdef('own_msgs/msg/Place', 'float64 x_m')
    for row in range(200):
        writer.write_message('/place', schema, {'x_m': row * 1e-5}, log_time=10**18 + row * 10**7)
    writer.finish()
"#;

/// The same of the library rosx_introspection, by which PlotJuggler turns messages into curves: a name and a number for each.
const BY_PLOTJUGGLER: &str = r#"
import csv, msgpack
from mcap.reader import make_reader
from rosx_introspection import Parser
def curves(path, topic):
    parser, found = None, []
    with open(path, 'rb') as file:
        for schema, channel, message in make_reader(file).iter_messages(topics=[topic]):
            assert (schema.encoding, channel.message_encoding) == ('ros2msg', 'cdr'), (schema.encoding, channel.message_encoding)
            parser = parser or Parser(topic, schema.name, schema.data.decode())
            found.append(msgpack.unpackb(parser.parse_to_msgpack(message.data)))
    return found
rows = list(csv.DictReader(open('survey/samples.csv')))
samples = curves('s.mcap', '/samples')
assert len(samples) == len(rows), (len(samples), len(rows))
for row, sample in zip(rows, samples):
    for name, text in row.items():
        value = sample.get('/samples/' + name, float('nan'))
        wanted = text if name == 'run' else float(text or 'nan')
        assert value == wanted or value != value and wanted != wanted, (name, text, value)
states, poses = curves('watched.mcap', '/state'), curves('watched.mcap', '/pose')
assert len(states) == len(poses) > 100, (len(states), len(poses))
for state, pose in zip(states, poses):
    assert pose['/pose/header/frame_id'] == 'platen' and pose['/pose/pose/position/x'] == state['/state/x_m'], (pose, state)
"#;

/// The same of Foxglove's own libraries, whose names Lichtblick's have as well.
const BY_FOXGLOVE: &str = r#"
const assert = require('node:assert');
const { readFileSync } = require('node:fs');
const { McapIndexedReader } = require('@mcap/core');
const { loadDecompressHandlers } = require('@mcap/support');
const { parse } = require('@foxglove/rosmsg');
const { MessageReader } = require('@foxglove/rosmsg2-serialization');
async function messages(path, topic) {
    const bytes = readFileSync(path);
    const readable = {
        size: async () => BigInt(bytes.length),
        read: async (start, length) => new Uint8Array(bytes.subarray(Number(start), Number(start + length))),
    };
    const reader = await McapIndexedReader.Initialize({ readable, decompressHandlers: await loadDecompressHandlers() });
    const channel = [...reader.channelsById.values()].find((channel) => channel.topic === topic);
    const schema = reader.schemasById.get(channel.schemaId);
    assert.deepStrictEqual([schema.encoding, channel.messageEncoding], ['ros2msg', 'cdr']);
    const decoder = new MessageReader(parse(new TextDecoder().decode(schema.data), { ros2: true }));
    const found = [];
    for await (const message of reader.readMessages({ topics: [topic] })) {
        found.push({ ...decoder.readMessage(message.data), time: message.logTime });
    }
    return found;
}
(async () => {
    const [names, ...rows] = readFileSync('survey/samples.csv', 'utf8').trimEnd().split('\n').map((line) => line.split(','));
    const samples = await messages('s.mcap', '/samples');
    assert.strictEqual(samples.length, rows.length);
    rows.forEach((row, at) => row.forEach((text, column) => {
        const wanted = names[column] === 'run' ? text : text === '' ? NaN : Number(text);
        assert(Object.is(samples[at][names[column]] ?? NaN, wanted), `${names[column]} of ${at}: ${text}`);
    }));
    const [states, poses] = [await messages('watched.mcap', '/state'), await messages('watched.mcap', '/pose')];
    assert(states.length > 100 && states.length === poses.length);
    states.forEach((state, at) => {
        assert.strictEqual(poses[at].header.frame_id, 'platen');
        assert.strictEqual(poses[at].pose.position.x, state.x_m);
    });
})().catch((error) => { console.error(error); process.exit(1); });
"#;

/// What Foxglove's client makes of a monitor that it connects to: its own record of what came, and the lines that the monitor printed.
const BY_CLIENT: &str = r#"
const assert = require('node:assert');
const { spawn } = require('node:child_process');
const { FoxgloveClient } = require('@foxglove/ws-protocol');
const { WebSocket } = require('ws');
const { parse } = require('@foxglove/rosmsg');
const { MessageReader } = require('@foxglove/rosmsg2-serialization');
const [command] = process.argv.slice(1);
const monitor = spawn(command, ['--sim-preset', 'ideal', 'monitor', '--rate-hz', '50', '--seconds', '6', '--json', '--serve', '127.0.0.1:0']);
let printed = '', told = '', connected = false;
const seen = { '/state': [], '/pose': [] };
monitor.stdout.on('data', (data) => { printed += data; });
monitor.stderr.on('data', (data) => {
    told += data;
    const address = told.match(/(ws:\S+)\n/);
    if (address && !connected) connect(address[1]);
});
function connect(address) {
    connected = true;
    const client = new FoxgloveClient({ ws: new WebSocket(address, ['foxglove.sdk.v1', FoxgloveClient.SUPPORTED_SUBPROTOCOL]) });
    const readers = new Map();
    client.on('error', (error) => { throw error; });
    client.on('advertise', (channels) => channels.forEach((channel) => {
        assert.deepStrictEqual([channel.schemaEncoding, channel.encoding], ['ros2msg', 'cdr']);
        const reader = new MessageReader(parse(channel.schema, { ros2: true }));
        readers.set(client.subscribe(channel.id), { topic: channel.topic, reader });
    }));
    client.on('message', ({ subscriptionId, timestamp, data }) => {
        const { topic, reader } = readers.get(subscriptionId);
        seen[topic].push({ ...reader.readMessage(data), timestamp });
    });
}
monitor.on('close', (code) => {
    assert.strictEqual(code, 0, told);
    const lines = printed.trimEnd().split('\n').map((line) => JSON.parse(line));
    const at = new Map(lines.map((line) => [line.t_s, line]));
    for (const topic of Object.keys(seen)) assert(seen[topic].length > 100, `${seen[topic].length} of ${topic}`);
    for (const state of seen['/state']) assert.strictEqual(state.x_m, at.get(state.t_s).x_m);
    // It was asked for after the states.
    const states = new Map(seen['/state'].map((state) => [state.timestamp, state]));
    for (const pose of seen['/pose']) assert.strictEqual(pose.pose.position.x, states.get(pose.timestamp).x_m);
    const [first] = seen['/pose'];
    assert.strictEqual(first.header.frame_id, 'platen');
    assert.strictEqual(BigInt(first.header.stamp.sec) * 1000000000n + BigInt(first.header.stamp.nanosec ?? first.header.stamp.nsec), first.timestamp);
    process.exit(0);
});
"#;

/// Python's reader and writer, and PlotJuggler's decoder, which `mcap-bag-parser` holds.
const OF_PYTHON: [&str; 4] = ["mcap", "mcap-ros2-support", "mcap-bag-parser", "msgpack"];
/// Foxglove's libraries, for node.
const OF_FOXGLOVE: [&str; 6] = [
    "@mcap/core",
    "@mcap/support",
    "@foxglove/rosmsg",
    "@foxglove/rosmsg2-serialization",
    "@foxglove/ws-protocol",
    "ws",
];

/// By Python's readers and by PlotJuggler's decoder of messages, and a bag that Python writes.
pub fn with_python(command: &Path, folder: &Path) -> Result<()> {
    let Some(python) = environment(folder, "Python's readers of MCAP", &OF_PYTHON)? else {
        return Ok(());
    };
    for (script, whose) in [(BY_PYTHON, "Python"), (BY_PLOTJUGGLER, "PlotJuggler")] {
        arm::run(
            Command::new(&python)
                .args(["-c", script])
                .current_dir(folder),
        )
        .context(whose)?;
    }
    courier(
        command,
        folder,
        "convert python.mcap of-python --column p1_m=x_m --pitch 1mm",
    )
}

/// By the libraries of Foxglove, files and a monitor that runs.
pub fn with_foxglove(command: &Path, folder: &Path) -> Result<()> {
    let installed = || {
        std::fs::write(folder.join("package.json"), "{}")?;
        let words = "install --silent --no-audit --no-fund --ignore-scripts";
        arm::run(
            Command::new("npm")
                .args(words.split(' '))
                .args(OF_FOXGLOVE)
                .current_dir(folder),
        )
    };
    if let Err(error) = installed() {
        ensure!(std::env::var_os("CI").is_none(), "{error:#}");
        arm::say(&format!("SKIPPED: Foxglove's readers: {error:#}"));
        return Ok(());
    }
    arm::run(
        Command::new("node")
            .args(["-e", BY_FOXGLOVE])
            .current_dir(folder),
    )
    .context("Foxglove")?;
    arm::run(
        Command::new("node")
            .args(["-e", BY_CLIENT, "--"])
            .arg(command)
            .current_dir(folder),
    )
    .context("Foxglove's client")
}
