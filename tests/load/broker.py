"""A mosquitto on a free port of the loopback interface."""

import contextlib
import shutil
import socket
import subprocess
import time
from pathlib import Path

# What docs/mqtt.md asks of a broker: small packets leave at once, and no message that was
# acknowledged is dropped because too many wait.
SETTINGS = """listener {port} 127.0.0.1
allow_anonymous true
persistence false
set_tcp_nodelay true
max_queued_messages 0
"""
# Where Debian has it, which is in few users' paths.
PLACES = "/usr/sbin:/usr/local/sbin:/usr/bin:/usr/local/bin"
# Time [s] for it to start.
PATIENCE = 30


def free_port():
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        return listener.getsockname()[1]


class Broker:
    """A running broker."""

    def __init__(self, port):
        self.port = port
        self.url = f"mqtt://127.0.0.1:{port}"

    def subscriber(self, topic):
        """A program that prints the payloads under a topic, a line each, and is there."""
        address = ["-h", "127.0.0.1", "-p", str(self.port), "-V", "5", "-q", "1"]
        # What the broker says of itself is retained: it comes once the subscriptions stand.
        topics = ["-t", topic, "-t", "$SYS/broker/version"]
        command = ["mosquitto_sub", *address, *topics, "-F", "%p"]
        subscriber = subprocess.Popen(command, stdout=subprocess.PIPE, bufsize=0)
        subscriber.stdout.readline()
        return subscriber


@contextlib.contextmanager
def broker(folder):
    """A broker, for as long as the block runs."""
    program = shutil.which("mosquitto", path=PLACES)
    if not program or not shutil.which("mosquitto_sub"):
        raise SystemExit("no mosquitto\n  cure: bash tests/mqtt/run.sh installs it")
    port = free_port()
    settings = Path(folder) / "mosquitto.conf"
    settings.write_text(SETTINGS.format(port=port))
    # It remarks every connection.
    process = subprocess.Popen([program, "-c", str(settings)], stderr=subprocess.DEVNULL)
    try:
        wait_for(port, process)
        yield Broker(port)
    finally:
        process.terminate()
        process.wait()


def wait_for(port, process):
    until = time.monotonic() + PATIENCE
    while process.poll() is None and time.monotonic() < until:
        try:
            socket.create_connection(("127.0.0.1", port)).close()
            return
        except ConnectionRefusedError:
            time.sleep(0.05)
    raise SystemExit(f"mosquitto does not start with\n{SETTINGS.format(port=port)}")
