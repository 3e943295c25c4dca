"""The Gymnasium environment."""

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

import pickline

ID = "pickline/Sorting-v0"


SORTING = pickline.Station("sorting")


@pytest.mark.parametrize(
    "options",
    [
        {},
        {"observation": "paper"},
        {
            "observation": "real",
            "station": SORTING,
            "patterns": pickline.patterns("random:60/min:5", SORTING, classes="pet:0.5,wood:0.5"),
        },
        {"wait": True, "slots": 4},
        {"grasp_success": 0.5, "update_hz": 10.0},
        {"outage": "r1:5..30", "outages": (60, 10)},
    ],
)
@pytest.mark.filterwarnings("error")
def test_the_checker_of_gymnasium_is_content(options):
    check_env(gymnasium.make(ID, **options).unwrapped)


def replay(strategy, seed, *, robots=2, **under):
    """Plays what `strategy` picks in the simulation through the environment."""
    station = pickline.Station("paper", robots=robots)
    patterns = pickline.patterns("poisson:0.15:4", station, items=60)
    env = gymnasium.make(
        ID, station=station, patterns=patterns, slots=64, reward=(2.0, 3.0), **under
    )
    line = env.unwrapped
    _, info = env.reset(seed=seed)
    run = pickline.simulate(station, line.pattern, strategy, seed=0, **under)
    attempts = len(run.picks) + len(run.failures)
    columns = ("robot", "item", "decide")
    both = [np.concatenate([getattr(run.picks, c), getattr(run.failures, c)]) for c in columns]
    order = np.lexsort((both[0], both[2]))
    total = 0.0
    for step, at in enumerate(order):
        robot, item, decide = (column[at] for column in both)
        assert (line.robot, line.time) == (robot, decide)
        items = line.slot_items
        assert info["action_mask"].sum() == len(items)
        action = np.flatnonzero(items == item)
        _, reward, terminated, truncated, info = env.step(action[0])
        total += reward
        assert terminated == (step == attempts - 1) and not truncated
    for name in run.picks.to_dict():
        assert getattr(line.picks, name).tobytes() == getattr(run.picks, name).tobytes(), name
    for name in ("items", "picked", "weight", "end", "picking_rate", "weighted_rate"):
        assert info[name] == getattr(run, name), name
    assert total == pytest.approx(2 * run.weight + 3 * run.weighted_rate, rel=1e-12)
    assert line.robot is None and line.time is None and len(line.slot_items) == 0


@pytest.mark.parametrize("strategy", ["SPT,FIFO", "LPT,SD", "FIFO,FIFO"])
def test_a_trajectory_is_that_of_the_simulation_to_the_bit(strategy):
    for seed in range(5):
        replay(strategy, seed)


def test_so_it_is_on_longer_lines_and_under_other_conditions():
    replay("SPT,PP,LD,FIFO", 3, robots=4)
    replay("SPT,FIFO", 2, update_hz=10.0)
    replay("SPT,FIFO", 2, camera_x=-0.5)


def test_the_end_of_an_episode_is_zero_and_allows_nothing():
    env = gymnasium.make(ID, patterns="grid:0.3", items=10).unwrapped
    _, info = env.reset(seed=1)
    for _ in range(100):
        observation, _, terminated, _, info = env.step(0)
        if terminated:
            break
    assert terminated and not observation.any()
    assert not info["action_mask"].any() and not env.action_masks().any()
    with pytest.raises(gymnasium.error.ResetNeeded, match="the episode is over"):
        env.step(0)
    _, info = env.reset()
    assert info["action_mask"].any()


def test_seeds_give_episodes():
    env = gymnasium.make(ID, patterns="poisson:0.2:50").unwrapped

    def episodes(seed):
        first, _ = env.reset(seed=seed)
        return [first, *(env.reset()[0] for _ in range(3))]

    assert np.array_equal(episodes(1), episodes(1))
    assert not np.array_equal(episodes(1), episodes(2))
    env.reset(seed=2**200 + 1)
    assert env.reset(seed=1)[0] in env.observation_space


def test_wrong_use_is_an_exception_and_changes_nothing():
    env = gymnasium.make(ID).unwrapped
    for call in (lambda: env.step(0), env.action_masks, lambda: env.pattern, lambda: env.picks):
        with pytest.raises(gymnasium.error.ResetNeeded):
            call()
    env.reset(seed=1)
    free = np.flatnonzero(~env.action_masks())[0]
    before = (env.robot, env.time, env.slot_items.tolist())
    for action, kind, words in [
        (free, ValueError, "slots hold an item\n  cure: choose an action"),
        (-1, ValueError, "out of range"),
        (16, ValueError, "out of range"),
        (2**70, ValueError, "out of range"),
        (0.0, TypeError, "not an integer"),
        (True, TypeError, "not an integer"),
        (None, TypeError, "not an integer"),
        (np.zeros(2, int), TypeError, "not an integer"),
    ]:
        with pytest.raises(kind, match=words):
            env.step(action)
        assert (env.robot, env.time, env.slot_items.tolist()) == before
    with pytest.raises(ValueError, match="unknown option 'pattern'"):
        env.reset(options={"pattern": 1})
    env.close()
    for call in (env.reset, lambda: env.step(0), env.action_masks, lambda: env.picks):
        with pytest.raises(gymnasium.error.ClosedEnvironmentError):
            call()


@pytest.mark.parametrize(
    ("options", "kind", "words"),
    [
        ({"observation": "ful"}, ValueError, "did you mean `full`"),
        ({"slots": 0}, ValueError, "0 slots"),
        ({"slots": 257}, ValueError, "give 1 to 256"),
        ({"reward": (np.nan, 1)}, ValueError, "not a finite number"),
        ({"reward": 1}, TypeError, "two numbers"),
        ({"patterns": []}, ValueError, "or there are none"),
        ({"patterns": [1]}, TypeError, "Pattern"),
        ({"patterns": pickline.Pattern([0], [9.0])}, ValueError, "beside"),
        ({"station": "papr"}, ValueError, "did you mean"),
        ({"update": 1}, TypeError, "update"),
        ({"render_mode": "film"}, ValueError, "human or rgb_array"),
    ],
)
def test_wrong_arguments_are_named(options, kind, words):
    with pytest.raises(kind, match=words):
        pickline.SortingEnv(**options)


def test_sampling_without_a_mask_is_legal():
    env = gymnasium.make(ID, patterns="grid:0.15").unwrapped
    env.reset(seed=1)
    env.action_space.seed(1)
    seen = set()
    for _ in range(300):
        action = env.action_space.sample()
        seen.add(int(action))
        _, _, terminated, _, _ = env.step(action)
        if terminated:
            env.reset()
    assert len(seen) > 2


@pytest.mark.parametrize("observation", ["full", "paper", "real"])
@pytest.mark.parametrize("name", pickline.Station.built_in())
def test_observations_are_in_a_finite_space(name, observation):
    """Rust's tests hold the bounds on all kinds of lines; this holds the space to them."""
    station = pickline.Station(name)
    shares = ",".join(f"{kind}:{0.9 / len(station.classes)}" for kind in station.classes)
    patterns = pickline.patterns("random:90/min:3", station, items=40, classes=shares or None)
    env = pickline.SortingEnv(
        station, patterns, observation=observation, wait=True, position_noise=0.01, camera_x=-0.5
    )
    space = env.observation_space
    assert np.isfinite(space.low).all() and np.isfinite(space.high).all()
    assert (space.low <= 0).all() and (space.high >= 0).all()
    env.action_space.seed(1)
    seen = 0
    for seed in range(3):
        observed, _ = env.reset(seed=seed)
        terminated = False
        while not terminated:
            assert observed in space
            seen += 1
            observed, _, terminated, _, _ = env.step(env.action_space.sample())
        assert observed in space
    assert seen > 60


def test_lines_of_one_station_have_one_space():
    spaces = [
        pickline.SortingEnv("paper", patterns, items=items).observation_space
        for patterns, items in [("grid:0.3", 10), ("poisson:0.12:5", 60)]
    ]
    assert spaces[0] == spaces[1]
    heavy = pickline.Pattern([-0.1, -0.2], [0.0, 0.1], weight=[1.0, 40.0])
    assert pickline.SortingEnv("paper", heavy).observation_space.high.max() > 40.0


def test_a_line_without_a_decision_is_refused():
    with pytest.raises(ValueError, match="no robot ever has an item to choose") as raised:
        pickline.SortingEnv("paper", "grid:0.3", outage=["r1:0..", "r2:0.."])
    assert "while it is not down" in str(raised.value)
