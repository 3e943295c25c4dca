"""Whatever Python hands over, there is a result or an exception of a documented class."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

import pickline
from pickline import _pickline

# The same cases every time; a failure is not a matter of luck.
settings.register_profile("pickline", derandomize=True, deadline=None, max_examples=60)
settings.load_profile("pickline")

# The plain model.
RIGHT = {
    "update_hz": 0.0,
    "camera_x": None,
    "min_detection": 0.0,
    "grasp_success": None,
    "position_noise": 0.0,
    "misdetections": False,
    "outage": [],
    "outages": None,
}

EXPECTED = (ValueError, TypeError, OSError, OverflowError)

numbers = st.one_of(st.integers(), st.floats(), st.integers(-3, 3), st.floats(-2, 2))
things = st.one_of(
    st.none(),
    st.booleans(),
    numbers,
    st.text(max_size=8),
    st.binary(max_size=8),
    st.lists(numbers, max_size=4),
    arrays.arrays(
        st.one_of(
            arrays.integer_dtypes(),
            arrays.floating_dtypes(),
            arrays.complex_number_dtypes(),
            arrays.unicode_string_dtypes(max_len=3),
            arrays.boolean_dtypes(),
        ),
        arrays.array_shapes(min_dims=0, max_dims=2, max_side=4),
    ),
)
columns = st.fixed_dictionaries(
    {},
    optional={
        name: things
        for name in (
            "id",
            "area_cm2",
            "p_detection",
            "p_grasp",
            "weight",
            "item_class",
            "true_class",
        )
    },
)


def attempt(call, *args, **options):
    """Calls it; returns None if it refuses with words."""
    try:
        return call(*args, **options)
    except EXPECTED as error:
        assert str(error)
        return None


@given(things, things, columns)
def test_patterns(x, y, rest):
    pattern = attempt(pickline.Pattern, x, y, **rest)
    if pattern is not None:
        assert len(pattern) > 0 and np.isfinite(pattern.x).all() and np.isfinite(pattern.y).all()
        assert pickline.Pattern.from_csv_text(pattern.to_csv()) == pattern


@given(things, things, st.one_of(things, st.integers(0, 50)))
def test_generated_patterns(width, spacing, items):
    attempt(pickline.Pattern.grid, width, spacing, items)


@given(st.text(max_size=12), things, things)
def test_stations(text, robots, belt_speed):
    attempt(pickline.Station, text, robots=robots, belt_speed=belt_speed)
    attempt(pickline.Station.from_toml, text, robots=robots)
    attempt(pickline.Station, "paper", robots=robots, belt_speed=belt_speed)


@given(things, things, things, things, things)
def test_simulate(strategy, seed, update_hz, grasp_success, noise):
    pattern = pickline.Pattern([0.0, -0.1], [0.0, 0.1])
    attempt(
        pickline.simulate,
        "paper",
        pattern,
        strategy,
        seed=seed,
        update_hz=update_hz,
        grasp_success=grasp_success,
        position_noise=noise,
    )


@given(things, things, things, things)
def test_environments(observation, slots, wait, reward):
    pattern = pickline.Pattern([0.0, -0.1], [0.0, 0.1])
    attempt(
        pickline.SortingEnv,
        "paper",
        pattern,
        observation=observation,
        slots=slots,
        wait=wait,
        reward=reward,
    )


@given(st.lists(things, max_size=5))
def test_actions(actions):
    pattern = pickline.Pattern([0.0, -0.1, -0.2], [0.0, 0.1, 0.2])
    one = pickline.SortingEnv("paper", pattern)
    one.reset(seed=1)
    many = pickline.SortingVectorEnv(2, "paper", pattern)
    many.reset(seed=1)
    for action in actions:
        result = attempt(one.step, action)
        if result is not None and result[2]:
            one.reset()
        attempt(many.step, action)


def test_buffers_of_other_sizes_and_kinds_are_refused():
    pattern = pickline.Pattern([0.0], [0.0])
    batch = _pickline.Batch(pickline.Station(), [pattern], RIGHT, "full", 16, False, (1.0, 1.0), 2)
    good = np.zeros((2, batch.observation_size), np.float32), np.zeros((2, 16), np.bool_)
    batch.reset(*good)
    for observations, masks in [
        (good[0][:1], good[1]),
        (good[0].astype(np.float64), good[1]),
        (good[0], good[1][:, :3]),
        (np.asfortranarray(good[0]), good[1]),
        (good[0].ravel(), good[1]),
        (good[1], good[1]),
    ]:
        with pytest.raises((ValueError, TypeError)):
            batch.reset(observations, masks)
    frozen = good[0].copy()
    frozen.flags.writeable = False
    with pytest.raises((ValueError, TypeError, RuntimeError)):
        batch.reset(frozen, good[1])
    with pytest.raises(ValueError, match="index"):
        batch.picks(2)


@given(*[things] * 8)
def test_the_rust_side_alone(station, patterns, rest, observation, slots, wait, reward, count):
    pattern = pickline.Pattern([0.0], [0.0])
    for given_ in (
        (station, patterns, rest, observation, slots, wait, reward, count),
        (pickline.Station(), [pattern], rest, "full", slots, wait, reward, count),
        (pickline.Station(), [pattern], RIGHT, "full", 4, False, (1.0, 1.0), count),
    ):
        if isinstance(count, int) and count > 1000:
            continue
        batch = attempt(_pickline.Batch, *given_)
        if batch is not None:
            for call in (batch.picks, batch.due, batch.items):
                attempt(call, slots)
            attempt(batch.reseed, slots, count)
            attempt(batch.reset, reward, rest)
            attempt(batch.step, patterns, reward)
            attempt(batch.advance, slots, reward, rest)
            attempt(batch.begin, reward, rest)


ENVIRONMENT = {"patterns": "grid:0.3", "items": 10}


@pytest.mark.parametrize(
    ("kind", "name", "call"),
    [
        (ValueError, "width", lambda: pickline.Pattern.grid(float("inf"), 0.15, 5)),
        (ValueError, "width", lambda: pickline.Pattern.grid(1e308, 0.15, 5)),
        (ValueError, "width", lambda: pickline.Pattern.grid(0, 0.15, 5)),
        (ValueError, "width", lambda: pickline.Pattern.poisson(-1, 0.15, 5)),
        (ValueError, "width", lambda: pickline.Pattern.poisson(float("nan"), 0.15, 5)),
        (TypeError, "width", lambda: pickline.Pattern.grid("a", 0.15, 5)),
        (ValueError, "items", lambda: pickline.Pattern.grid(1.05, 0.15, 0)),
        (ValueError, "items", lambda: pickline.Pattern.grid(1.05, 0.15, -1)),
        (TypeError, "items", lambda: pickline.Pattern.grid(1.05, 0.15, 2.5)),
        (ValueError, "robots", lambda: pickline.Station("paper", robots=-1)),
        (TypeError, "name", lambda: pickline.Station(3)),
        (TypeError, "station", lambda: pickline.SortingEnv(None)),
        (TypeError, "patterns", lambda: pickline.SortingEnv(patterns=None)),
        (TypeError, "patterns", lambda: pickline.SortingEnv(patterns=[1])),
        (TypeError, "observation", lambda: pickline.SortingEnv(**ENVIRONMENT, observation=None)),
        (TypeError, "wait", lambda: pickline.SortingEnv(**ENVIRONMENT, wait=3)),
        (TypeError, "reward", lambda: pickline.SortingEnv(**ENVIRONMENT, reward="x")),
        (TypeError, "reward", lambda: pickline.SortingEnv(**ENVIRONMENT, reward=(1,))),
        (ValueError, "reward", lambda: pickline.SortingEnv(**ENVIRONMENT, reward=(1e308, 1.0))),
        (ValueError, "slots", lambda: pickline.SortingEnv(**ENVIRONMENT, slots=-1)),
        (TypeError, "foo: there is no", lambda: pickline.SortingEnv(**ENVIRONMENT, foo=1)),
        (TypeError, "did you mean camera_x", lambda: pickline.SortingEnv(**ENVIRONMENT, camera=1)),
        (TypeError, "misdetections", lambda: pickline.SortingEnv(**ENVIRONMENT, misdetections=2)),
        (TypeError, "outages", lambda: pickline.SortingEnv(**ENVIRONMENT, outages=(300,))),
        (ValueError, "from_", lambda: pickline.sweep(from_=0.5, to=0.1)),
        (ValueError, "sweep", lambda: pickline.sweep(sweep="speeds")),
        (ValueError, "NUL", lambda: pickline.Pattern.from_csv("a\0b")),
        (TypeError, "station", lambda: pickline.Pattern.random(3, 20.0, 5)),
        (TypeError, "until", lambda: pickline.Wait("x")),
        (TypeError, "did you mean replicates", lambda: pickline.compare(replicate=3)),
        (TypeError, "did you mean patterns", lambda: pickline.optimize(pattern="grid:0.2")),
        (TypeError, "misdetections: ", lambda: pickline.optimize(misdetections=True)),
        (TypeError, "strategy", lambda: pickline.compare(strategy=5)),
        (TypeError, "pattern: 'grid:0.15'", lambda: pickline.simulate("paper", "grid:0.15")),
        (TypeError, "bound: ", lambda: pickline.compare(bound="no")),
        (TypeError, "alpha: ", lambda: pickline.optimize(alpha="x")),
        (TypeError, "cases: ", lambda: pickline.compare(cases=3)),
        (TypeError, "outage: ", lambda: pickline.SortingEnv(**ENVIRONMENT, outage=3)),
        (
            TypeError,
            "image_size",
            lambda: pickline.import_mot(
                "x", fps=5.0, scale=0.001, axis="x", belt_speed=0.1, image_size=(1,)
            ),
        ),
        (TypeError, "options", lambda: pickline.SortingEnv(**ENVIRONMENT).reset(options=3)),
        (TypeError, "num_envs", lambda: pickline.SortingVectorEnv("a", **ENVIRONMENT)),
        (TypeError, "num_envs", lambda: pickline.SortingVectorEnv(1.5, **ENVIRONMENT)),
        (ValueError, "num_envs", lambda: pickline.SortingVectorEnv(10**9, **ENVIRONMENT)),
        (ValueError, "seed", lambda: pickline.SortingVectorEnv(2, **ENVIRONMENT).reset(seed=-1)),
        (ValueError, "seed", lambda: pickline.SortingVectorEnv(2, **ENVIRONMENT).reset(seed=[1, -1])),
        (TypeError, "seed", lambda: pickline.SortingVectorEnv(2, **ENVIRONMENT).reset(seed="ab")),
        (TypeError, "seed", lambda: pickline.SortingVectorEnv(2, **ENVIRONMENT).reset(seed=1.5)),
    ],
)
def test_messages_name_the_argument_and_a_cure(kind, name, call):
    with pytest.raises(kind) as raised:
        call()
    assert name in str(raised.value) and "cure: " in str(raised.value), raised.value


def test_arrays_are_arguments_too():
    pattern = pickline.Pattern.grid(1.05, 0.15, 30)
    run = pickline.simulate("paper", pattern, outages=np.array([300, 20]))
    assert "outages=[300, 20]" in run.to_json()
    settings = dict(robust="SPT,FIFO", greedy=False, policy=False, bound=False)
    compared = pickline.compare("paper", np.array([pattern, pattern], object), **settings)
    assert "cases=<2 patterns>" in compared.to_json() and len(compared.runs) == 2


def test_results_are_read_only():
    run = pickline.simulate("paper", pickline.Pattern.grid(1.05, 0.15, 30))
    for values in (run.picks.decide, run.missed, run.robot_busy):
        with pytest.raises(ValueError, match="read-only"):
            values[:] = 0
    assert run.picks.to_pandas().release.max() <= run.end


def test_stations_are_given_by_name_too():
    line = pickline.Station("paper-narrow")
    assert pickline.Pattern.random("paper-narrow", 20.0, 5) == pickline.Pattern.random(line, 20.0, 5)
    named = pickline.patterns("grid:0.2", "paper-narrow", items=9)
    assert named == pickline.patterns("grid:0.2", line, items=9)


def test_masked_values_are_not_taken_for_values():
    masked = np.ma.array([-1.0, -2.0], mask=[False, True])
    for columns in ({"x": masked, "y": [0.0, 0.1]}, {"x": [-1.0, -2.0], "y": [0.0, 0.1], "weight": masked}):
        with pytest.raises(ValueError, match="some values are masked\n  cure: "):
            pickline.Pattern(**columns)
    whole = np.ma.array([-1.0, -2.0], mask=[False, False])
    assert pickline.Pattern(whole, [0.0, 0.1]).x.tolist() == [-1.0, -2.0]
