"""Reads recordings of `pickline run --record` with the mcap package: every message by its
schema, the metadata, the index of one that was finished, and one that was killed. What
Foxglove's library found in them (read.mjs) must be as much."""

import collections
import json
import pathlib
import sys

import jsonschema
from mcap.exceptions import EndOfFile
from mcap.reader import make_reader
from mcap.stream_reader import StreamReader
from mcap.records import Channel, Message, Schema

PROTOCOL = "1"
folder, found_by_foxglove = pathlib.Path(sys.argv[1]), json.loads(sys.argv[2])
failures = []


def check(holds, text):
    if not holds:
        failures.append(text)


def check_message(name, schema, channel, message, validators):
    check(schema.encoding == "jsonschema", f"{name}: {channel.topic} has no JSON Schema")
    check(channel.message_encoding == "json", f"{name}: {channel.topic} is not JSON")
    check(channel.metadata["version"] == PROTOCOL, f"{name}: {channel.topic}: version")
    if schema.id not in validators:
        text = json.loads(schema.data)
        check(text["type"] == "object", f"{name}: {schema.name} is no object")
        jsonschema.Draft202012Validator.check_schema(text)
        # Fields that a schema does not know would be invisible in a viewer.
        text["additionalProperties"] = False
        validators[schema.id] = jsonschema.Draft202012Validator(text)
    value = json.loads(message.data)
    for error in validators[schema.id].iter_errors(value):
        check(False, f"{name}: {channel.topic}: {error.message}")
    check(channel.topic.rsplit("/")[-1] == value["kind"], f"{name}: {channel.topic}: kind")


def whole(name):
    counts, validators, last = collections.Counter(), {}, 0
    with open(folder / name, "rb") as file:
        reader = make_reader(file, validate_crcs=True)
        summary = reader.get_summary()
        for schema, channel, message in reader.iter_messages(log_time_order=False):
            check_message(name, schema, channel, message, validators)
            check(message.sequence == counts[channel.topic], f"{name}: a message is missing")
            check(message.log_time >= last, f"{name}: log times go back")
            counts[channel.topic] += 1
            last = message.log_time
        metadata = {m.name: m.metadata for m in reader.iter_metadata()}
    total = summary.statistics.message_count
    check(total == sum(counts.values()), f"{name}: {total} messages by its index")
    fields = metadata["pickline"]
    for field in ["program", "command", "station", "station_hash", "strategy", "clock"]:
        check(fields.get(field), f"{name}: metadata lack {field}")
    check("--record" in fields["command"], f"{name}: {fields['command']}")
    check("[[robot]]" in fields["station"], f"{name}: no station")
    compare(name, counts)
    return counts, metadata


def compare(name, counts):
    there = found_by_foxglove[name]
    check(there == counts, f"{name}: {counts}, but Foxglove's library finds {there}")


counts, _ = whole("messages.mcap")
seen = counts.copy()
check(counts["/in/detection"] >= 50, f"detections: {counts}")
check(counts["/in/tick"] == counts["/out/due"] > 0, f"ticks: {counts}")
check(counts["/in/result"] > 20 < counts["/out/task"], f"results: {counts}")
check(counts["/node/refused"] == 1 <= counts["/out/status"], f"status: {counts}")
counts, metadata = whole("system.mcap")
seen += counts
check(counts["/node/step"] > 0 < counts["/out/status"], f"steps: {counts}")
check(json.loads(metadata["state"]["state"])["claims"], "no claims in the state")

# What was killed has no index; it is read from its beginning, as far as it goes.
schemas, channels, validators, counts = {}, {}, {}, collections.Counter()
with open(folder / "killed.mcap", "rb") as file:
    try:
        for record in StreamReader(file, validate_crcs=True).records:
            if isinstance(record, Schema):
                schemas[record.id] = record
            elif isinstance(record, Channel):
                channels[record.id] = record
            elif isinstance(record, Message):
                channel = channels[record.channel_id]
                schema = schemas[channel.schema_id]
                check_message("killed.mcap", schema, channel, record, validators)
                counts[channel.topic] += 1
    except EndOfFile:
        pass
check(counts["/out/task"] > 0, "killed.mcap: no task")
compare("killed.mcap", counts)

for failure in failures[:20]:
    print(f"tests/mcap/read.py: {failure}", file=sys.stderr)
if not failures:
    print(f"recordings: {sum(seen.values())} messages of {len(seen)} kinds are by their schemas")
sys.exit(bool(failures))
