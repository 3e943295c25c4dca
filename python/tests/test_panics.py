"""A panic of the library is a RuntimeError in Python, and what it has left behind is not used again.

Builds with debug assertions have functions that panic on purpose; the wheel that is tested is one.
"""

import multiprocessing

import pytest

import pickline
from pickline import _pickline

GRID = pickline.Pattern.grid(1.05, 0.15, 20)


def test_the_build_can_panic():
    """Otherwise nothing here would be tested."""
    assert hasattr(_pickline, "_panic")


@pytest.mark.parametrize("message", ["fixed", "of 7 items", ""])
@pytest.mark.parametrize("kind", ["quick", "parallel", "scattered", "long"])
def test_a_panic_is_a_runtime_error(kind, message, capfd):
    with pytest.raises(BaseException) as raised:
        _pickline._panic(kind, message)
    assert type(raised.value) is RuntimeError
    said = {"fixed": "a fixed text", "": "it has no message"}.get(message, message)
    assert str(raised.value) == (
        f"pickline: a defect of the library: {said}\n  cure: report it with the call that led to it"
    )
    # Where it was, for the report.
    assert "defect.rs" in capfd.readouterr().err
    # The threads go on.
    assert pickline.simulate("paper", GRID, "SPT,FIFO").picked > 0
    swept = pickline.sweep(robust="SPT,FIFO", from_=0.03, to=0.04, step=0.01, bound=False)
    assert len(swept.points) == 2


def test_an_environment_is_unusable_after_a_panic():
    env, other = (pickline.SortingEnv("paper", GRID) for _ in range(2))
    env.reset(seed=1)
    other.reset(seed=1)
    with pytest.raises(RuntimeError, match="a defect of the library: in a step"):
        env._batch._panic()
    for call in (lambda: env.step(0), lambda: env.reset(), lambda: env.robot):
        with pytest.raises(RuntimeError, match="unusable after a defect .*\n  cure: make a new"):
            call()
    # Another one is not concerned.
    assert other.step(0)[1] > 0.0


def panicked(_):
    try:
        _pickline._panic("scattered", "in a child")
    except RuntimeError as error:
        return str(error)
    return "nothing"


@pytest.mark.filterwarnings("ignore:.*fork.*:DeprecationWarning")
@pytest.mark.parametrize("method", ["spawn", "fork"])
def test_so_it_is_in_a_child_process(method):
    with multiprocessing.get_context(method).Pool(1) as pool:
        assert "in a child" in pool.map(panicked, [0])[0]
