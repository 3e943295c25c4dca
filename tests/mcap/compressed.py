"""Makes the compressed recordings of tests/data/recordings again, for when what the node says
has changed: records a short run, and rewrites it in small chunks, as other programs do.

    pip install mcap lz4 zstandard
    python3 tests/mcap/compressed.py target/debug/pickline
"""

import json
import pathlib
import subprocess
import sys
import tempfile

from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer

FOLDER = pathlib.Path(__file__).resolve().parent.parent / "data" / "recordings"
CHUNK = 600  # [bytes]


def messages():
    """One robot, two items, a minute in which nobody acknowledges a task."""
    yield {"kind": "robot", "stamp": 0.0, "name": "r1", "state": "idle"}
    yield {"kind": "detection", "stamp": 0.0, "id": "a", "x": 1.0, "y": -0.2}
    yield {"kind": "detection", "stamp": 0.5, "id": "b", "x": 0.2, "y": -0.2}
    yield {"kind": "tick", "stamp": 60.0}


def rewrite(plain, target, compression):
    """Writes the recording `plain` to `target`, its chunks compressed."""
    with open(plain, "rb") as source, open(target, "wb") as sink:
        writer = Writer(sink, chunk_size=CHUNK, compression=compression)
        writer.start(profile=make_reader(source).get_header().profile, library="compressed.py")
        source.seek(0)
        for record in make_reader(source).iter_metadata():
            writer.add_metadata(record.name, record.metadata)
        source.seek(0)
        schemas, channels = {}, {}
        for schema, channel, message in make_reader(source).iter_messages(log_time_order=False):
            if schema.id not in schemas:
                schemas[schema.id] = writer.register_schema(
                    schema.name, schema.encoding, schema.data
                )
            if channel.id not in channels:
                channels[channel.id] = writer.register_channel(
                    channel.topic,
                    channel.message_encoding,
                    schemas[schema.id],
                    channel.metadata,
                )
            writer.add_message(
                channels[channel.id],
                message.log_time,
                message.data,
                message.publish_time,
                message.sequence,
            )
        writer.finish()


def main():
    program = pathlib.Path(sys.argv[1]).resolve()
    with tempfile.TemporaryDirectory() as folder:
        call = [program, "run", "--clock", "messages", "--record", "plain.mcap", "--quiet"]
        lines = "".join(json.dumps(message) + "\n" for message in messages())
        subprocess.run(call, input=lines.encode(), stdout=subprocess.DEVNULL, cwd=folder, check=True)
        plain = pathlib.Path(folder) / "plain.mcap"
        rewrite(plain, FOLDER / "lz4.mcap", CompressionType.LZ4)
        rewrite(plain, FOLDER / "zstd.mcap", CompressionType.ZSTD)


if __name__ == "__main__":
    main()
