"""Progress of long calls, and what is handed over when they are interrupted."""

import builtins
import signal
import sys
import threading

import pytest

import pickline

STATION = pickline.Station("paper", robots=6)
LINE = pickline.Pattern.grid(STATION, 0.1, 300)

# Calls that take long enough to be seen.
LONG = {
    "compare": lambda progress: pickline.compare(
        replicates=300,
        robust="SPT,FIFO",
        strategy="lookahead",
        greedy=False,
        policy=False,
        bound=False,
        progress=progress,
    ),
    "sweep": lambda progress: pickline.sweep(
        robust="SPT,FIFO",
        strategy="lookahead",
        patterns="poisson:0.15:60",
        from_=0.03,
        to=0.08,
        step=0.01,
        bound=False,
        progress=progress,
    ),
    "optimize": lambda progress: pickline.optimize(
        STATION, "balanced:20", search="grasp", validate=0, bound=False, progress=progress
    ),
    "bound": lambda progress: pickline.bound(STATION, LINE, iterations=100_000, progress=progress),
}


class Stop:
    """Raises an exception when something is done of this stage."""

    def __init__(self, stage, raised):
        self.stage, self.raised, self.told = stage, raised, []

    def __call__(self, done, total, what):
        assert threading.current_thread() is threading.main_thread()
        self.told.append((done, total, what))
        if what.startswith(self.stage) and done >= 1:
            self.raised()


def raise_interrupt():
    raise KeyboardInterrupt


def send_signal():
    signal.raise_signal(signal.SIGINT)


@pytest.mark.parametrize("raised", [raise_interrupt, send_signal])
@pytest.mark.parametrize(
    ("name", "stage", "is_part"),
    [
        ("compare", "comparing", lambda found: 1 <= len(found.cases) < 4 and "cases" in found.partial),
        ("sweep", "sweeping", lambda found: len(set(found.points.value)) < 6 and found.partial),
        ("optimize", "GRASP", lambda found: found.stop_reason == "interrupted" and found.best),
        ("bound", "bounding", lambda found: found.stop_reason == "interrupted"),
    ],
)
def test_an_interrupted_call_hands_over_what_it_has(name, stage, is_part, raised):
    previous = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        stop = Stop(stage, raised)
        with pytest.raises(pickline.Interrupted) as stopped:
            LONG[name](stop)
    finally:
        signal.signal(signal.SIGINT, previous)
    assert isinstance(stopped.value, KeyboardInterrupt)
    assert is_part(stopped.value.partial), stopped.value.partial
    assert stopped.value.partial.to_csv() and repr(stopped.value.partial)
    # Nothing is told after the exception.
    assert stop.told[-1][0] >= 1 and all(done <= total for done, total, _ in stop.told)


def test_what_progress_raises_comes_out_as_itself():
    class Trouble(Exception):
        pass

    def trouble():
        raise Trouble("enough")

    with pytest.raises(Trouble, match="enough"):
        LONG["sweep"](Stop("sweeping", trouble))


def test_a_result_does_not_depend_on_who_watches():
    told = []
    settings = dict(replicates=40, robust="SPT,FIFO", strategy="lookahead", bound=False)
    watched = pickline.compare(progress=lambda *now: told.append(now), **settings)
    assert watched.to_json() == pickline.compare(**settings).to_json()
    whats = [what for _, _, what in told]
    assert "comparing [patterns]" in whats
    assert told == sorted(told, key=lambda now: (whats.index(now[2]), now[0]))
    pattern = pickline.Pattern.grid(1.05, 0.1, 600)
    told.clear()
    pickline.simulate("paper", pattern, bound=True, progress=lambda *now: told.append(now))


def test_a_bar_is_shown(capsys):
    pickline.compare(replicates=40, robust="SPT,FIFO", strategy="lookahead", progress=True)
    assert "comparing [patterns]" in capsys.readouterr().err


def test_without_tqdm_there_is_a_cure(monkeypatch):
    whole = builtins.__import__

    def without(name, *rest):
        if name.startswith("tqdm"):
            raise ImportError(name)
        return whole(name, *rest)

    for name in [name for name in sys.modules if name.startswith("tqdm")]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setattr(builtins, "__import__", without)
    with pytest.raises(ImportError, match="cure: pip install tqdm"):
        pickline.compare(progress=True)
