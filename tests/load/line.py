"""`pickline run` and the `pickline emulate` that plays its station, through pipes or over a
broker."""

import json
import signal
import subprocess
import threading
import time

# Time [s] for what is on its way to arrive.
PATIENCE = 30


class Line:
    """The two programs, with the statuses and the remarks that they have had so far."""

    def __init__(self):
        self.statuses, self.remarks, self.threads = [], [], []

    def start(self, command, **streams):
        program = subprocess.Popen(command, stderr=subprocess.PIPE, **streams)
        self.follow(self.collect, program.stderr)
        return program

    def follow(self, work, *arguments):
        self.threads.append(threading.Thread(target=work, args=arguments, daemon=True))
        self.threads[-1].start()

    def collect(self, stream):
        self.remarks.append(stream.read().decode())

    def hand_on(self, source, sink=None):
        """Hands on whole lines, and keeps the statuses."""
        rest = b""
        while part := source.read(1 << 16):
            if sink:
                try:
                    sink.write(part)
                except OSError:
                    pass  # One that has ended hears no more.
            lines = (rest + part).split(b"\n")
            rest = lines.pop()
            self.statuses += (json.loads(line) for line in lines if b'"kind":"status"' in line)
        if sink:
            sink.close()

    def look_after(self):
        """Does what is to be done while they run."""

    def finish(self):
        """Waits until all is heard, once the node has ended."""
        if self.node.returncode:
            self.station.kill()
        self.station.wait()
        for thread in self.threads:
            thread.join()


class Pipes(Line):
    """Both on each other's stdin and stdout."""

    def __init__(self, program, run, emulate):
        super().__init__()
        pipes = {"stdin": subprocess.PIPE, "bufsize": 0}
        self.node = self.start([program, *run], stdout=subprocess.PIPE, **pipes)
        # What it sends goes straight to the node, as through a shell's pipe.
        self.station = self.start([program, *emulate], stdout=self.node.stdin, **pipes)
        self.node.stdin.close()
        self.follow(self.hand_on, self.node.stdout, self.station.stdin)


class Brokered(Line):
    """Both at a broker, and somebody there who hears the statuses."""

    def __init__(self, broker, program, run, emulate):
        super().__init__()
        self.listener = broker.subscriber("pickline/status")
        self.follow(self.hand_on, self.listener.stdout)
        nothing = {"stdin": subprocess.DEVNULL, "stdout": subprocess.DEVNULL}
        self.node = self.start([program, *run, "--mqtt", broker.url], **nothing)
        self.station = self.start([program, *emulate, "--mqtt", broker.url], **nothing)
        self.by_the_clock = "messages" not in run
        self.alone_since = None

    def look_after(self):
        """By the clock, the node waits for another station when one has gone."""
        if not self.by_the_clock or self.station.poll() is None:
            return
        self.alone_since = self.alone_since or time.monotonic()
        last = self.statuses[-1] if self.statuses else None
        is_done = last and not last["on_belt"] and not last["claimed"]
        if is_done or time.monotonic() - self.alone_since > PATIENCE:
            # Once: a second signal would end it on the spot.
            self.by_the_clock = False
            self.node.send_signal(signal.SIGTERM)

    def finish(self):
        until = time.monotonic() + PATIENCE
        while not (self.statuses and self.statuses[-1]["last"]) and time.monotonic() < until:
            if self.node.returncode:
                break
            time.sleep(0.05)
        self.listener.terminate()
        super().finish()
